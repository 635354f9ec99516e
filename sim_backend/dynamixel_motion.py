"""What a Dynamixel's registers mean for its motor.

With e = goal - position in encoder ticks and f = `time_base_hz`:

    position loop   PWM = P e / 128 + I sum(e) / 65536 + D (v_goal - v) / 16 f + FF1 v_goal / 4 f
                          + FF2 a_goal / 4 f^2
    velocity loop   PWM = P e / 128 + I sum(e) / 65536, e being the velocity's error in register counts; the divisors
                    are the servo's file's
    current mode    PWM such that the goal current flows

In current-based position mode the position loop's PWM gives way where the goal current would be passed; in no other
mode does a current limit act (e-Manual, Current Limit). That the current is reached within a step is assumed.

Divisors: e-Manual, X series, the gains' registers.
"""

import math

from hal.register_map import DynamixelFirmware, ServoModel
from sim_backend.dynamixel_table import DynamixelTable, OperatingMode
from sim_backend.motion_profile import Profile, profile_by_speed, profile_by_time
from sim_backend.servo_physics import Drive, Gains, Scales

_REVERSE = 0x01  # bits of drive_mode
_TIME_BASED = 0x04
_INTEGRAL_DIVISOR = 65536
_DERIVATIVE_DIVISOR = 16
_FEED_FORWARD_DIVISOR = 4
_MS = 1e-3  # s


class DynamixelMotion:
    """Translates registers into ticks, seconds and duty, as they are at the time of the call.

    Attributes:
        sign: -1 where counts grow clockwise, else 1; as of the last `configure`.
        zero: position count = sign x ticks + zero; likewise.
        has_profile: whether goals are approached along a profile, not at once; likewise.
    """

    def __init__(self, model: ServoModel, firmware: DynamixelFirmware, table: DynamixelTable) -> None:
        self._model, self._table = model, table
        self._rate = firmware.time_base_hz
        self._derivative = firmware.derivative_gain
        self._velocity_divisors = firmware.velocity_p_divisor, firmware.velocity_i_divisor
        self._full = model.position_loop.pwm_full_scale
        turn = model.encoder.ticks
        self._speed_unit = model["profile_velocity"].scale * turn / 60.0  # ticks/s per count, from rpm
        self._acceleration_unit = model["profile_acceleration"].scale * turn / 3600.0  # from rev/min^2
        self._measures_current = "present_current" in model.by_name
        self._current_unit = model["present_current"].si_scale if self._measures_current else math.inf  # A per count
        self._supply_scale = 1.0 / model["present_input_voltage"].scale
        self.configure(turned=0)

    def configure(self, turned: int) -> None:
        """Take over what each goal needs; `turned` ticks have been taken off the position."""
        table, encoder = self._table, self._model.encoder
        offset = table["homing_offset"]
        if table["operating_mode"] == OperatingMode.POSITION and abs(offset) > encoder.ticks // 4:
            offset = 0  # ignored there (e-Manual, Homing Offset)
        self.sign = -1 if table["drive_mode"] & _REVERSE else 1
        self.zero = encoder.centre + offset - turned
        self.has_profile = bool(table["profile_acceleration" if self._velocity_mode else "profile_velocity"])

    def drive(self) -> Drive:
        """Return what drives the motor."""
        table, mode = self._table, self._table["operating_mode"]
        on = bool(table["torque_enable"])
        if mode == OperatingMode.PWM:
            duty = self.sign * table["goal_pwm"] / self._full
            return Drive(on, table["pwm_limit"] / self._full, duty=duty)
        cap = min(abs(table["goal_pwm"]), table["pwm_limit"]) / self._full
        if mode == OperatingMode.VELOCITY:
            return Drive(on, cap, self._velocity_gains(), velocity_loop=True)
        if mode == OperatingMode.CURRENT:
            current = self.sign * table["goal_current"] * self._current_unit
            return Drive(on, cap, currents=(current, current))
        if mode == OperatingMode.CURRENT_BASED_POSITION:
            current = abs(table["goal_current"]) * self._current_unit
            return Drive(on, cap, self._position_gains(), currents=(-current, current))
        return Drive(on, cap, self._position_gains())

    def _velocity_gains(self) -> Gains:
        table = self._table
        duty = 1.0 / (self._full * self._speed_unit)  # of one PWM count per velocity count
        p_divisor, i_divisor = self._velocity_divisors
        return Gains(
            table["velocity_p_gain"] / p_divisor * duty, table["velocity_i_gain"] / i_divisor * self._rate * duty)

    def _position_gains(self) -> Gains:
        table, rate, duty = self._table, self._rate, 1.0 / self._full
        loop = self._model.position_loop
        derivative = table["position_d_gain"] if self._derivative else 0
        return Gains(
            loop.duty_per_tick(table[loop.proportional]),
            table["position_i_gain"] / _INTEGRAL_DIVISOR * rate * duty,
            derivative / _DERIVATIVE_DIVISOR / rate * duty,
            table["feedforward_1st_gain"] / _FEED_FORWARD_DIVISOR / rate * duty,
            table["feedforward_2nd_gain"] / _FEED_FORWARD_DIVISOR / rate**2 * duty)

    def scales(self) -> Scales:
        """Return what is reported."""
        return Scales(
            self.sign, self.zero, duty=self._full, load=self._model.cyclic.effort_full_scale,
            speed=1.0 / self._speed_unit, current=1.0 / self._current_unit, supply=self._supply_scale,
            moving_above=self._table["moving_threshold"])

    def goal_position(self) -> float:
        """Return where the goal is, ticks."""
        return self.sign * (self._table["goal_position"] - self.zero)

    def goal_speed(self) -> float:
        """Return the goal of the velocity loop, ticks/s."""
        return self.sign * self._table["goal_velocity"] * self._speed_unit

    def profile(self, start: float, speed: float) -> Profile:
        """Return the profile to the goal of the mode, from where the shaft should be by now."""
        acceleration = self._table["profile_acceleration"]
        if self._velocity_mode:
            return self._ramp(start, speed, acceleration)
        goal, velocity = self.goal_position(), self._table["profile_velocity"]
        if self._time_based:
            return profile_by_time(start, speed, goal, velocity * _MS, acceleration * _MS)
        return profile_by_speed(
            start, speed, goal, velocity * self._speed_unit, acceleration * self._acceleration_unit)

    def _ramp(self, start: float, speed: float, acceleration: int) -> Profile:
        goal_speed = self.goal_speed()
        if self._time_based:
            ramp_s = acceleration * _MS
        else:
            ramp_s = abs(goal_speed - speed) / (acceleration * self._acceleration_unit)
        return Profile(start, speed, ramp_s, goal_speed, math.inf, 0.0)

    @property
    def _velocity_mode(self) -> bool:
        return self._table["operating_mode"] == OperatingMode.VELOCITY

    @property
    def _time_based(self) -> bool:
        return bool(self._table["drive_mode"] & _TIME_BASED)
