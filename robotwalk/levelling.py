"""Keeps the body level on ground that is not, by an IMU (ARTH section 5.6; the alternative to following the feet).

A correction of the body's roll and pitch has the angular acceleration c1 x error - c2 x angular velocity; the error is
how much less than wanted the IMU finds the body tilted. Wanted is what all other stages tilt the body by. As the body
does as it is told but for the ground's slope and its legs' give, the correction ends where it makes up for both.

A silent IMU is no data: the correction eases back to none, as it does when the robot is to sit down.
"""

from robotwalk.model import LevellingSettings
from robotwalk.types import ImuState, Pose

_AT_REST = 2e-3  # rad, and per s


class _Correction:
    """Of one angle."""

    def __init__(self, settings: LevellingSettings) -> None:
        self._settings = settings
        self.value = self.rate = 0.0

    def step(self, error: float, dt: float) -> None:
        c1, c2, limit = self._settings
        # Implicit in the damping: no tick is too long for it.
        self.rate = (self.rate + c1 * error * dt) / (1.0 + c2 * dt)
        self.value += self.rate * dt
        if abs(self.value) > limit:
            self.value = min(max(self.value, -limit), limit)
            self.rate = 0.0

    @property
    def at_rest(self) -> bool:
        return abs(self.value) <= _AT_REST and abs(self.rate) <= _AT_REST


class Levelling:
    """The correction of one robot's body."""

    def __init__(self, settings: LevellingSettings) -> None:
        self._roll, self._pitch = _Correction(settings), _Correction(settings)

    @property
    def at_rest(self) -> bool:
        """Whether nothing is corrected."""
        return self._roll.at_rest and self._pitch.at_rest

    def step(self, pose: Pose, told: Pose, imu: ImuState | None, dt: float) -> Pose:
        """Advance by `dt` s; return a body's pose with its correction.

        Args:
            pose: to be corrected.
            told: what the body was told in the last tick, corrections included.
            imu: what it found; None, or not valid: go back to no correction.
            dt: s.
        """
        roll, pitch = self._roll, self._pitch
        if imu is not None and imu.valid:
            roll.step(told.roll - roll.value - imu.roll, dt)
            pitch.step(told.pitch - pitch.value - imu.pitch, dt)
        else:
            roll.step(-roll.value, dt)
            pitch.step(-pitch.value, dt)
        return pose._replace(roll=pose.roll + roll.value, pitch=pose.pitch + pitch.value)
