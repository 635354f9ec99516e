"""Ways that lead nowhere: over an edge, or into what the feet cannot step over (ARTH section 7.1: impeded progress).

One foot may be unlucky. A way is barred where feet have given up twice with the body at about one place: looking for
ground, or stepping over what holds them back. It is barred as long as the body stays there, for all ways near it.
"""

import math
from typing import Literal, NamedTuple

from robotwalk.types import STILL, Pose, Twist

_SAME_PLACE = 0.15  # m; a hole may swallow one foot, an edge another one right after it
_SAME_WAY = math.radians(80.0)  # a way along the barrier is none into it
_BACK = 0.12  # m; far enough that feet at rest stand where the ground was sure
_SLOW = 0.06  # m/s
_MOST = 8  # that are remembered at once

Kind = Literal["edge", "obstacle"]


class GivingUp(NamedTuple):
    """A foot gives up its way."""

    kind: Kind
    way: float  # of its step, rad in odom


class Barrier(NamedTuple):
    """One way that leads nowhere."""

    kind: Kind
    x: float  # of the body in odom when it was found, m
    y: float
    way: float  # rad in odom

    def bars(self, way: float) -> bool:
        """Tell whether a way, rad in odom, leads into it."""
        return abs(math.remainder(way - self.way, math.tau)) < _SAME_WAY


class Barriers:
    """Those that one robot has found.

    Attributes:
        near: where the body is now.
        wary: the way, rad in odom, in which a foot found no ground about here, if one did.
        unsettled: whether a foot gave up on its way to rest since the robot was asked to stand.
    """

    def __init__(self) -> None:
        self.near: tuple[Barrier, ...] = ()
        self.wary: float | None = None
        self.unsettled = False
        self._giving_up = False  # some foot, in the last tick
        self._gave_up_at: Pose | None = None
        self._void: Barrier | None = None  # where a foot found no ground
        self._brink: Barrier | None = None  # from which the body has yet to draw back

    def step(self, course: Pose, twist: Twist, giving_up: GivingUp | None) -> Barrier | None:
        """Look at one tick; return what bars the way that is asked for.

        Args:
            course: of the body.
            twist: that is asked for, in the base frame.
            giving_up: a foot, just now.
        """
        if self.near:
            self.near = tuple([barrier for barrier in self.near if _about(barrier, course)])
        begins, self._giving_up = giving_up is not None and not self._giving_up, giving_up is not None
        self.unsettled = twist == STILL and (self.unsettled or begins)
        if begins and giving_up is not None:
            found = Barrier(giving_up.kind, course.x, course.y, giving_up.way)
            self._void = self._brink = found if found.kind == "edge" else None
            if not self._known(found.way):
                before, self._gave_up_at = self._gave_up_at, course
                if before is not None and _about(before, course):
                    self.near = (*self.near, found)[-_MOST:]
                    self._gave_up_at = None
        self.wary = self._void.way if self._void is not None and _about(self._void, course) else None
        if twist.vx == twist.vy == 0.0:
            return None
        return self._known(course.yaw + math.atan2(twist.vy, twist.vx))

    def draw_back(self, course: Pose, twist: Twist) -> Twist | None:
        """Return the twist that takes the body back from where a foot found no ground; None where it need not go.

        It need not once the twist that is asked for, in the base frame, leads elsewhere.
        """
        brink = self._brink
        if brink is None:
            return None
        speed = math.hypot(twist.vx, twist.vy)
        back = (brink.x - course.x) * math.cos(brink.way) + (brink.y - course.y) * math.sin(brink.way)
        if speed == 0.0 or back >= _BACK or not brink.bars(course.yaw + math.atan2(twist.vy, twist.vx)):
            self._brink = None
            return None
        speed, way = min(speed, _SLOW), brink.way - course.yaw
        return Twist(-speed * math.cos(way), -speed * math.sin(way), 0.0)

    def _known(self, way: float) -> Barrier | None:
        return next((barrier for barrier in self.near if barrier.bars(way)), None)


def _about(place: Barrier | Pose, course: Pose) -> bool:
    """Tell whether a place of odom is about where the body is."""
    return math.hypot(place.x - course.x, place.y - course.y) < _SAME_PLACE
