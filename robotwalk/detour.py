"""Another heading where a behaviour's own way is barred (ARTH section 7.1)."""

import math
from typing import NamedTuple

from robotwalk.barriers import Barrier
from robotwalk.behaviours import Behaviour
from robotwalk.estimator import Estimate
from robotwalk.types import STILL, Command, Pose, Twist

_BACK = 0.12  # m; feet that are held back stand against what holds them
_ASIDE = math.radians(100.0)  # from what was barred; along it, and a little away
_FIRST = 0.4  # m; about as broad as a hexapod stands
_PAST = 0.5  # m
_LONGEST = 1.0  # m; each detour that leads to a barrier again is followed by one twice as long
_AGAIN = 0.5  # m from the end of a detour within which a barrier counts as the same one


class _Leg(NamedTuple):
    """A straight part of a detour."""

    way: float  # rad in odom
    length: float  # m
    aside: bool = False


class Detour:
    """Lets a behaviour steer; where its way is barred, goes a little back, aside, and past: on the nearer side first.

    A behaviour that commands no heading goes on from aside, turned that way; else the robot goes sideways.
    """

    def __init__(self, behaviour: Behaviour) -> None:
        self._behaviour = behaviour
        self._legs: list[_Leg] = []  # still to go
        self._from = (0.0, 0.0)  # where the first of them began, or the last detour ended; m in odom
        self._length = 0.0  # m of the last one
        self._ahead = 0.0  # what was barred, rad in odom
        self._side = 0.0  # 1: to the left of it

    @property
    def done(self) -> bool:
        """Whether the behaviour is."""
        return self._behaviour.done

    def step(self, estimate: Estimate, dt: float) -> Command:
        """Return the command of this tick."""
        wanted, pose, barriers = self._behaviour.step(estimate, dt), estimate.pose, estimate.barriers
        speed = math.hypot(wanted.twist.vx, wanted.twist.vy)
        if speed == 0.0:
            return wanted
        if self._legs and math.dist(self._from, pose[:2]) >= self._legs[0].length:
            del self._legs[0]
            self._from = pose.x, pose.y
        way = self._legs[0].way if self._legs else pose.yaw + math.atan2(wanted.twist.vy, wanted.twist.vx)
        barrier = _in_the_way(barriers, way)
        if barrier is not None:
            self._set_out(barrier, barriers, way, pose, past=wanted.heading is not None)
            if not self._legs:
                return wanted._replace(twist=STILL)
        if not self._legs:
            return wanted
        course = self._legs[0].way - pose.yaw
        heading = wanted.heading
        if heading is None:
            heading = pose.yaw + math.remainder(self._legs[-1].way - pose.yaw, math.tau)
        return wanted._replace(twist=Twist(speed * math.cos(course), speed * math.sin(course), 0.0), heading=heading)

    def _set_out(
        self, barrier: Barrier, barriers: tuple[Barrier, ...], way: float, pose: Pose, *, past: bool
    ) -> None:
        """Choose a way that is not barred, if there is one."""
        here, ahead = (pose.x, pose.y), barrier.way
        if self._length == 0.0 or (not self._legs and math.dist(self._from, here) > _AGAIN):
            self._length = 0.5 * _FIRST
            self._side = math.copysign(1.0, math.remainder(way - ahead, math.tau))
        elif self._legs and self._legs[0].aside:
            ahead, self._side = self._ahead, -self._side
        self._length = min(2.0 * self._length, _LONGEST)
        self._from, self._ahead = here, ahead
        sides = (_Leg(ahead + side * _ASIDE, self._length, aside=True) for side in (self._side, -self._side))
        legs = _Leg(barrier.way + math.pi, _BACK), *sides
        self._legs = [leg for leg in legs if _in_the_way(barriers, leg.way) is None][:2]
        if past and self._legs:
            self._legs.append(_Leg(ahead, _PAST))


def _in_the_way(barriers: tuple[Barrier, ...], way: float) -> Barrier | None:
    return next((barrier for barrier in barriers if barrier.bars(way)), None)
