"""What the registers of a Feetech servo mean for its motor, as far as both series agree.

With e = goal - position in steps of the encoder, in shares of full duty:

    position loop   duty = (P e + I / t_I x sum of e dt + D t_D (v_goal - v)) / (divisor x 1000)

The divisor, t_I and t_D are the servo's file's, which says what of them is identified and what assumed.
"""

from abc import ABC, abstractmethod

from hal.register_map import FeetechFirmware, ServoModel
from sim_backend.feetech_table import FeetechTable
from sim_backend.motion_profile import Profile
from sim_backend.servo_physics import Drive, Gains, Scales

POSITION, VELOCITY, PWM, STEP = range(4)  # of operating_mode


class FeetechMotion(ABC):
    """Translates registers into steps, seconds and duty: the RAM's as they are, the EEPROM's as last configured.

    Attributes:
        mode: of the four.
        offset: of the position, counts.
        zero: position count = ticks + zero.
        many_turns: whether goals may lie beyond one turn.
    """

    mode: int
    offset: int
    zero: int
    many_turns: bool

    def __init__(self, model: ServoModel, firmware: FeetechFirmware, table: FeetechTable) -> None:
        self.model, self.table = model, table
        self.full = model.position_loop.pwm_full_scale
        self._firmware = firmware
        self.configure(turned=0)

    @abstractmethod
    def configure(self, turned: int) -> None:
        """Take over the EEPROM; `turned` ticks have been taken off the position."""

    @abstractmethod
    def drive(self, on: bool, largest_duty: float) -> Drive:
        """Return what drives the motor by mode, gains and goals."""

    @abstractmethod
    def scales(self) -> Scales:
        """Return what is reported."""

    @abstractmethod
    def pull(self) -> int:
        """Return which way the goal leads where it is no position: less or more than 0."""

    @abstractmethod
    def profile(self, start: float, speed: float, goal_count: int) -> Profile | None:
        """Return the profile to another position, or None if the goal velocity says not to move."""

    def bounded(self, count: int) -> int:
        """Return a goal within the position limits."""
        table = self.table
        return count if self.many_turns else min(max(count, table["min_position_limit"]), table["max_position_limit"])

    def direction(self, position: float) -> float:
        """Return which way the goal lies from a position, ticks: less or more than 0."""
        if self.mode == POSITION:
            return self.bounded(self.table["goal_position"]) - self.zero - position
        return self.pull()

    def position_gains(self) -> Gains:
        """Return the gains of the position loop."""
        table, loop, firmware = self.table, self.model.position_loop, self._firmware
        duty = loop.duty_per_tick(1.0)
        derivative = table["position_d_gain"] if firmware.derivative_gain else 0
        return Gains(
            table[loop.proportional] * duty, table["position_i_gain"] / firmware.integral_s * duty,
            derivative * firmware.derivative_s * duty)
