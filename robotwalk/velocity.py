"""From the twist that is asked for to the twist that the robot can do now."""

import math
from typing import NamedTuple

from robotwalk.gait import Gait
from robotwalk.model import MotionLimits
from robotwalk.types import STILL, Twist


class Shaped(NamedTuple):
    """What becomes of a wanted twist."""

    twist: Twist  # in force now
    feasible: Twist  # where it is heading
    scale: float  # feasible / wanted, 1 where nothing was cut


def feasible(wanted: Twist, limits: MotionLimits, gait: Gait) -> tuple[Twist, float]:
    """Scale a twist as a whole, so that its direction and the arc's radius stay, to what robot and gait can do."""
    speed = math.hypot(wanted.vx, wanted.vy)
    scale = min(1.0, gait.largest_scale(wanted))
    if speed > limits.speed:
        scale = min(scale, limits.speed / speed)
    if abs(wanted.wz) > limits.turn:
        scale = min(scale, limits.turn / abs(wanted.wz))
    return Twist(wanted.vx * scale, wanted.vy * scale, wanted.wz * scale), scale


class VelocityShaper:
    """Approaches the feasible twist along a straight line in (vx, vy, wz), within the accelerations."""

    def __init__(self, limits: MotionLimits) -> None:
        self._limits = limits
        self._twist = STILL
        self._asked: tuple[Twist, Gait] | None = None
        self._feasible = (STILL, 1.0)

    @property
    def twist(self) -> Twist:
        """The twist in force."""
        return self._twist

    def feasible(self, wanted: Twist, gait: Gait) -> Twist:
        """Return what robot and gait can do of a twist."""
        # A command lasts for many ticks.
        if self._asked is None or self._asked[0] is not wanted or self._asked[1] is not gait:
            self._asked = wanted, gait
            self._feasible = feasible(wanted, self._limits, gait)
        return self._feasible[0]

    def step(self, wanted: Twist, gait: Gait, dt: float, hold_back: float = 1.0) -> Shaped:
        """Advance by `dt` s towards `wanted`, or a share of it while the feet cannot follow."""
        aim = self.feasible(wanted, gait)
        scale = self._feasible[1]
        aim = Twist(aim.vx * hold_back, aim.vy * hold_back, aim.wz * hold_back)
        now = self._twist
        dx, dy, dw = aim.vx - now.vx, aim.vy - now.vy, aim.wz - now.wz
        # The share of the way that this tick's accelerations allow.
        excess = max(
            math.hypot(dx, dy) / (self._limits.acceleration * dt),
            abs(dw) / (self._limits.turn_acceleration * dt),
        )
        if excess <= 1.0:
            self._twist = aim
        else:
            self._twist = Twist(now.vx + dx / excess, now.vy + dy / excess, now.wz + dw / excess)
        return Shaped(self._twist, aim, scale)
