"""The firmware of a Dynamixel: what its registers do when they are written, and its protections.

Not modelled: blinking LEDs, backup and restore of the control table, servos without power.
"""

import struct

from hal.register_map import DynamixelFirmware, Memory
from sim_backend.control_table import Window
from sim_backend.dynamixel_motion import DynamixelMotion
from sim_backend.dynamixel_table import Assignment, DynamixelTable, ErrorNumber, OperatingMode, StatusError
from sim_backend.fake_servo import FakeServo
from sim_backend.servo_physics import ServoPhysics

ALERT = 0x80  # in the error byte of every status while a hardware error lasts
INPUT_VOLTAGE, OVERHEATING, OVERLOAD = 0x01, 0x04, 0x20  # bits of hardware_error_status and of shutdown

_TORQUE_ON_BY_GOAL = 0x08  # bit of drive_mode
_TORQUE_ON_AT_START = 0x01  # bit of startup_configuration
_NO_SECONDARY_ID = 0xFF
_WATCHDOG_TRIPPED = 0xFF
_ONGOING, _SHAPE = 1, 4  # shifts in moving_status, whose lowest bit means arrived; none for following errors
_GOALS = ("goal_position", "goal_velocity", "goal_pwm", "goal_current")
_SET_BY_MODE = (  # back to default when the operating mode changes
    "velocity_i_gain", "velocity_p_gain", "position_d_gain", "position_i_gain", "position_p_gain",
    "feedforward_2nd_gain", "feedforward_1st_gain", "profile_acceleration", "profile_velocity")
_KEPT_BY_RESET = {  # by the option of a factory reset (e-Manual, Protocol 2.0)
    0xFF: (), 0x01: ("id",), 0x02: ("id", "baud_rate")}
_NS = 1_000_000_000
_TICK_PERIOD = 1 << 15  # realtime_tick, ms


class DynamixelServo(FakeServo):
    """A Dynamixel of the X series.

    Attributes:
        secondary_id: what it also obeys, in silence.
        status_return_level: what it answers at all.
        alert: `ALERT` while a hardware error lasts, else 0.
        fast_sync_read: whether its firmware has that instruction.
    """

    table: DynamixelTable

    def __init__(self, physics: ServoPhysics, index: int, **factory_settings: int) -> None:
        """Make the servo of one entry of `physics`, new but for some registers of the EEPROM."""
        model = physics.models[index]
        if not isinstance(model.firmware, DynamixelFirmware):
            raise ValueError(f"{model.name} is not a Dynamixel")  # noqa: TRY004 (a wrong model, not a wrong type)
        super().__init__(physics, index, DynamixelTable(model))
        self._firmware = model.firmware
        self._set_up({"firmware_version": self._firmware.version, **factory_settings})
        self._motion = DynamixelMotion(model, self._firmware, self.table)
        self._watchdog_unit_ns = round(model["bus_watchdog"].scale * 1e6)  # from ms
        self._clock = model["realtime_tick"]
        self._measures_current = model.cyclic.effort == "present_current"
        self._registered: tuple[int, bytes] | None = None
        self._window = Window(model, (
            "moving", "moving_status", "present_pwm", model.cyclic.effort, "present_velocity", "present_position",
            "velocity_trajectory", "position_trajectory", "present_input_voltage", "present_temperature"))
        self._run()

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

    def write(self, address: int, data: bytes) -> None:
        """Write bytes to the control table, and act on them.

        Raises:
            StatusError: refused; nothing is written.
        """
        assignments = self._check(address, data)
        self.table.store(assignments)
        for register, value in assignments:
            self._react(register.name, value)

    def register_write(self, address: int, data: bytes) -> None:
        """Keep a write for `action`.

        Raises:
            StatusError: refused; an earlier one stays.
        """
        self._check(address, data)
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

    def _reset(self) -> None:
        self.table.restore_defaults(Memory.RAM)
        self._set_goals_by_mode()
        self._registered = None
        self._sensed = None
        self.alert = 0
        self._configure()

    def _start(self, now: int) -> None:
        self._started_at = self._heard_at = self._relaxed_at = now
        self._fold()
        self._hold_here()
        if self.table["startup_configuration"] & _TORQUE_ON_AT_START:
            self._torque_on()

    def _show(self, present: list[int]) -> None:
        moving, arrived, in_profile, shape, *values = present
        status = arrived | in_profile << _ONGOING | shape << _SHAPE
        duty, load, speed, position, goal_speed, goal_position, current, supply, temperature = values
        effort = current if self._measures_current else load
        self._window.store(self.table, (
            moving, status, duty, effort, speed, position, goal_speed, goal_position, supply, temperature))

    def _check(self, address: int, data: bytes) -> list[Assignment]:
        assignments = self.table.check(address, data)
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
        if self._torque_by_goal and not self._torque:
            self._torque_on(keep_goal=True)
        elif name in {"goal_pwm", "goal_current"}:
            self._load()
        elif self._torque and (name == "goal_velocity") == (self._mode == OperatingMode.VELOCITY):
            self._aim()

    def _configure(self) -> None:
        """Take over settings that are looked at often, and the motor's."""
        table = self.table
        self._configure_line()
        self.secondary_id = table["secondary_id"] if table["secondary_id"] != _NO_SECONDARY_ID else None
        self.status_return_level = table["status_return_level"]
        first = self.model.fast_sync_read_firmware
        self.fast_sync_read = first is not None and table["firmware_version"] >= first
        self._mode = table["operating_mode"]
        self._torque = bool(table["torque_enable"])
        self._torque_by_goal = bool(table["drive_mode"] & _TORQUE_ON_BY_GOAL)
        self._temperature_limit = table["temperature_limit"]
        unit = self.model["present_input_voltage"].scale  # V; a limit is passed by half a count
        self._lowest_v = unit * (table["min_voltage_limit"] - 0.5)
        self._highest_v = unit * (table["max_voltage_limit"] + 0.5)
        watchdog = table["bus_watchdog"]
        self._tripped = watchdog == _WATCHDOG_TRIPPED
        self._watchdog_ns = 0 if self._tripped else watchdog * self._watchdog_unit_ns
        self._load()

    def _load(self) -> None:
        """Hand the motor's settings over. A profile applies from the next goal on."""
        self._motion.configure(self._turned)
        self._physics.load(self._index, self._motion.drive(), self._motion.scales())

    def _aim(self) -> None:
        """Head for the goal registers from where the trajectory is."""
        physics, index, motion = self._physics, self._index, self._motion
        if motion.has_profile:
            physics.follow(index, motion.profile(*physics.trajectory(index)))
        elif self._mode == OperatingMode.VELOCITY:
            position, _ = physics.trajectory(index)
            physics.jump(index, position, motion.goal_speed())
        else:
            physics.jump(index, motion.goal_position())

    def _restart(self) -> None:
        """Start from rest where the shaft is, as when torque comes on."""
        self._physics.rest(self._index)
        self._configure()
        self._aim()

    def _fold(self) -> None:
        """Bring the position to within one turn."""
        self._take_off_turns(self._motion.sign, self.model.encoder.centre)
        self._load()

    def _torque_on(self, keep_goal: bool = False) -> None:
        failed = self.table["hardware_error_status"] & self.table["shutdown"]
        self.table["torque_enable"] = 0 if failed else 1
        if not failed and self._mode == OperatingMode.POSITION:
            self._fold()
        if not failed and self._firmware.goal_follows_present and not keep_goal:
            self._hold_here()
        self._restart()

    def _change_mode(self) -> None:
        for name in _SET_BY_MODE:
            self.table[name] = self.model[name].default or 0
        self._set_goals_by_mode()
        self._configure()
        if self._mode == OperatingMode.POSITION:
            self._fold()

    def _set_goals_by_mode(self) -> None:
        """Goal PWM is the whole goal in PWM mode, else a bound; so is goal current in current mode."""
        mode = self.table["operating_mode"]
        self.table["goal_pwm"] = 0 if mode == OperatingMode.PWM else self.table["pwm_limit"]
        self.table["goal_velocity"] = 0
        if self._measures_current:
            self.table["goal_current"] = 0 if mode == OperatingMode.CURRENT else self.table["current_limit"]

    def _hold_here(self) -> None:
        self._sense()
        self.table["goal_position"] = self.table["present_position"]

    def _watch_bus(self, now: int) -> None:
        """Stop, without letting go, if no instruction came for too long."""
        if not self._watchdog_ns or not self._torque or now - self._heard_at <= self._watchdog_ns:
            return
        self.table["bus_watchdog"] = _WATCHDOG_TRIPPED
        self.table["goal_velocity"] = 0
        if self._mode == OperatingMode.PWM:
            self.table["goal_pwm"] = 0
        if self._mode == OperatingMode.CURRENT:
            self.table["goal_current"] = 0
        self._hold_here()
        self._restart()

    def _supervise(self, now: int, duty: float, current: float, supply_v: float, temperature_c: float) -> None:
        straining = abs(duty) > self._firmware.overload_duty
        hot = temperature_c > self._temperature_limit
        starved = not self._lowest_v <= supply_v <= self._highest_v
        if not straining:
            self._relaxed_at = now
        if not (straining or hot or starved or self._watchdog_ns) and self._awake:
            return
        if not self._is_awake(now):
            return
        self._watch_bus(now)
        overloaded = now - self._relaxed_at >= self._firmware.overload_s * _NS
        faults = overloaded * OVERLOAD | hot * OVERHEATING | starved * INPUT_VOLTAGE
        if faults & ~self.table["hardware_error_status"]:
            self._fail(faults)

    def _fail(self, faults: int) -> None:
        """Report faults until the next reboot, and let go if the user has chosen so."""
        self.table["hardware_error_status"] |= faults
        self.alert = ALERT
        if self.table["hardware_error_status"] & self.table["shutdown"]:
            self.table["torque_enable"] = 0
            self._configure()
