"""What the registers of a Feetech STS servo mean for its motor: its modes, its velocity loop, its units of speed.

    velocity loop   duty = (P e + I / 10 / t_I x sum of e dt) / velocity divisor, e in step/s

P's divisor of the position loop is identified (BAM); t_I and the velocity loop's divisor are assumed, in the servo's
file. The identified law is the whole law at the factory's settings, so that minimum start force and dead zones, which
those include, are stored and have no effect of their own.
"""

import math

from hal.register_map import ServoModel, StsFirmware
from sim_backend.feetech_motion import PWM, STEP, VELOCITY, FeetechMotion
from sim_backend.feetech_table import FeetechTable
from sim_backend.motion_profile import Profile, profile_by_speed
from sim_backend.servo_physics import Drive, Gains, Scales

_FINE_SPEED, _ZERO_IS_FASTEST, MULTI_TURN_FEEDBACK = 0x04, 0x08, 0x10  # bits of phase
_COARSE_SPEED_STEPS_S = 50.0  # 0.732 rpm: the unit of speed without _FINE_SPEED
_GOAL = {VELOCITY: "goal_velocity", PWM: "goal_pwm", STEP: "goal_position"}


class StsMotion(FeetechMotion):
    """The motion of a servo of the STS series. With both position limits 0 it counts turns."""

    def __init__(self, model: ServoModel, firmware: StsFirmware, table: FeetechTable) -> None:
        self._sts = firmware
        turn = model.encoder.ticks
        self._fine_speed = model["goal_velocity"].scale * turn  # ticks/s per count, from rev/s
        self._largest_speed_unit = model["max_velocity_limit"].scale * turn
        self._acceleration_unit = model["acceleration"].scale
        super().__init__(model, firmware, table)

    def configure(self, turned: int) -> None:
        """Take over the EEPROM; `turned` ticks have been taken off the position."""
        table = self.table
        self.mode = table["operating_mode"]
        self.offset = table["position_offset"]
        # Present = actual - offset: the other sign than a Dynamixel's homing offset.
        self.zero = self.model.encoder.centre - self.offset - turned
        self.many_turns = (table["min_position_limit"], table["max_position_limit"]) == (0, 0)
        self._speed_unit = self._fine_speed if table["phase"] & _FINE_SPEED else _COARSE_SPEED_STEPS_S
        self._zero_is_fastest = bool(table["phase"] & _ZERO_IS_FASTEST)
        self._largest_speed = table["max_velocity_limit"] * self._largest_speed_unit
        self._largest_acceleration = table["max_acceleration"]

    def drive(self, on: bool, largest_duty: float) -> Drive:
        """Return what drives the motor by mode, gains and goal PWM."""
        if self.mode == PWM:
            return Drive(on, largest_duty, duty=self.table["goal_pwm"] / self.full)
        if self.mode == VELOCITY:
            return Drive(on, largest_duty, self._velocity_gains(), velocity_loop=True)
        return Drive(on, largest_duty, self.position_gains())

    def _velocity_gains(self) -> Gains:
        firmware, duty = self._sts, 1.0 / self._sts.velocity_divisor
        integral = self.table["velocity_i_gain"] * self.model["velocity_i_gain"].scale
        return Gains(self.table["velocity_p_gain"] * duty, integral / firmware.integral_s * duty)

    def scales(self) -> Scales:
        """Return what is reported."""
        model = self.model
        return Scales(
            1, self.zero, duty=self.full, load=model.cyclic.effort_full_scale, speed=1.0 / self._speed_unit,
            current=1.0 / model["present_current"].si_scale, supply=1.0 / model["present_input_voltage"].scale,
            moving_above=self.table["moving_threshold"])

    def pull(self) -> int:
        """Return which way the goal leads where it is no position."""
        return self.table[_GOAL[self.mode]]

    def ramp(self, start: float, speed: float) -> Profile | None:
        """Return the profile to the goal velocity (0: stand still), or None if it is a step."""
        acceleration = self._acceleration()
        if not acceleration:
            return None
        goal_speed = self.goal_speed()
        return Profile(start, speed, abs(goal_speed - speed) / acceleration, goal_speed, math.inf, 0.0)

    def goal_speed(self) -> float:
        """Return the goal of the velocity loop, ticks/s."""
        speed, largest = self.table["goal_velocity"] * self._speed_unit, self._largest_speed
        return min(max(speed, -largest), largest)

    def profile(self, start: float, speed: float, goal_count: int) -> Profile | None:
        """Return the profile to another position, or None if the goal velocity says not to move."""
        limit = min(self._largest_speed, self._sts.goal_slew_steps_s)
        goal_velocity = abs(self.table["goal_velocity"])
        if goal_velocity or not self._zero_is_fastest:
            limit = min(limit, goal_velocity * self._speed_unit)
        if not limit:
            return None
        return profile_by_speed(start, speed, goal_count - self.zero, limit, self._acceleration())

    def _acceleration(self) -> float:
        """Return the acceleration, ticks/s^2, or 0 for no limit."""
        return min(self.table["acceleration"], self._largest_acceleration) * self._acceleration_unit
