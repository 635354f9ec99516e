"""How the body lies over its feet: pitch and roll from where they stand, and the height of the ground below it.

Pitch is the slope from each foot to its neighbour behind, roll that from each left foot to the right one beside it
(ARTH section 5.6: normalised average vectors, each leaving the other axis out). Angular acceleration about each axis
is c1 x error - c2 x velocity; the height follows in the same way.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from robotwalk.model import Leg, RobotModel
from robotwalk.plumb import Turn
from robotwalk.settings import OrientationSettings
from robotwalk.types import Pose, Vec3

_BESIDE = 1e-3  # m; a leg nearer than this to the body's middle line belongs to both sides
_LARGE_CHANGE = math.radians(3.0)  # of the cheap mode's pitch or roll, that calls for the full one


class GroundPlane(NamedTuple):
    """The ground as the feet know it, seen from a body's course."""

    height: float = 0.0  # m, below the body's middle, in odom
    ahead: float = 0.0  # slope, m up per m ahead
    left: float = 0.0  # slope, m up per m to the left

    def seen_at(self, course: Pose, x: float, y: float) -> "GroundPlane":
        """Return the same plane for a course that is at (x, y) of odom instead."""
        return GroundPlane(self.at(course, x, y), self.ahead, self.left)

    def at(self, course: Pose, x: float, y: float) -> float:
        """Return its height at a point of odom, m."""
        dx, dy = x - course.x, y - course.y
        c, s = math.cos(course.yaw), math.sin(course.yaw)
        return self.height + self.ahead * (c * dx + s * dy) + self.left * (c * dy - s * dx)


class _Following:
    """A value that follows another with acceleration c1 x error - c2 x velocity."""

    def __init__(self) -> None:
        self.value = self.rate = 0.0

    def step(self, target: float, c1: float, c2: float, dt: float) -> None:
        # Implicit in the velocity: stable at any tick.
        self.rate = (self.rate + c1 * (target - self.value) * dt) / (1.0 + c2 * dt + c1 * dt * dt)
        self.value += self.rate * dt


class _Pair(NamedTuple):
    """Two feet, by their legs' numbers, and how much they count."""

    first: int
    second: int
    weight: float


class Orientation:
    """Follows the plane of one robot's feet."""

    def __init__(self, model: RobotModel, settings: OrientationSettings) -> None:
        self._settings = settings
        self._foot_radius = model.foot_radius
        left = _from_front(model.legs, 1.0)
        right = _from_front(model.legs, -1.0)
        foremost = {side[0] for side in (left, right) if side}
        # The frontal bias is for pitch alone.
        self._behind = [
            _Pair(a, b, 1.0 + settings.frontal_bias if a in foremost else 1.0)
            for a, b in (*pairwise(left), *pairwise(right))]
        self._beside = [_Pair(a, b, 1.0) for a, b in zip(left, right, strict=False) if a != b]
        self._pitch, self._roll, self._height = _Following(), _Following(), _Following()

    @property
    def plane(self) -> GroundPlane:
        """The plane as the body follows it."""
        return GroundPlane(self._height.value, math.tan(-self._pitch.value), math.tan(self._roll.value))

    def turn(self, turn: Turn) -> None:
        """Have the ground turned with odom."""
        self._roll.value += turn.roll
        self._pitch.value += turn.pitch

    def step(self, feet: Sequence[Vec3], course: Pose, dt: float) -> Pose:
        """Advance by `dt` s; return what to add to a level body's pose: height, roll and pitch.

        Args:
            feet: their centres in odom where they stand, or stood last; m.
            course: of the body.
            dt: s.
        """
        settings = self._settings
        cx, cy, c, s = course.x, course.y, math.cos(course.yaw), math.sin(course.yaw)
        seen: list[tuple[float, float, float]] = []
        mx = my = mz = 0.0
        for fx, fy, fz in feet:
            dx, dy = fx - cx, fy - cy
            x, y, z = c * dx + s * dy, c * dy - s * dx, fz - self._foot_radius
            seen.append((x, y, z))
            mx, my, mz = mx + x, my + y, mz + z
        ahead, left = self._slopes(seen)
        count = len(seen)
        height = mz / count - ahead * mx / count - left * my / count
        c1, c2 = settings.c1, settings.c2
        self._pitch.step(-math.atan(ahead), c1, c2, dt)
        self._roll.step(math.atan(left), c1, c2, dt)
        self._height.step(height, c1, c2, dt)
        share = settings.share
        return Pose(0.0, 0.0, self._height.value, share * self._roll.value, share * self._pitch.value, 0.0)

    def _slopes(self, feet: Sequence[tuple[float, float, float]]) -> tuple[float, float]:
        """Return the slopes of the feet's plane, m up per m ahead and to the left."""
        mode = self._settings.mode
        if mode != "full":
            cheap = self._slope(feet, self._behind, 0), self._slope(feet, self._beside, 1)
            change = max(abs(math.atan(cheap[0]) + self._pitch.value), abs(math.atan(cheap[1]) - self._roll.value))
            if mode == "cheap" or change < _LARGE_CHANGE:
                return cheap
        return self._full_slope(feet, self._behind, 0), self._full_slope(feet, self._beside, 1)

    def _slope(
        self, feet: Sequence[tuple[float, float, float]], pairs: Sequence[_Pair], axis: int
    ) -> float:
        """Return the difference in elevation over the distance, both summed over the pairs."""
        rise = run = 0.0
        for a, b, weight in pairs:
            rise += weight * (feet[a][2] - feet[b][2])
            run += weight * (feet[a][axis] - feet[b][axis])
        return rise / run if run > 0.0 else 0.0

    def _full_slope(
        self, feet: Sequence[tuple[float, float, float]], pairs: Sequence[_Pair], axis: int
    ) -> float:
        """Return the slope of the mean of the normalised vectors between the pairs."""
        rise = run = 0.0
        for a, b, weight in pairs:
            up, along = feet[a][2] - feet[b][2], feet[a][axis] - feet[b][axis]
            length = math.hypot(up, along)
            if along > 0.0:
                rise, run = rise + weight * up / length, run + weight * along / length
        return rise / run if run > 0.0 else 0.0


def _from_front(legs: Sequence[Leg], side: float) -> list[int]:
    """Return a side's legs by their numbers, from the front."""
    return sorted(
        (index for index, leg in enumerate(legs) if side * leg.rest_foot.y > -_BESIDE),
        key=lambda index: -legs[index].rest_foot.x)
