"""What a leg can reach, and what it does about what it cannot.

Near the end of a joint's range its angle goes over into the last one without a jump in speed, too: servos overshoot.

A foot's distance from the joint that points the leg at it goes over into the leg's longest, or shortest, without a
jump in speed: a leg that ran straight into its end would stop there at once, its knee at its fastest.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

_SPARE = math.radians(2.5)  # that a joint stays off its limits
_SOFT_JOINT = math.radians(1.5)  # before that, where it slows down
_BRAKING = 150.0  # rad/s^2, of a joint that nears it
_AHEAD = 0.035  # s; braking takes no farther than going on for so long, up to 10 rad/s, which is more than a servo does
_SOFT = 0.02  # of the way between shortest and longest, at either end
# A leg stretched to its very end has no speed left along itself; IK stays this far off.
_MARGIN = 1e-6  # m


def spare(low: float, high: float) -> float:
    """Return by how much a joint with these limits, rad, is never sent nearer to either of them."""
    return min(_SPARE, 0.02 * (high - low))


class Solution(NamedTuple):
    """Joint angles that bring the foot to a target, or as near as the leg allows."""

    angles: tuple[float, ...]  # rad, from the body to the foot
    miss: float  # m from the target to where the foot is; 0 within reach


class Reach(NamedTuple):
    """How near and how far a foot can be from a joint, m."""

    shortest: float
    longest: float
    soft: float  # width of the last bit at either end

    @classmethod
    def between(cls, shortest: float, longest: float) -> "Reach":
        """Return the reach of a leg of these lengths."""
        room = max(longest - shortest, 0.0)
        margin = min(_MARGIN, 0.25 * room)
        return cls(shortest + margin, longest - margin, max(_SOFT * room, _MARGIN))

    def soften(self, distance: float) -> float:
        """Return the distance to go to: the same, but for the ends (C1, and never beyond them)."""
        beyond = distance - self.longest + self.soft
        if beyond > 0.0:
            return self.longest - self.soft * math.exp(-beyond / self.soft)
        short = self.shortest + self.soft - distance
        if short > 0.0:
            return self.shortest + self.soft * math.exp(-short / self.soft)
        return distance


class Ranges:
    """The ranges of a leg's joints, softened at both ends, which no joint nears faster than it can brake before them.

    A leg is straightened fastest right before it is straight, and is heavy: from there its knee would swing on.

    Attributes:
        at_end: whether some joint is where its range is soft.
    """

    def __init__(self, limits: Sequence[tuple[float, float]]) -> None:
        """Take each joint's lower and upper limit, rad, from the body to the foot."""
        self._limits = [
            (low, high, min(_SOFT_JOINT, 0.1 * (high - low)), spare(low, high)) for low, high in limits]
        self._free = [(low + soft + spare, high - soft - spare) for low, high, soft, spare in self._limits]
        self._last: Sequence[float] = ()
        self._near = False  # some joint was held back
        self.at_end = False

    def keep(self, angles: Sequence[float], dt: float) -> Sequence[float]:
        """Return angles, rad, within the ranges: the same, but near the ends (C1, and never beyond them).

        They are `dt` s after the last ones.
        """
        last, near, ahead = self._last or angles, self._near, _AHEAD / dt
        for angle, before, (low, high) in zip(angles, last, self._free, strict=True):
            if not low <= angle + ahead * (angle - before) <= high:
                near = True
                break
        if near:
            kept = [
                self._softened(index, self._braked(index, angle, before, dt))
                for index, (angle, before) in enumerate(zip(angles, last, strict=True))]
            self._near = kept != list(angles)
            if self._near:
                angles = kept
        self.at_end = self._near and any(
            not low <= angle <= high for angle, (low, high) in zip(angles, self._free, strict=True))
        self._last = angles
        return angles

    def _braked(self, index: int, angle: float, before: float, dt: float) -> float:
        """Return the angle, or one nearer to the last, from which the joint can still brake within its range."""
        low, high = self._free[index]
        room = high - before if angle > before else before - low
        # A step s leaves room - s >= s^2 / (2 a dt^2).
        square = _BRAKING * dt * dt
        most = max(math.sqrt(square * (square + 2.0 * max(room, 0.0))) - square, square)
        return min(max(angle, before - most), before + most)

    def _softened(self, index: int, angle: float) -> float:
        (low, high), soft = self._free[index], self._limits[index][2]
        if angle > high:
            return high + soft * -math.expm1((high - angle) / soft)
        if angle < low:
            return low - soft * -math.expm1((angle - low) / soft)
        return angle
