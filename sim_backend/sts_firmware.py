"""The firmware of a Feetech STS servo: what its registers do when they are written, and its protections.

Assumed where manuals say nothing:

- Step mode (3) counts from the goal before, and keeps to the position limits unless both are 0. Goal time does nothing
  in position mode. A goal velocity of 0 stops the motor in velocity mode, whatever the phase says. Acceleration 0 is
  no limit at all; `max_acceleration` bounds the others.
- Torque enable 128 leaves torque as it was.
- Voltage and heat release the motor when they pass, over-current as overload does.
- A change of mode, offset or turns with torque on starts afresh from where the shaft is.

Stored without effect: LED alarm, angular resolution, phase bits 0, 1, 5, 6 and 7 (directions, hardware), minimum start
force, dead zones, acceleration multiplier, velocity unit, DTs, Hts.
"""

from hal.register_map import StsFirmware
from sim_backend.control_table import Window
from sim_backend.fake_servo import FakeServo
from sim_backend.servo_physics import Drive, ServoPhysics
from sim_backend.sts_motion import MULTI_TURN_FEEDBACK, PWM, STEP, VELOCITY, StsMotion
from sim_backend.sts_table import StsTable

VOLTAGE, OVERHEATING, OVER_CURRENT, TORQUE_IS_ON, OVERLOAD = 0x01, 0x04, 0x08, 0x10, 0x20  # bits of the status

_ON, _DAMPING, _CENTRE_HERE = 1, 2, 128  # of torque_enable
_GOALS = {"acceleration", "goal_position", "goal_pwm", "goal_velocity"}
_PERCENT = 100.0
_LARGEST_MAGNITUDE = (1 << 15) - 1  # beside the sign
_LARGEST_OFFSET = 2047
_LARGEST_BYTE = 255
_NS = 1_000_000_000


class StsServo(FakeServo):
    """A servo of the STS series.

    Attributes:
        answers_writes: whether it answers more than pings and reads.
        error: the error byte of its answers.
        knows_reboot: whether its firmware has that instruction.
    """

    table: StsTable

    def __init__(self, physics: ServoPhysics, index: int, **factory_settings: int) -> None:
        """Make the servo of one entry of `physics`, new but for some registers of the EEPROM."""
        model = physics.models[index]
        if not isinstance(model.firmware, StsFirmware):
            raise ValueError(f"{model.name} is no STS servo")  # noqa: TRY004 (a wrong model, not a wrong type)
        super().__init__(physics, index, StsTable(model))
        self._firmware = model.firmware
        self._set_up(factory_settings)
        self.knows_reboot = self._firmware.reboot
        self._motion = StsMotion(model, self._firmware, self.table)
        self._window = Window(model, (
            "present_position", "present_velocity", "present_load", "present_input_voltage", "present_temperature"))
        self._registered: tuple[int, bytes] | None = None
        self._target = 0  # counts, of position and step mode
        self._started_in: tuple[int, ...] = ()
        self._run()

    def read(self, address: int, length: int) -> bytes:
        """Return bytes of the control table."""
        self._sense()
        return self.table.read(address, length)

    def write(self, address: int, data: bytes) -> None:
        """Write bytes to the control table, and act on the registers that took them."""
        table, torque = self.table, self.table["torque_enable"]
        taken = table.write(address, data)
        if table["torque_enable"] == _CENTRE_HERE:
            table["torque_enable"] = torque
            self._centre_here()
        if table["torque_enable"] != torque or (self._latched and self._leads_away(taken)):
            self._clear_protection()
        elif not taken <= _GOALS or self._mode == PWM:
            self._configure()
        if "goal_position" in taken:
            table["goal_position_echo"] = table["goal_position"]
        if taken:
            self._move(steps="goal_position" in taken)

    def register_write(self, address: int, data: bytes) -> None:
        """Keep a write for `action`; it takes the place of an earlier one."""
        self._registered = address, data
        self.table["registered_instruction"] = 1

    def action(self) -> None:
        """Carry out the write that was kept, if there is one."""
        if self._registered is not None:
            address, data = self._registered
            self._registered = None
            self.table["registered_instruction"] = 0
            self.write(address, data)

    def recover(self, now: int) -> None:
        """Go back to the factory's settings, and start afresh."""
        self.table.recover()
        self.reboot(now)

    def clear_turns(self) -> None:
        """Forget whole turns: bring the position to within one."""
        self._fold()
        self._restart()

    def _reset(self) -> None:
        self.table.restore()
        self.table["torque_limit"] = self.table["max_torque_limit"]
        self._registered = None
        self._status = self._latched = 0  # protections: as reported, and those that stay
        self._strain = 0.0  # duty at which the motor was overloaded
        self._configure()

    def _start(self, now: int) -> None:
        self._relaxed_at = self._current_fine_at = now
        self._fold()
        if self._firmware.torque_at_power_up:
            self._sense()
            self.table["goal_position"] = self.table["goal_position_echo"] = self.table["present_position"]
            self.table["torque_enable"] = _ON
        self._configure()
        self._move(steps=False)

    def _show(self, present: list[int]) -> None:
        moving, _, _, _, _, load, speed, position, _, _, current, supply, temperature = present
        if not self._shows_turns:
            position %= self.model.encoder.ticks_per_turn
        self._window.store(self.table, (
            _within(position, _LARGEST_MAGNITUDE), _within(speed, _LARGEST_MAGNITUDE), load,
            max(0, _within(supply, _LARGEST_BYTE)), max(0, _within(temperature, _LARGEST_BYTE))))
        self.table["moving"] = moving
        self.table["present_current"] = _within(current, _LARGEST_MAGNITUDE)

    def _configure(self) -> None:
        """Take over settings that are looked at often, and the motor's."""
        table = self.table
        self._configure_line()
        self.answers_writes = bool(table["status_return_level"])
        self._mode = table["operating_mode"]
        self._shows_turns = bool(table["phase"] & MULTI_TURN_FEEDBACK)
        self._temperature_limit = table["max_temperature_limit"]
        unit = self.model["present_input_voltage"].scale  # V; a limit is passed by half a count
        self._lowest_v = unit * (table["min_voltage_limit"] - 0.5)
        self._highest_v = unit * (table["max_voltage_limit"] + 0.5)
        self._overload_duty = table["overload_torque"] / _PERCENT
        self._overload_ns = self._span_ns("protection_time")
        self._largest_current = table["protection_current"] * self.model["protection_current"].si_scale
        self._over_current_ns = self._span_ns("over_current_time")
        self._load()

    def _span_ns(self, name: str) -> int:
        return round(self.table[name] * self.model[name].si_scale * _NS)

    def _load(self) -> None:
        """Hand the motor's settings over."""
        table = self.table
        torque, unloading = table["torque_enable"], self._status & table["unloading_condition"]
        released = bool(unloading & ~OVERLOAD)
        self._on = torque == _ON and not released
        largest = table["torque_limit"] * self.model["torque_limit"].si_scale
        if unloading & OVERLOAD:
            largest = min(largest, table["protective_torque"] / _PERCENT)
        self._motion.configure(self._turned)
        drive = self._motion.drive(self._on, largest)
        if torque == _DAMPING and self._firmware.damping and not released:
            drive = Drive(on=True)  # the bridge shorts the motor
        self._physics.load(self._index, drive, self._motion.scales())
        self.error = self._status
        if self._firmware.torque_flag_in_status and torque == _ON:
            self.error |= TORQUE_IS_ON
        table["hardware_error_status"] = self.error

    def _move(self, *, steps: bool) -> None:
        """Head for the goal; `steps` tells whether it is new, which counts in step mode."""
        if self._started_in != self._circumstances():
            self._restart()
        if self._on:
            self._aim(steps)

    def _circumstances(self) -> tuple[int, ...]:
        return self._on, self._mode, self._motion.offset, self._motion.many_turns

    def _restart(self) -> None:
        """Start from rest where the shaft is, as when torque comes on."""
        if not self._motion.many_turns:
            self._fold()
        self._physics.rest(self._index)
        self._configure()
        self._target = round(self._physics.ticks(self._index) + self._motion.zero)
        self._started_in = self._circumstances()

    def _aim(self, steps: bool) -> None:
        physics, index, motion = self._physics, self._index, self._motion
        start, speed = physics.trajectory(index)
        goal_speed = 0.0
        if self._mode == VELOCITY:
            goal_speed, profile = motion.goal_speed(), motion.ramp(start, speed)
        elif self._mode == PWM:
            return
        else:
            self._target = motion.bounded(self._next_target(steps))
            profile = motion.profile(start, speed, self._target)
        if profile is None:
            physics.jump(index, start, goal_speed)
        else:
            physics.follow(index, profile)

    def _next_target(self, steps: bool) -> int:
        goal = self.table["goal_position"]
        if self._mode != STEP:
            return goal
        return self._target + goal if steps else self._target

    def _fold(self) -> None:
        """Bring the position to within one turn."""
        self._take_off_turns(1, self._motion.zero + self._turned)
        self._load()

    def _centre_here(self) -> None:
        """Choose the offset that makes the present position the centre."""
        encoder = self.model.encoder
        actual = round(encoder.centre + self._physics.ticks(self._index)) % encoder.ticks_per_turn
        offset = _within(actual - encoder.centre, _LARGEST_OFFSET)
        self.table.assign(self.model["position_offset"], offset)

    def _leads_away(self, taken: set[str]) -> bool:
        """Whether a goal leads away from what overloaded the motor."""
        if not self._firmware.overload_clears_on_new_goal or not taken & _GOALS:
            return False
        return self._motion.direction(self._physics.ticks(self._index)) * self._strain < 0.0

    def _clear_protection(self) -> None:
        self._status &= ~self._latched
        self._latched = 0
        self._configure()

    def _supervise(self, now: int, duty: float, current: float, supply_v: float, temperature_c: float) -> None:
        if not self._is_awake(now):
            return
        strained = abs(duty) > self._overload_duty
        if not strained:
            self._relaxed_at = now
        flooded = abs(current) > self._largest_current
        if not flooded:
            self._current_fine_at = now
        overloaded = strained and now - self._relaxed_at >= self._overload_ns
        over_current = flooded and now - self._current_fine_at >= self._over_current_ns
        lasting = overloaded * OVERLOAD | over_current * OVER_CURRENT
        if lasting:
            self._strain = duty
            self._latched |= lasting & self.table["unloading_condition"]
        hot = temperature_c > self._temperature_limit
        starved = not self._lowest_v <= supply_v <= self._highest_v
        status = lasting | self._latched | hot * OVERHEATING | starved * VOLTAGE
        if status != self._status:
            self._status = status
            self._configure()
            self._move(steps=False)


def _within(value: int, largest: int) -> int:
    return min(max(value, -largest), largest)
