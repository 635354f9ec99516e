"""The firmware of a Dynamixel, from its registers to its motor: start-up, modes, profiles, protections.

Not modelled: blinking LEDs, the PWM slope (stored without effect); the protocols of remote controls, so that a protocol
type of 20 or more makes a servo deaf.
"""

from hal.register_map import DynamixelFirmware, Memory
from sim_backend.control_table import Window
from sim_backend.dynamixel_backup import TableBackup
from sim_backend.dynamixel_motion import DynamixelMotion
from sim_backend.dynamixel_table import DynamixelTable, OperatingMode
from sim_backend.fake_servo import FakeServo
from sim_backend.servo_physics import ServoPhysics

ALERT = 0x80  # in the error byte of every status while a hardware error lasts
# Bits of hardware_error_status and of shutdown.
INPUT_VOLTAGE, OVERHEATING, ENCODER, SHOCK, OVERLOAD = 0x01, 0x04, 0x08, 0x10, 0x20

_TORQUE_ON_BY_GOAL = 0x08  # bit of drive_mode
_TORQUE_ON_AT_START, _BACKUP_AT_START = 0x01, 0x02  # bits of startup_configuration
_NO_SECONDARY_ID = 253  # and above
_KEEPS_OWN_ID = 42  # the first firmware that refuses to lose it together with all others (e-Manual, Factory Reset)
_WATCHDOG_TRIPPED = 0xFF
_ONGOING, _FOLLOWING_ERROR, _SHAPE = 1, 3, 4  # shifts in moving_status, whose lowest bit means arrived
_SET_BY_MODE = (  # back to default when the operating mode changes
    "velocity_i_gain", "velocity_p_gain", "position_d_gain", "position_i_gain", "position_p_gain",
    "feedforward_2nd_gain", "feedforward_1st_gain", "profile_acceleration", "profile_velocity")
_NS = 1_000_000_000


class DynamixelCore(FakeServo):
    """A Dynamixel of the X series, without the instructions.

    Attributes:
        secondary_id: what it also obeys, in silence.
        status_return_level: what it answers at all.
        alert: `ALERT` while a hardware error lasts, else 0.
        fast_sync_read: whether its firmware has that instruction, and fast bulk read.
        keeps_backup: whether its firmware has control table backup.
        keeps_own_id: whether it refuses a reset that would give all servos of a bus one id.
        protocol: which it speaks: 1 or 2; beyond, one that is none of a bus.
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
        self._newest, self._backup = model, TableBackup()
        self._registered: tuple[int, bytes] | None = None
        self._equip()
        self._run()

    def run_firmware(self, version: int) -> None:
        """Have another version of the firmware, and the registers that it has."""
        self.table["firmware_version"] = version
        self._equip()
        self._configure()

    def _equip(self) -> None:
        """Take the registers of the firmware's version; those that it shares with the one before keep their values."""
        before, table = self.model, self.table
        model = self.model = self._newest.at_firmware(table["firmware_version"])
        if model is not before:
            self.table = DynamixelTable(model)
            for register in model.registers:
                if register == before.by_name.get(register.name):
                    self.table[register.name] = table[register.name]
        self._motion = DynamixelMotion(model, self._firmware, self.table)
        self._clock = model["realtime_tick"]
        self._measures_current = model.cyclic.effort == "present_current"
        self._window = Window(model, (
            "moving", "moving_status", "present_pwm", model.cyclic.effort, "present_velocity", "present_position",
            "velocity_trajectory", "position_trajectory", "present_input_voltage", "present_temperature"))

    def _reset(self) -> None:
        self.table.restore_defaults(Memory.RAM)
        self._set_goals_by_mode()
        if self._startup & _BACKUP_AT_START:
            self._backup.restore(self.model, self.table, Memory.RAM)
        if self._backup.ready:
            self.table["backup_ready"] = 1
        self._registered = None
        self._sensed = None
        self.alert = 0
        self._configure()

    def _start(self, now: int) -> None:
        self._started_at = self._heard_at = self._relaxed_at = now
        self._fold()
        self._hold_here()
        if self._startup & _TORQUE_ON_AT_START:
            self._torque_on()

    @property
    def _startup(self) -> int:
        return self.table["startup_configuration"] if "startup_configuration" in self.model.by_name else 0

    def lose_power(self, now: int, seconds: float) -> None:
        """Be without power for so long, then start: limp and deaf at once, back after both."""
        super().lose_power(now, seconds)
        if seconds and self._firmware.shock_at_power_up:
            self._fail(SHOCK)

    def _show(self, present: list[int]) -> None:
        moving, arrived, in_profile, shape, *values = present
        duty, load, speed, position, goal_speed, goal_position, current, supply, temperature = values
        effort = current if self._measures_current else load
        astray = self._torque and abs(goal_position - position) > self._firmware.following_error_ticks
        status = arrived | in_profile << _ONGOING | astray << _FOLLOWING_ERROR | shape << _SHAPE
        self._window.store(self.table, (
            moving, status, duty, effort, speed, position, goal_speed, goal_position, supply, temperature))

    def _configure(self) -> None:
        """Take over settings that are looked at often, and the motor's."""
        table = self.table
        self._configure_line()
        self.secondary_id = table["secondary_id"] if table["secondary_id"] < _NO_SECONDARY_ID else None
        self.status_return_level = table["status_return_level"]
        self.protocol = table["protocol_type"]
        self.fast_sync_read = self._reaches(self.model.fast_sync_read_firmware)
        self.keeps_backup = self._reaches(self.model.backup_firmware)
        self.keeps_own_id = self._reaches(_KEEPS_OWN_ID)
        self._mode = table["operating_mode"]
        self._torque = bool(table["torque_enable"])
        self._torque_by_goal = bool(table["drive_mode"] & _TORQUE_ON_BY_GOAL)
        self._temperature_limit = table["temperature_limit"]
        unit = self.model["present_input_voltage"].scale  # V; a limit is passed by half a count
        self._lowest_v = unit * (table["min_voltage_limit"] - 0.5)
        self._highest_v = unit * (table["max_voltage_limit"] + 0.5)
        watchdog = self.model.by_name.get("bus_watchdog")
        count = table["bus_watchdog"] if watchdog else 0
        self._tripped = count == _WATCHDOG_TRIPPED
        self._watchdog_ns = round(count * watchdog.si_scale * _NS) if watchdog and not self._tripped else 0
        self._load()

    def _reaches(self, version: int | None) -> bool:
        return version is not None and self.table["firmware_version"] >= version

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
        """Stop if no instruction came for too long."""
        if not self._watchdog_ns or not self._torque or now - self._heard_at <= self._watchdog_ns:
            return
        self.table["bus_watchdog"] = _WATCHDOG_TRIPPED
        self.table["goal_velocity"] = 0
        if self._mode == OperatingMode.PWM:
            self.table["goal_pwm"] = 0
        if self._mode == OperatingMode.CURRENT:
            self.table["goal_current"] = 0
        if not self._firmware.watchdog_holds:
            self.table["torque_enable"] = 0
        self._hold_here()
        if self._firmware.watchdog_forgets_offset and self._mode == OperatingMode.EXTENDED_POSITION:
            self.table["goal_position"] -= self.table["homing_offset"]
        self._restart()

    def _supervise(self, now: int, duty: float, current: float, supply_v: float, temperature_c: float) -> None:
        straining = abs(duty) > self._firmware.overload_duty
        hot = temperature_c > self._temperature_limit
        starved = not self._lowest_v <= supply_v <= self._highest_v
        if not straining:
            self._relaxed_at = now
        if not (straining or hot or starved or self.encoder_fails or self._watchdog_ns) and self._awake:
            return
        if not self._is_awake(now):
            return
        self._watch_bus(now)
        overloaded = now - self._relaxed_at >= self._firmware.overload_s * _NS
        faults = overloaded * OVERLOAD | hot * OVERHEATING | starved * INPUT_VOLTAGE | self.encoder_fails * ENCODER
        if faults & ~self.table["hardware_error_status"]:
            self._fail(faults)

    def _fail(self, faults: int) -> None:
        """Report faults until the next reboot, and let go if the user has chosen so."""
        self.table["hardware_error_status"] |= faults
        self.alert = ALERT
        if self.table["hardware_error_status"] & self.table["shutdown"]:
            self.table["torque_enable"] = 0
            self._configure()
