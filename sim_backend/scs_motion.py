"""What the registers of a Feetech SCS servo mean for its motor: a goal reached in a time or at a speed, or plain PWM.

With both position limits 0 the servo turns freely by the PWM of one register: `goal_time`, sign in bit 10, in Feetech's
own SDK (FTServo_Arduino, SCSCL.cpp); `goal_velocity`, sign in bit 15, elsewhere. The servo's file chooses.

Assumed: a goal time other than 0 takes the place of the goal velocity; the phase has no effect.
"""

from hal.register_map import ScsFirmware, ServoModel
from sim_backend.feetech_motion import POSITION, PWM, FeetechMotion
from sim_backend.feetech_table import FeetechTable
from sim_backend.motion_profile import Profile, profile_by_speed, profile_by_time
from sim_backend.servo_physics import Drive, Scales

_PWM_SIGN = 1 << 10
_MOVING_ABOVE = 1  # step/s, as the STS series has it


class ScsMotion(FeetechMotion):
    """The motion of a servo of the SCS series. A potentiometer tells its position: it knows no turns."""

    offset = 0
    many_turns = False

    def __init__(self, model: ServoModel, firmware: ScsFirmware, table: FeetechTable) -> None:
        self._scs = firmware
        self._second = 1.0 / model["goal_time"].si_scale  # counts
        super().__init__(model, firmware, table)

    def configure(self, turned: int) -> None:
        """Take over the EEPROM."""
        table = self.table
        self.mode = PWM if table["min_position_limit"] == table["max_position_limit"] == 0 else POSITION
        self.zero = self.model.encoder.centre

    def drive(self, on: bool, largest_duty: float) -> Drive:
        """Return what drives the motor by limits, gains and goals."""
        if self.mode == PWM:
            return Drive(on, largest_duty, duty=self.pull() / self.full)
        return Drive(on, largest_duty, self.position_gains())

    def scales(self) -> Scales:
        """Return what is reported: no current."""
        model = self.model
        return Scales(
            1, self.zero, duty=self.full, load=model.cyclic.effort_full_scale, speed=1.0, current=0.0,
            supply=1.0 / model["present_input_voltage"].scale, moving_above=_MOVING_ABOVE)

    def pull(self) -> int:
        """Return the PWM, counts, that is set where both limits are 0."""
        value = self.table[self._scs.pwm_goal]
        if self._scs.pwm_goal == "goal_velocity":
            return value
        magnitude = value & (_PWM_SIGN - 1)
        return -magnitude if value & _PWM_SIGN else magnitude

    def profile(self, start: float, speed: float, goal_count: int) -> Profile | None:
        """Return the profile to another position, or None if the goal velocity says not to move."""
        goal, limit, time = goal_count - self.zero, self._scs.goal_slew_steps_s, self.table["goal_time"] / self._second
        if time and abs(goal - start) < limit * time:
            return profile_by_time(start, speed, goal, time, 0.0)
        goal_velocity = abs(self.table["goal_velocity"])
        if not time and (goal_velocity or self._scs.speed_0_stops):
            limit = min(limit, goal_velocity)
        return profile_by_speed(start, speed, goal, limit, 0.0) if limit else None
