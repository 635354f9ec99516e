"""What the registers of a Feetech STS servo mean for its motor.

With e = goal - position in steps of the encoder, in shares of full duty:

    position loop   duty = (P e + I / t_I x sum of e dt + D t_D (v_goal - v)) / (divisor x 1000)
    velocity loop   duty = (P e + I / 10 / t_I x sum of e dt) / velocity divisor, e in step/s

P's divisor is identified (BAM); t_I, t_D and the velocity loop's divisor are assumed, in the servo's file. The
identified law is the whole law at the factory's settings, so that minimum start force and dead zones, which those
include, are stored and have no effect of their own.
"""

import math

from hal.register_map import ServoModel, StsFirmware
from sim_backend.motion_profile import Profile, profile_by_speed
from sim_backend.servo_physics import Drive, Gains, Scales
from sim_backend.sts_table import StsTable

POSITION, VELOCITY, PWM, STEP = range(4)  # of operating_mode
_FINE_SPEED, _ZERO_IS_FASTEST, MULTI_TURN_FEEDBACK = 0x04, 0x08, 0x10  # bits of phase
_COARSE_SPEED_STEPS_S = 50.0  # 0.732 rpm: the unit of speed without _FINE_SPEED


class StsMotion:
    """Translates registers into steps, seconds and duty: the RAM's as they are, the EEPROM's as last configured.

    Attributes:
        offset: of the position, counts.
        zero: position count = ticks + zero.
        many_turns: whether goals may lie beyond one turn, as with both limits 0.
    """

    def __init__(self, model: ServoModel, firmware: StsFirmware, table: StsTable) -> None:
        self._model, self._firmware, self._table = model, firmware, table
        turn = model.encoder.ticks_per_turn
        self._fine_speed = model["goal_velocity"].scale * turn  # ticks/s per count, from rev/s
        self._largest_speed_unit = model["max_velocity_limit"].scale * turn
        self._acceleration_unit = model["acceleration"].scale
        self._full = model.position_loop.pwm_full_scale
        self.configure(turned=0)

    def configure(self, turned: int) -> None:
        """Take over the EEPROM; `turned` ticks have been taken off the position."""
        table = self._table
        self.offset = table["position_offset"]
        # Present = actual - offset: the other sign than a Dynamixel's homing offset.
        self.zero = self._model.encoder.centre - self.offset - turned
        self._limits = table["min_position_limit"], table["max_position_limit"]
        self.many_turns = self._limits == (0, 0)
        self._speed_unit = self._fine_speed if table["phase"] & _FINE_SPEED else _COARSE_SPEED_STEPS_S
        self._zero_is_fastest = bool(table["phase"] & _ZERO_IS_FASTEST)
        self._largest_speed = table["max_velocity_limit"] * self._largest_speed_unit
        self._largest_acceleration = table["max_acceleration"]

    def drive(self, on: bool, largest_duty: float) -> Drive:
        """Return what drives the motor by mode, gains and goal PWM."""
        table, mode, cap = self._table, self._table["operating_mode"], min(largest_duty, self._firmware.largest_duty)
        if mode == PWM:
            return Drive(on, cap, duty=table["goal_pwm"] / self._full)
        if mode == VELOCITY:
            return Drive(on, cap, self._velocity_gains(), velocity_loop=True)
        return Drive(on, cap, self._position_gains())

    def _velocity_gains(self) -> Gains:
        firmware, duty = self._firmware, 1.0 / self._firmware.velocity_divisor
        integral = self._table["velocity_i_gain"] * self._model["velocity_i_gain"].scale
        return Gains(self._table["velocity_p_gain"] * duty, integral / firmware.integral_s * duty)

    def _position_gains(self) -> Gains:
        table, loop, firmware = self._table, self._model.position_loop, self._firmware
        duty = 1.0 / (loop.divisor * self._full)
        derivative = table["position_d_gain"] if firmware.derivative_gain else 0
        return Gains(
            table[loop.proportional] * duty, table["position_i_gain"] / firmware.integral_s * duty,
            derivative * firmware.derivative_s * duty)

    def scales(self) -> Scales:
        """Return what is reported."""
        model = self._model
        return Scales(
            1, self.zero, duty=self._full, load=model.cyclic.effort_full_scale, speed=1.0 / self._speed_unit,
            current=1.0 / model["present_current"].si_scale, supply=1.0 / model["present_input_voltage"].scale,
            moving_above=self._table["moving_threshold"])

    def bounded(self, count: int) -> int:
        """Return a goal within the position limits."""
        return count if self.many_turns else min(max(count, self._limits[0]), self._limits[1])

    def direction(self, position: float) -> float:
        """Return which way the goal lies from a position, ticks: less or more than 0."""
        table, mode = self._table, self._table["operating_mode"]
        if mode == POSITION:
            return self.bounded(table["goal_position"]) - self.zero - position
        return table[{VELOCITY: "goal_velocity", PWM: "goal_pwm", STEP: "goal_position"}[mode]]

    def ramp(self, start: float, speed: float) -> Profile | None:
        """Return the profile to the goal velocity (0: stand still), or None if it is a step."""
        acceleration = self._acceleration()
        if not acceleration:
            return None
        goal_speed = self.goal_speed()
        return Profile(start, speed, abs(goal_speed - speed) / acceleration, goal_speed, math.inf, 0.0)

    def goal_speed(self) -> float:
        """Return the goal of the velocity loop, ticks/s."""
        speed, largest = self._table["goal_velocity"] * self._speed_unit, self._largest_speed
        return min(max(speed, -largest), largest)

    def profile(self, start: float, speed: float, goal_count: int) -> Profile | None:
        """Return the profile to another position, or None if the goal velocity says not to move."""
        limit = min(self._largest_speed, self._firmware.goal_slew_steps_s)
        goal_velocity = abs(self._table["goal_velocity"])
        if goal_velocity or not self._zero_is_fastest:
            limit = min(limit, goal_velocity * self._speed_unit)
        if not limit:
            return None
        return profile_by_speed(start, speed, goal_count - self.zero, limit, self._acceleration())

    def _acceleration(self) -> float:
        """Return the acceleration, ticks/s^2, or 0 for no limit."""
        return min(self._table["acceleration"], self._largest_acceleration) * self._acceleration_unit
