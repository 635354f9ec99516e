"""Keeps the pace: the way that is lost while a foot looks for ground is made up for, a little faster, later on."""

import math

from robotwalk.types import STILL, Twist

_FASTER = 0.3  # of the speed asked for, at most
_FULLY = 0.02  # m behind, from where on
_FORGOTTEN = 0.10  # m; what is lost beyond is not made up for


class Pace:
    """How far a robot is behind, m."""

    def __init__(self) -> None:
        self._behind = 0.0
        self._aim = STILL

    def step(self, aim: Twist, now: Twist, share: float, dt: float) -> float:
        """Return by how much to go faster, 1 or more.

        Args:
            aim: the twist to go for; the way behind is forgotten when it changes.
            now: the twist in force.
            share: of the aim that the standing feet can bear; less than 1, and way is lost.
            dt: s.
        """
        if aim != self._aim:
            self._aim, self._behind = aim, 0.0
        lost = (math.hypot(aim.vx, aim.vy) - math.hypot(now.vx, now.vy)) * dt
        if share < 1.0 or lost < 0.0:
            self._behind = min(max(self._behind + lost, 0.0), _FORGOTTEN)
        return 1.0 + _FASTER * min(self._behind / _FULLY, 1.0)
