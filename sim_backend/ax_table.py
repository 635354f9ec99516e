"""The control table of a Dynamixel AX: the rules of reading and writing it.

Error bits: ROBOTIS e-Manual, Protocol 1.0. What no manual states is decided here, in one place:

- A write is refused as a whole, and then nothing is written.
- A part of a register may be written: the table is a memory of bytes. Holes take what they are given, and forget it.
- Reading or writing beyond the table, writing what is read-only or locked, and a negative moving speed in joint mode,
  are range errors.
"""

from collections.abc import Iterable
from enum import IntFlag
from typing import NamedTuple

from hal.register_map import Access, Memory, Register, ServoModel
from sim_backend.control_table import ControlTable


class Refusal(IntFlag):
    """Bits of the error byte that say why an instruction is refused."""

    ANGLE_LIMIT = 0x02
    RANGE = 0x08
    CHECKSUM = 0x10
    INSTRUCTION = 0x40


class RefusedError(Exception):
    """An instruction is refused; the status packet has `bits` in its error byte."""

    def __init__(self, bits: Refusal) -> None:
        super().__init__(str(bits))
        self.bits = bits


class Assignment(NamedTuple):
    """One register and the value to be written to it."""

    register: Register
    value: int


class AxTable(ControlTable):
    """The bytes of one servo, as far as its user may reach them."""

    def __init__(self, model: ServoModel) -> None:
        super().__init__(model)
        self._by_byte = {at: register for register in model.registers for at in range(register.address, register.end)}

    @property
    def wheel_mode(self) -> bool:
        """Whether it turns without end."""
        return not self["cw_angle_limit"] and not self["ccw_angle_limit"]

    def read(self, address: int, length: int) -> bytes:
        """Return raw bytes.

        Raises:
            RefusedError: they are not all there, or none is asked for.
        """
        if not length or address + length > len(self.data):
            raise RefusedError(Refusal.RANGE)
        return bytes(self.data[address:address + length])

    def check(self, address: int, data: bytes) -> list[Assignment]:
        """Return what a write of raw bytes assigns; nothing is written yet.

        Raises:
            RefusedError: any part of it is refused.
        """
        end = address + len(data)
        if not data or end > len(self.data):
            raise RefusedError(Refusal.RANGE)
        image = bytearray(self.data)
        image[address:end] = data
        assignments: list[Assignment] = []
        for register in map(self._by_byte.get, range(address, end)):
            if register is not None and not (assignments and assignments[-1].register is register):
                assignments.append(Assignment(register, self.decode(register.name, image)))
                self._check_value(*assignments[-1])
        return assignments

    def store(self, assignments: Iterable[Assignment]) -> None:
        """Write what `check` has allowed."""
        for register, value in assignments:
            self.assign(register, value)

    def _check_value(self, register: Register, value: int) -> None:
        if register.access is Access.READ or not _fits(register, value):
            raise RefusedError(Refusal.RANGE)
        if self["eeprom_lock"] and (register.memory is Memory.EEPROM or register.name == "eeprom_lock"):
            raise RefusedError(Refusal.RANGE)
        if self.wheel_mode:
            return
        if register.name == "moving_speed" and value < 0:
            raise RefusedError(Refusal.RANGE)
        if register.name == "goal_position" and not self["cw_angle_limit"] <= value <= self["ccw_angle_limit"]:
            raise RefusedError(Refusal.ANGLE_LIMIT)


def _fits(register: Register, value: int) -> bool:
    if register.range is not None and not register.range[0] <= value <= register.range[1]:
        return False
    return register.choices is None or value in register.choices
