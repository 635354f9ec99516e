"""The firmware of a Dynamixel, from instructions to its registers: what they do when they are written."""

import struct

from hal.register_map import Memory
from sim_backend.dynamixel_core import DynamixelCore
from sim_backend.dynamixel_table import Assignment, ErrorNumber, OperatingMode, StatusError

_GOAL_BY_MODE: dict[int, str] = {  # in the other modes it is the position
    OperatingMode.CURRENT: "goal_current", OperatingMode.VELOCITY: "goal_velocity", OperatingMode.PWM: "goal_pwm"}
_GOALS = {"goal_position", *_GOAL_BY_MODE.values()}
_KEPT_BY_RESET = {  # by the option of a factory reset (e-Manual, Protocol 2.0)
    0xFF: (), 0x01: ("id",), 0x02: ("id", "baud_rate")}
_TICK_PERIOD = 1 << 15  # realtime_tick, ms


class DynamixelServo(DynamixelCore):
    """A Dynamixel of the X series."""

    def hear(self, now: int) -> None:
        """Note that an instruction, to whomever, came over the bus."""
        self._watch_bus(now)
        self._heard_at = now

    def identify(self) -> bytes:
        """Return what a ping tells: model number and firmware version."""
        return struct.pack("<HB", self.table["model_number"], self.table["firmware_version"])

    def read(self, address: int, length: int, now: int) -> bytes:
        """Return bytes of the control table.

        Raises:
            StatusError: they are not there.
        """
        self._sense()
        if address < self._clock.end and self._clock.address < address + length:
            self.table[self._clock.name] = (now - self._started_at) // 1_000_000 % _TICK_PERIOD
        return self.table.read(address, length)

    def write(self, address: int, data: bytes, *, ram_only: bool = False) -> None:
        """Write bytes to the control table, or to its RAM only, and act on them.

        Raises:
            StatusError: refused; nothing is written.
        """
        assignments = self._check(address, data, ram_only)
        self.table.store(assignments)
        for register, value in assignments:
            self._react(register.name, value)

    def register_write(self, address: int, data: bytes, *, ram_only: bool = False) -> None:
        """Keep a write for `action`.

        Raises:
            StatusError: refused; an earlier one stays.
        """
        self._check(address, data, ram_only)
        self._registered = address, data
        self.table["registered_instruction"] = 1

    def action(self) -> None:
        """Carry out the write that was kept.

        Raises:
            StatusError: there is none, or it is refused by now.
        """
        if self._registered is None:
            raise StatusError(ErrorNumber.INSTRUCTION)
        address, data = self._registered
        self._registered = None
        self.table["registered_instruction"] = 0
        self.write(address, data)

    def clear_turns(self) -> None:
        """Bring the position to within one turn, and hold it.

        Raises:
            StatusError: the shaft moves.
        """
        self._sense()
        if self.table["moving"]:
            raise StatusError(ErrorNumber.RESULT_FAIL)
        self._fold()
        self._hold_here()
        self._restart()

    def store_backup(self) -> None:
        """Keep a copy of the control table.

        Raises:
            StatusError: torque is on.
        """
        if self._torque:
            raise StatusError(ErrorNumber.RESULT_FAIL)
        self._backup.store(self.model, self.table)
        self.table["backup_ready"] = 1

    def restore_backup(self, now: int) -> None:
        """Take the copy of the EEPROM and of the RAM back, and start afresh.

        Raises:
            StatusError: torque is on, or there is no copy.
        """
        if self._torque or not self._backup.ready:
            raise StatusError(ErrorNumber.RESULT_FAIL)
        self._backup.restore(self.model, self.table, Memory.EEPROM)
        self.reboot(now)
        self._backup.restore(self.model, self.table, Memory.RAM)
        self._configure()

    def factory_reset(self, option: int, now: int) -> None:
        """Go back to the factory's settings, but for what the option keeps, and start afresh.

        Raises:
            StatusError: there is no such option.
        """
        if option not in _KEPT_BY_RESET:
            raise StatusError(ErrorNumber.DATA_RANGE)
        kept = {name: self.table[name] for name in ("firmware_version", *_KEPT_BY_RESET[option])}
        self.table.restore_defaults(Memory.EEPROM)
        for name, value in kept.items():
            self.table[name] = value
        self.reboot(now)

    def _check(self, address: int, data: bytes, ram_only: bool) -> list[Assignment]:
        assignments = self.table.check(address, data)
        if ram_only and any(register.memory is Memory.EEPROM for register, _ in assignments):
            raise StatusError(ErrorNumber.ACCESS)
        if self._tripped and any(
            register.name in _GOALS or (register.name == "bus_watchdog" and value)
            for register, value in assignments
        ):
            raise StatusError(ErrorNumber.DATA_RANGE)
        return assignments

    def _react(self, name: str, value: int) -> None:
        """Act on a register just written."""
        if name in _GOALS:
            self._take_goal(name)
        elif name == "torque_enable" and value and not self._torque:
            self._torque_on()
        elif name == "operating_mode" and value != self._mode:
            self._change_mode()
        else:
            self._configure()

    def _take_goal(self, name: str) -> None:
        aims = name == _GOAL_BY_MODE.get(self._mode, "goal_position")
        if aims and self._torque_by_goal and not self._torque:
            self._torque_on(keep_goal=True)
        elif name in {"goal_pwm", "goal_current"}:
            self._load()
        elif aims and self._torque:
            self._aim()
