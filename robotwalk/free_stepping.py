"""When feet step without a clock, and where to: each when it has come too far from rest, group by group (LAYER).

A foot may be off its rest position by an offset that depends on the direction, and by an angle about the body; beyond,
it wants to step. Feet of one group step together, and those of the others wait until they have landed. Nobody waits for
his own group to be late, though: the group whose feet will be too far off first steps early enough for those behind it
to get their turns in time, so groups that start out alike fall into turns by themselves. A foot at the escape distance
steps whatever the turn, if those that stay hold the body.

For all that must be known before a walk, such as how fast a gait can be, the groups are as sectors of a circle, one
after the other, each as long as its share of a steady walk at full speed.
"""

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from robotwalk.body import advanced, placed
from robotwalk.config.gait_schema import GaitConfig, SteppingConfig, TimingConfig
from robotwalk.model import Leg, RobotModel
from robotwalk.support import support_margin
from robotwalk.types import STILL, Pose, Twist, Vec3

if TYPE_CHECKING:
    from robotwalk.foot import Foot  # which knows gaits, and they these rules

_SLACK = 0.9  # of the way between rest and the limits that a steady walk at full speed takes
_DIRECTIONS = 32
_NO_SPEED = 1e-9  # m/s; slower is standing still

Curve = Sequence[tuple[float, float]]


class SteppingCircles(GaitConfig):
    """The circles that stand for a gait of free stepping, and what it is."""

    stepping: SteppingConfig


def circles(config: SteppingConfig) -> SteppingCircles:
    """Return the sectors of groups that step in turn, as fast as their feet can bear."""
    count = len(config.groups)
    cosines = [math.cos(math.pi * index / _DIRECTIONS) for index in range(_DIRECTIONS + 1)]
    curves = (config.allowed, *config.allowed_of.values())
    stride = _SLACK * min(
        at(curve, -cosine) + config.overshoot * at(curve, cosine) for curve in curves for cosine in cosines)
    # While the others swing, a foot makes its stride, not a whole one: stance / stride = (count - 1) swings.
    share = stride / (count - 1 + stride)
    swing = {
        leg: [(index / count, index / count + share)] for index, group in enumerate(config.groups) for leg in group}
    common = config.model_dump(by_alias=True, include=set(TimingConfig.model_fields))
    return SteppingCircles.model_validate(common | {"swing": swing, "stepping": config})


def at(curve: Curve, place: float) -> float:
    """Return the value of a curve of straight pieces."""
    for (a, low), (b, high) in itertools.pairwise(curve):
        if place <= b:
            return low + (high - low) * max(place - a, 0.0) / (b - a)
    return curve[-1][1]


class FreeStepping:
    """The rules of one gait for one robot's feet. They look at the feet and keep no state of their own."""

    def __init__(self, config: SteppingConfig, model: RobotModel, slowest_period: float) -> None:
        """Fit the rules to a robot that has the legs of the groups; a foot leads by half the period, s, at most."""
        names = [leg.name for leg in model.legs]
        self.groups = tuple(tuple(names.index(leg) for leg in group) for group in config.groups)
        self._most = max(len(group) for group in self.groups)
        self._curves = [config.allowed_of.get(leg.name, config.allowed) for leg in model.legs]
        self._overshoot = config.overshoot
        self._largest_angle = math.radians(config.largest_angle_deg)
        self._escape = config.escape
        self._longest_lead = 0.5 * slowest_period  # s that a foot is set down ahead of the body, at most

    def due(self, feet: Sequence["Foot"], course: Pose, twist: Twist, seconds: float) -> list[int]:
        """Return which feet shall lift off now.

        Args:
            feet: all, in the order of the robot's legs.
            course: of the body in odom.
            twist: of the body.
            seconds: that a swing takes.
        """
        slack = self._slack(feet, course, twist)
        in_air = [index for index, foot in enumerate(feet) if foot.sector is not None]
        if not in_air:
            order = self._order(slack)
            gap = self._gap(feet, twist, seconds)
            if all(min(slack[index] for index in group) > turn * gap for turn, group in enumerate(order)):
                return []
            # Whoever could not wait for the group's next turn comes along.
            return [index for index in order[0] if slack[index] <= len(self.groups) * gap]
        escaping = sorted(
            (-self._stretch(index, foot, course), index) for index, foot in enumerate(feet) if foot.sector is None)
        for stretch, index in escaping:
            if -stretch <= self._escape:
                break
            if len(in_air) < self._most and self._holds(feet, {*in_air, index}, course):
                return [index]
        return []

    def waits(self, feet: Sequence["Foot"], course: Pose, twist: Twist, seconds: float) -> list[float]:
        """Return how long each foot would have to wait for its turn, s."""
        left = 0.0
        for foot in feet:
            if foot.sector is not None:
                swing = foot.swing if foot.search is None else None
                left = max(left, (1.0 - swing.progress) * seconds if swing is not None else seconds)
        waits = [0.0] * len(feet)
        for turn, group in enumerate(self._order(self._slack(feet, course, twist))):
            for index in group:
                waits[index] = left + turn * seconds
        return waits

    def footprint(self, index: int, leg: Leg, course: Pose, twist: Twist, remaining: float) -> tuple[float, float]:
        """Return where a foot shall land in `remaining` s, in odom, m: past rest, the way that the body goes there."""
        landing = advanced(course, twist, remaining)
        x, y = placed(landing, leg.rest_foot)
        ux, uy = passing(leg, twist)
        speed = math.hypot(ux, uy)
        if speed <= _NO_SPEED:
            return x, y
        ahead, _ = self._ranges(index, leg, twist)
        lead = min(ahead / speed, self._longest_lead)
        c, s = math.cos(landing.yaw), math.sin(landing.yaw)
        return x + lead * (c * ux - s * uy), y + lead * (s * ux + c * uy)

    def _gap(self, feet: Sequence["Foot"], twist: Twist, seconds: float) -> float:
        """Return the time from one group's lift-off to the next one's in an even walk, s; a swing's at the least."""
        cycle = math.inf
        for index, foot in enumerate(feet):
            speed = math.hypot(*passing(foot.leg, twist))
            if speed > _NO_SPEED:
                ahead, back = self._ranges(index, foot.leg, twist)
                cycle = min(cycle, min(ahead / speed, self._longest_lead) + back / speed + seconds)
        return max(cycle / len(self.groups), seconds) if cycle < math.inf else seconds

    def _ranges(self, index: int, leg: Leg, twist: Twist) -> tuple[float, float]:
        """Return how far past rest a foot is set down, and how far behind it may fall, m."""
        ux, uy = passing(leg, twist)
        along = ux / math.hypot(ux, uy)
        curve = self._curves[index]
        return self._overshoot * at(curve, along) * leg.max_stride, at(curve, -along) * leg.max_stride

    def _slack(self, feet: Sequence["Foot"], course: Pose, twist: Twist) -> list[float]:
        """Return in how many seconds each foot will be too far off, 0 if it is, infinity for those in the air."""
        return [
            math.inf if foot.sector is not None else self._until_too_far(index, foot, course, twist)
            for index, foot in enumerate(feet)]

    def _until_too_far(self, index: int, foot: "Foot", course: Pose, twist: Twist) -> float:
        if twist == STILL:
            return math.inf if foot.at_rest(course) else 0.0
        dx, dy = foot.offset(course)
        if self._stretch(index, foot, course) >= 1.0:
            return 0.0
        ux, uy = passing(foot.leg, twist)
        speed = math.hypot(ux, uy)
        if speed <= _NO_SPEED:
            return math.inf
        # The body goes on by u t; the foot meets the circle allowed on the side that it falls back to.
        _, allowed = self._ranges(index, foot.leg, twist)
        along = (dx * ux + dy * uy) / speed
        return max(along + math.sqrt(max(along * along + allowed * allowed - dx * dx - dy * dy, 0.0)), 0.0) / speed

    def _stretch(self, index: int, foot: "Foot", course: Pose) -> float:
        """Return how far a foot is off rest, as a share of what is allowed, in distance or in angle."""
        dx, dy = foot.offset(course)
        off = math.hypot(dx, dy)
        if off == 0.0:
            return 0.0
        rest = foot.leg.rest_foot
        x, y = rest.x + dx, rest.y + dy
        angle = abs(math.atan2(rest.x * y - rest.y * x, rest.x * x + rest.y * y))
        return max(off / (at(self._curves[index], dx / off) * foot.leg.max_stride), angle / self._largest_angle)

    def _order(self, slack: Sequence[float]) -> list[tuple[int, ...]]:
        """Return the groups, the one whose feet will be too far off first at the front."""
        return sorted(self.groups, key=lambda group: min(slack[index] for index in group))

    def _holds(self, feet: Sequence["Foot"], in_air: set[int], course: Pose) -> bool:
        """Tell whether the body does not fall if these feet are in the air: a group is trusted not to let it."""
        if any(in_air <= set(group) for group in self.groups):
            return True
        standing = [foot.place for index, foot in enumerate(feet) if index not in in_air]
        return len(standing) >= 3 and support_margin(standing, Vec3(course.x, course.y, 0.0)) > 0.0


def passing(leg: Leg, twist: Twist) -> tuple[float, float]:
    """Return the velocity at which the body passes over a leg's rest position, in the body's axes, m/s."""
    (vx, vy, wz), (x, y, _) = twist, leg.rest_foot
    return vx - wz * y, vy + wz * x
