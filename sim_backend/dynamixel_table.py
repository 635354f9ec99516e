"""The control table of a Dynamixel: the rules of reading and writing it.

Rules and error numbers: ROBOTIS e-Manual, Protocol 2.0, status packet. What a manual leaves open: a hole
inside a block of registers reads as 0, and a write through indirect data must cover whole registers too.
"""

from collections.abc import Iterator
from enum import IntEnum
from typing import NamedTuple

from hal.register_map import Access, Memory, Register, ServoModel
from sim_backend.control_table import ControlTable

_LARGEST_HOLE = 32  # bytes; a wider one ends the block of registers
_INDIRECT_ADDRESS = "indirect_address_"
_INDIRECT_DATA = "indirect_data_"
_NOWHERE = 1 << 16  # behind the last address


class ErrorNumber(IntEnum):
    """Why a servo refuses an instruction."""

    RESULT_FAIL = 1
    INSTRUCTION = 2
    CRC = 3
    DATA_RANGE = 4
    DATA_LENGTH = 5
    DATA_LIMIT = 6
    ACCESS = 7


class OperatingMode(IntEnum):
    """What the servo controls."""

    CURRENT = 0
    VELOCITY = 1
    POSITION = 3
    EXTENDED_POSITION = 4
    CURRENT_BASED_POSITION = 5
    PWM = 16


class StatusError(Exception):
    """An instruction is refused; the status packet reports `number`."""

    def __init__(self, number: ErrorNumber) -> None:
        super().__init__(number.name)
        self.number = number


class Assignment(NamedTuple):
    """One register and the value to be written to it."""

    register: Register
    value: int


class DynamixelTable(ControlTable):
    """The bytes of one servo, as far as its user may reach them."""

    def __init__(self, model: ServoModel) -> None:
        self._starts = {r.address: r for r in model.registers}
        self._occupied = frozenset(a for r in model.registers for a in range(r.address, r.end))
        self._blocks = tuple(_blocks(model.registers))
        self._pointers = _pointers(model)  # address of an indirect data byte: address of its pointer
        self._first_pointed = min(self._pointers, default=_NOWHERE)
        self._measures_current = "current_limit" in model.by_name
        self._limits_acceleration = "acceleration_limit" in model.by_name
        self._goal_limits: dict[str, tuple[int, int]] | None = None  # by the EEPROM's registers of now
        super().__init__(model)

    def assign(self, register: Register, value: int) -> None:
        """Set a register as its user does."""
        self[register.name] = value
        if register.memory is Memory.EEPROM:
            self._goal_limits = None

    def restore_defaults(self, memory: Memory) -> None:
        """Set all registers of one memory as the factory does; those without a default become 0."""
        super().restore_defaults(memory)
        self._goal_limits = None

    def read(self, address: int, length: int) -> bytes:
        """Return raw bytes.

        Raises:
            StatusError: the range leaves the table, or is empty.
        """
        end = address + length
        if length == 0:
            raise StatusError(ErrorNumber.DATA_LENGTH)
        if not any(first <= address and end <= last for first, last in self._blocks):
            raise StatusError(ErrorNumber.ACCESS)
        if end <= self._first_pointed:
            return bytes(self.data[address:end])
        return bytes(self.data[self._target(at)] for at in range(address, end))

    def check(self, address: int, data: bytes) -> list[Assignment]:
        """Return what a write of raw bytes assigns; nothing is written yet.

        Raises:
            StatusError: any part of it is refused.
        """
        if not data:
            raise StatusError(ErrorNumber.DATA_LENGTH)
        assignments = []
        for start, piece in self._resolve(address, data):
            at = 0
            while at < len(piece):
                register = self._whole_register(start + at, len(piece) - at)
                value = int.from_bytes(piece[at:at + register.size], "little", signed=register.signed)
                self._check_value(register, value)
                assignments.append(Assignment(register, value))
                at += register.size
        return assignments

    def store(self, assignments: list[Assignment]) -> None:
        """Write what `check` has allowed."""
        for register, value in assignments:
            self.assign(register, value)

    def _target(self, address: int) -> int:
        pointer = self._pointers.get(address)
        return address if pointer is None else int.from_bytes(self.data[pointer:pointer + 2], "little")

    def _resolve(self, address: int, data: bytes) -> Iterator[tuple[int, bytes]]:
        """Split a write into runs of neighbouring bytes, each behind its pointer if it has one."""
        if address + len(data) <= self._first_pointed:
            yield address, data
            return
        targets = [self._target(at) for at in range(address, address + len(data))]
        begin = 0
        for index in range(1, len(targets) + 1):
            if index == len(targets) or targets[index] != targets[index - 1] + 1:
                yield targets[begin], data[begin:index]
                begin = index

    def _whole_register(self, address: int, available: int) -> Register:
        register = self._starts.get(address)
        if register is None:
            inside = address in self._occupied
            raise StatusError(ErrorNumber.DATA_LENGTH if inside else ErrorNumber.ACCESS)
        if register.size > available:
            raise StatusError(ErrorNumber.DATA_LENGTH)
        return register

    def _check_value(self, register: Register, value: int) -> None:
        locked = register.memory is Memory.EEPROM and self["torque_enable"]
        if register.access is Access.READ or locked:
            raise StatusError(ErrorNumber.ACCESS)
        if register.range is not None and not register.range[0] <= value <= register.range[1]:
            raise StatusError(ErrorNumber.DATA_RANGE)
        if register.choices is not None and value not in register.choices:
            raise StatusError(ErrorNumber.DATA_RANGE)
        if self._goal_limits is None:
            self._goal_limits = self._limits_of_goals()
        limits = self._goal_limits.get(register.name)
        if limits is not None and not limits[0] <= value <= limits[1]:
            raise StatusError(ErrorNumber.DATA_LIMIT)

    def _limits_of_goals(self) -> dict[str, tuple[int, int]]:
        """Return what the user has set as limits of the goals."""
        speed, pwm = self["velocity_limit"], self["pwm_limit"]
        limits = {"goal_velocity": (-speed, speed), "goal_pwm": (-pwm, pwm)}
        if self._measures_current:
            limits["goal_current"] = -self["current_limit"], self["current_limit"]
        if self._limits_acceleration:
            limits["profile_acceleration"] = 0, self["acceleration_limit"]
        if self["operating_mode"] == OperatingMode.POSITION:
            limits["goal_position"] = self["min_position_limit"], self["max_position_limit"]
        return limits


def _blocks(registers: tuple[Register, ...]) -> Iterator[tuple[int, int]]:
    """Yield the first address of each block of registers, and the one behind its last."""
    rows = sorted(registers, key=lambda register: register.address)
    first, end = rows[0].address, rows[0].end
    for row in rows[1:]:
        if row.address - end > _LARGEST_HOLE:
            yield first, end
            first = row.address
        end = row.end
    yield first, end


def _pointers(model: ServoModel) -> dict[int, int]:
    return {
        register.address: model[_INDIRECT_ADDRESS + register.name.removeprefix(_INDIRECT_DATA)].address
        for register in model.registers if register.name.startswith(_INDIRECT_DATA)
    }
