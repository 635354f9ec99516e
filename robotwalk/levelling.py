"""Keeps the body level on ground that is not, by an IMU (ARTH section 5.6; the alternative to following the feet).

A correction of the body's roll and pitch has the angular acceleration c1 x error - c2 x angular velocity; the error is
how much less than wanted the body is tilted against gravity. Wanted is what all other stages tilt the body by. As the
body does as it is told but for the ground's slope and its legs' give, the correction ends where it makes up for both.

Where the tilt is not known both ease back to none, as they do when the robot is to sit down.
"""

from robotwalk.settings import LevellingSettings
from robotwalk.types import Pose, Tilt

_AT_REST = 2e-3  # rad, and per s


class _Correction:
    """Of one angle."""

    def __init__(self, settings: LevellingSettings) -> None:
        self._settings = settings
        self.value = self.rate = 0.0

    def step(self, told: float, measured: float | None, dt: float) -> None:
        c1, c2, limit = self._settings
        error = -self.value if measured is None else told - self.value - measured
        # Implicit in the damping: no tick is too long for it.
        self.rate = (self.rate + c1 * error * dt) / (1.0 + c2 * dt)
        self.value += self.rate * dt
        if abs(self.value) > limit:
            self.value = min(max(self.value, -limit), limit)
            self.rate = 0.0

    @property
    def at_rest(self) -> bool:
        return max(abs(self.value), abs(self.rate)) <= _AT_REST


class Levelling:
    """The correction of one robot's body."""

    def __init__(self, settings: LevellingSettings) -> None:
        self._roll, self._pitch = _Correction(settings), _Correction(settings)

    @property
    def at_rest(self) -> bool:
        """Whether nothing is corrected."""
        return self._roll.at_rest and self._pitch.at_rest

    def step(self, pose: Pose, told: Pose, tilt: Tilt | None, dt: float) -> Pose:
        """Advance by `dt` s; return a body's pose with its correction.

        Args:
            pose: to be corrected.
            told: what the body was told in the last tick, corrections included.
            tilt: what it was found to be; None: go back to no correction.
            dt: s.
        """
        roll, pitch = self._roll, self._pitch
        roll.step(told.roll, None if tilt is None else tilt.roll, dt)
        pitch.step(told.pitch, None if tilt is None else tilt.pitch, dt)
        return Pose(pose.x, pose.y, pose.z, pose.roll + roll.value, pose.pitch + pitch.value, pose.yaw)
