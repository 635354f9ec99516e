"""From the twist that is asked for to the twist that the robot can do now."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.gait import Gait, GaitClock
from robotwalk.pseudo_physics import Stage, step_at
from robotwalk.settings import MotionLimits
from robotwalk.types import STILL, Twist

_BRAKING = 3.0  # times the acceleration, before a leg is over-stretched


class Feasible(NamedTuple):
    """What robot and gait can do of a wanted twist."""

    twist: Twist
    scale: float  # of the wanted one, 1 where nothing was cut
    fastest: float  # m/s of any foot over the ground


class Shaped(NamedTuple):
    """What becomes of a wanted twist."""

    twist: Twist  # in force now
    feasible: Twist  # where it is heading
    scale: float  # feasible / wanted, 1 where nothing was cut


def feasible(wanted: Twist, limits: MotionLimits, gait: Gait, part: float = 1.0) -> tuple[Twist, float]:
    """Scale a twist as a whole, so that its direction and the arc's radius stay, to what robot and gait can do.

    Strides are a `part` of what they may be else.
    """
    speed = math.hypot(wanted.vx, wanted.vy)
    scale = min(1.0, gait.largest_scale(wanted, part))
    if speed > limits.speed:
        scale = min(scale, limits.speed / speed)
    if abs(wanted.wz) > limits.turn:
        scale = min(scale, limits.turn / abs(wanted.wz))
    return Twist(wanted.vx * scale, wanted.vy * scale, wanted.wz * scale), scale


class Propulsion:
    """Tells when some foot pushes the body on: in the second half of its stance (PPS section 4).

    Feet that have stood since before the robot set off may push at once.
    """

    def __init__(self, feet: int) -> None:
        self._rested = [True] * feet  # not swung since the robot stood still

    def step(self, clock: GaitClock, planted: Sequence[bool], idle: bool) -> bool:
        """Look at the feet once a tick."""
        if idle or clock.gait.free is not None:  # there is no saying which half of its stance a foot is in
            self._rested = [True] * len(planted)
            return True
        pushes = False
        for foot, stands in enumerate(planted):
            if not stands:
                self._rested[foot] = False
            elif not pushes:
                pushes = (
                    self._rested[foot] or step_at(clock.gait.feet[foot], clock.phase).stage is Stage.PROPULSION)
        return pushes


class VelocityShaper:
    """Approaches the feasible twist along a straight line in (vx, vy, wz), within the accelerations."""

    def __init__(self, limits: MotionLimits) -> None:
        self._limits = limits
        self._twist = STILL
        self._asked: tuple[Twist, Gait, float] | None = None
        self._feasible = Feasible(STILL, 1.0, 0.0)

    @property
    def twist(self) -> Twist:
        """The twist in force."""
        return self._twist

    def halt(self) -> None:
        """Be at rest."""
        self._twist = STILL

    def feasible(self, wanted: Twist, gait: Gait, part: float = 1.0) -> Feasible:
        """Return what robot and gait can do of a twist, with strides that are a `part` of what they may be else."""
        # A command lasts for many ticks.
        asked = self._asked
        if asked is None or asked[0] is not wanted or asked[1] is not gait or asked[2] != part:
            self._asked = wanted, gait, part
            twist, scale = feasible(wanted, self._limits, gait, part)
            self._feasible = Feasible(twist, scale, max(gait.foot_speeds(twist)))
        return self._feasible

    def step(
        self, wanted: Twist, gait: Gait, dt: float, hold_back: float = 1.0, *, pushes: bool = True, part: float = 1.0,
        brake: bool = False, sideways: float = math.inf,
    ) -> Shaped:
        """Advance by `dt` s towards `wanted`, or a share of it while the feet cannot follow.

        While no foot `pushes` the twist stays as it is, but for a stop, or feet that cannot follow. The robot may
        `brake` more firmly than it sets off. To a side it goes with an acceleration of `sideways`, m/s^2, at most.
        """
        (vx, vy, wz), scale, _ = self.feasible(wanted, gait, part)
        aim = Twist(vx * hold_back, vy * hold_back, wz * hold_back)
        now = self._twist
        held_back = hold_back < 1.0 and math.hypot(*aim[:2]) <= math.hypot(*now[:2]) and abs(aim.wz) <= abs(now.wz)
        if not pushes and not held_back and wanted != STILL:
            return Shaped(now, aim, scale)
        dx, dy, dw = aim.vx - now.vx, aim.vy - now.vy, aim.wz - now.wz
        # The share of the way that this tick's accelerations allow.
        firmly = _BRAKING * dt if brake else dt
        excess = max(
            math.hypot(dx, dy) / (self._limits.acceleration * firmly),
            abs(dw) / (self._limits.turn_acceleration * firmly),
            abs(dy) / (sideways * firmly),
        )
        if excess <= 1.0:
            self._twist = aim
        else:
            self._twist = Twist(now.vx + dx / excess, now.vy + dy / excess, now.wz + dw / excess)
        return Shaped(self._twist, aim, scale)
