"""A leg that is out: its joints that still obey carry it as high as they can, whatever hangs at the dead one.

The posture is searched for: of the angles of the living joints, those at which the lowest point of the leg is highest,
in the worst case of where the dead joints may be. It keeps outside of the body.
"""

import itertools
import math
from collections.abc import Collection, Sequence

from robotwalk.chain import chain_points
from robotwalk.model import Axis, Leg, RobotModel
from robotwalk.unfold import Unfold

_STEPS = 9  # angles of a living joint that are tried
_DEAD_STEPS = 3  # of a dead one
_MARGIN = 0.05  # rad inside its limits
_OUTSIDE = 0.02  # m that every point of the leg keeps beyond its mount, away from the body


class Folded:
    """The legs of one robot that are out."""

    def __init__(self, model: RobotModel, legs: Collection[str], dead: Collection[int]) -> None:
        """Fold these `legs`; `dead` are the slots of joints that do not obey."""
        self._postures = {
            leg.first + place: angle
            for leg in model.legs if leg.name in legs
            for place, angle in enumerate(posture(leg, {slot - leg.first for slot in dead}))}
        self._way: Unfold | None = None

    def start(self, positions: Sequence[float]) -> None:
        """Fold from where the joints are, rad; those of the other legs stay there."""
        self._way = Unfold(positions, [self._postures.get(slot, here) for slot, here in enumerate(positions)])

    def step(self, dt: float) -> list[float]:
        """Advance by `dt` s; return all joints' angles, rad."""
        assert self._way is not None
        return self._way.step(dt)


def posture(leg: Leg, dead: Collection[int]) -> list[float]:
    """Return the angles, rad, at which a leg is out of the way though its `dead` joints may be anywhere."""
    places = range(len(leg.joints))
    # Yaw keeps to its rest: beside the leg there are others.
    living = [place for place in places if place not in dead and leg.joints[place].axis is not Axis.YAW]
    hanging = [place for place in places if place in dead and leg.joints[place].axis is not Axis.YAW]
    angles = [joint.rest for joint in leg.joints]
    best, chosen = float("-inf"), list(angles)
    for tried in itertools.product(*(_angles(leg, place, _STEPS) for place in living)):
        for place, angle in zip(living, tried, strict=True):
            angles[place] = angle
        worst = float("inf")
        for hung in itertools.product(*(_angles(leg, place, _DEAD_STEPS) for place in hanging)):
            for place, angle in zip(hanging, hung, strict=True):
                angles[place] = angle
            worst = min(worst, _clearance(leg, angles))
        if worst > best:
            best, chosen = worst, list(angles)
    return chosen


def _angles(leg: Leg, place: int, count: int) -> list[float]:
    joint = leg.joints[place]
    low, high = joint.lower + _MARGIN, joint.upper - _MARGIN
    return [low + (high - low) * step / (count - 1) for step in range(count)]


def _clearance(leg: Leg, angles: Sequence[float]) -> float:
    """Return the height of the leg's lowest point, m; less if it is over the body or inside it."""
    mount, *points = chain_points(leg, angles)
    rest = leg.rest_foot
    ox, oy = rest.x - mount.x, rest.y - mount.y
    way = math.hypot(ox, oy)
    outside = min(((point.x - mount.x) * ox + (point.y - mount.y) * oy) / way for point in points)
    return min(point.z for point in points) + min(outside - _OUTSIDE, 0.0)
