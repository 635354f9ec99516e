"""Shifts the body over the feet that stand, where the gait's file asks for it: the crawl of four legs needs that.

It looks ahead on the gait's circles: which feet will stand together, one support after the other, and where. It
chooses the shift, nearest to the present one, that keeps the centre of mass a margin inside all those polygons,
for as many supports ahead as one shift can serve. The body goes there with least jerk; lift-offs wait until it
has arrived. The centre of mass is taken to be fixed in the body: that of the standing robot.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from robotwalk.body import advanced, placed, seen_from
from robotwalk.gait import Gait, GaitClock, Support
from robotwalk.kinematics import resting_angles
from robotwalk.model import RobotModel
from robotwalk.stepping import Footfalls, footprint
from robotwalk.support import HalfPlane, centre_of_mass, nearest_inside, support_polygon
from robotwalk.swing import Motion, least_jerk
from robotwalk.types import Pose, Twist, Vec3

_NEW_SHIFT = 3e-3  # m; a smaller change of aim does not start a shift anew
_FOLLOWING = 0.08  # s in which such a change is followed
_RETURN = 1.0  # m/s^2, back to the course
_LEAST_JERK_PEAK = 10.0 / math.sqrt(3.0)  # largest acceleration x time^2 / way of a least-jerk motion from rest to rest
_AT_REST = 5e-4  # m
_ROUNDING = 1e-6  # s
_STILL = Motion(0.0, 0.0, 0.0)


class _Stand(NamedTuple):
    """Feet that will stand together."""

    begin: float  # s from now
    end: float
    feet: list[Vec3]  # in odom


class Sway:
    """The shift of one robot's body, along its own x and y."""

    def __init__(self, model: RobotModel) -> None:
        self._legs = model.legs
        self._centre = centre_of_mass(model, resting_angles(model, model.heights.stand))
        self._x = self._y = _STILL
        self._aim = (0.0, 0.0)
        self._left = 0.0  # s until the aim shall be reached
        self._situation: object = None  # for which the aim was chosen
        self._waiting = False

    @property
    def at_rest(self) -> bool:
        """Tell whether the body is on its course again."""
        return self._aim == (0.0, 0.0) and math.hypot(self._x.position, self._y.position) <= _AT_REST

    def release(self, until_lift_off: float) -> bool:
        """Aim for no shift at all; tell whether lift-offs, the next in `until_lift_off` s, have to wait for it."""
        self._situation = None
        self._head_for((0.0, 0.0), 0.0, _RETURN)
        return self._left > until_lift_off + _ROUNDING

    def plan(
        self, clock: GaitClock, footfalls: Footfalls, course: Pose, pose: Pose, twist: Twist, until_lift_off: float
    ) -> bool:
        """Aim for the feet that will stand; tell whether lift-offs have to wait for the shift.

        Args:
            clock: the needle of a gait that asks for balance.
            footfalls: the feet.
            course: of the body, in odom.
            pose: of the body without the shift, in odom.
            twist: in force.
            until_lift_off: s to the next one.
        """
        gait = clock.gait
        assert gait.balance is not None
        posture = (pose.x - course.x, pose.y - course.y, pose.yaw - course.yaw)
        # In steady motion a plan holds; while the needle waits, the body moves on.
        situation = (gait, gait.support_at(clock.phase), footfalls.planted, twist, posture)
        if self._waiting or situation != self._situation:
            self._situation = situation
            level = pose._replace(roll=0.0, pitch=0.0)
            aim = self._best_aim(self._stands(clock, footfalls, course, twist), level, twist, gait.balance.margin)
            self._head_for(aim, until_lift_off, gait.balance.acceleration)
        self._waiting = self._left > until_lift_off + _ROUNDING
        return self._waiting

    def step(self, pose: Pose, dt: float) -> Pose:
        """Advance by `dt` s; return the body's pose in odom, shifted."""
        if self._aim == (0.0, 0.0) and self._x == self._y == _STILL:
            return pose
        remaining = max(self._left, _FOLLOWING)
        self._x = least_jerk(self._x, self._aim[0], remaining, dt)
        self._y = least_jerk(self._y, self._aim[1], remaining, dt)
        self._left = max(self._left - dt, 0.0)
        x, y = placed(pose, Vec3(self._x.position, self._y.position, 0.0))
        return pose._replace(x=x, y=y)

    def _head_for(self, aim: tuple[float, float], seconds: float, acceleration: float) -> None:
        """Change the aim; a new shift takes `seconds`, or longer if it would be firmer than `acceleration`."""
        if math.dist(aim, self._aim) > _NEW_SHIFT:
            way = math.dist(aim, (self._x.position, self._y.position))
            self._left = max(seconds, math.sqrt(_LEAST_JERK_PEAK * way / acceleration))
        self._aim = aim

    def _best_aim(
        self, stands: Iterable[_Stand], level: Pose, twist: Twist, margin: float
    ) -> tuple[float, float]:
        """Return the shift nearest to the present aim that serves as many of the stands, in order, as one shift can."""
        planes: list[HalfPlane] = []
        aim: tuple[float, float] | None = None
        for stand in stands:
            allowed = self._allowed(stand, level, twist, margin)
            planes += allowed
            nearest = nearest_inside(*self._aim, planes) if allowed else None
            if nearest is None:
                # Where the first stand allows nothing, its feet are in a line or too near each other.
                return aim or self._middle(stand, level, twist)
            aim = nearest
        return aim or self._aim

    def _stands(self, clock: GaitClock, footfalls: Footfalls, course: Pose, twist: Twist) -> Iterator[_Stand]:
        """Yield the feet that stand now and then the supports of the coming turn, where some foot is in the air."""
        gait, period, planted = clock.gait, clock.period, footfalls.planted
        places = list(footfalls.footprints)
        first = gait.support_at(clock.phase)
        if planted != gait.supports[first].standing:
            yield from _stand(0.0, 0.0, places, planted)
        end = 0.0
        for index in range(first, first + len(gait.supports)):
            support = gait.supports[index % len(gait.supports)]
            begin, end = end, end + period * (support.left(clock.phase) if index == first else support.length)
            yield from _stand(begin, end, places, support.standing)
            for foot, leg in enumerate(self._legs):
                # What is in the air now has its footprint; the others' will be below the body then.
                if not support.standing[foot] and (planted[foot] or index != first):
                    stance = _stance_after(gait, foot, support) * period
                    places[foot] = footprint(leg, course, twist, end + 0.5 * stance)

    def _allowed(self, stand: _Stand, level: Pose, twist: Twist, margin: float) -> list[HalfPlane]:
        """Return where the shift must lie, so that a stand bears the body from its begin to its end."""
        allowed = []
        for time in (stand.begin, stand.end):
            feet = seen_from(advanced(level, twist, time), stand.feet)
            for nx, ny, bound in support_polygon(feet):
                reached = nx * self._centre.x + ny * self._centre.y
                allowed.append(HalfPlane(nx, ny, bound + margin - reached))
        return allowed

    def _middle(self, stand: _Stand, level: Pose, twist: Twist) -> tuple[float, float]:
        feet = seen_from(advanced(level, twist, 0.5 * (stand.begin + stand.end)), stand.feet)
        count = max(len(feet), 1)
        return (sum(foot.x for foot in feet) / count - self._centre.x,
                sum(foot.y for foot in feet) / count - self._centre.y)


def _stand(
    begin: float, end: float, places: Sequence[tuple[float, float]], standing: Sequence[bool]
) -> Iterator[_Stand]:
    """Yield nothing if all feet stand."""
    if not all(standing):
        feet = [Vec3(*place, 0.0) for place, stands in zip(places, standing, strict=True) if stands]
        yield _Stand(begin, end, feet)


def _stance_after(gait: Gait, foot: int, support: Support) -> float:
    sector = gait.sector_at(foot, (support.start + 0.5 * support.length) % 1.0)
    return sector.stance if sector is not None else 0.0
