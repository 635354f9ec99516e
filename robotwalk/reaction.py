"""How the body answers to its feet: it bobs and turns a little (PPS section 4; LAYER, Reaction; PARAM, body movement).

Each answer has a gain in the robot's file; at 0 it is off, and with all of them off nothing here is run.
"""

import math
from collections.abc import Sequence

from robotwalk.body import Ramp, composed, placed
from robotwalk.gait import Gait, GaitClock
from robotwalk.model import Leg, RobotModel
from robotwalk.pseudo_physics import Particle, mean_height
from robotwalk.settings import Reactions
from robotwalk.stepping import Footfalls
from robotwalk.types import LEVEL, Pose, Vec3

_ENTRY = 0.5  # s, about, until the body answers fully
_FASTEST_BOB = 0.15  # m/s
_FASTEST_TURN = 0.5  # rad/s
_MIDDLE = 1e-3  # m
_GONE = 1e-4


class Reaction:
    """The answers of one robot's body."""

    def __init__(self, model: RobotModel) -> None:
        self._legs = model.legs
        self._ground = model.foot_radius
        self._gains: Reactions = model.reactions
        self._off = self._gains.off
        self._begin()

    def _begin(self) -> None:
        self._share = Ramp(0.0, 1.0 / _ENTRY, _ENTRY)
        damping = self._gains.damping
        self._bob, self._turn = Ramp(0.0, _FASTEST_BOB, damping), Ramp(0.0, _FASTEST_TURN, damping)
        self._gait: Gait | None = None  # that the particles move by
        self._particles: list[Particle] = []
        self._rest = Ramp(0.0, _FASTEST_BOB)  # m, what is left of the height in the gait before
        self._height = 0.0
        self._phase = -1.0
        self.at_rest = True

    def step(
        self, pose: Pose, clock: GaitClock, footfalls: Footfalls, course: Pose, active: bool, dt: float
    ) -> Pose:
        """Advance by `dt` s; return the body's pose with its answers.

        Args:
            pose: of the body in odom, without them.
            clock: the needle.
            footfalls: the feet.
            course: of the body in odom.
            active: whether the robot walks; else the body goes back to its course.
            dt: s.
        """
        if self._off or (self.at_rest and not active):
            return pose
        gains = self._gains
        share = self._share.step(1.0 if active else 0.0, dt)
        height = share * gains.height * self._particle_height(clock, dt) if gains.height else 0.0
        bob = self._bob.step(share * gains.bob * _mean_lift(footfalls, self._ground), dt)
        turn = self._turn.step(share * gains.turn * self._angle(footfalls, course), dt)
        z = min(max(height + bob, -gains.largest_bob), gains.largest_bob)
        yaw = min(max(turn, -gains.largest_turn), gains.largest_turn)
        if not active and max(share, abs(z), abs(yaw)) < _GONE:
            self._begin()
            return pose
        self.at_rest = False
        return composed(pose, LEVEL._replace(z=z, yaw=yaw))

    def _particle_height(self, clock: GaitClock, dt: float) -> float:
        """Return the weighted height of the feet's particles over its mean in the cycle, m."""
        gait, weights, period = clock.gait, self._gains.weights, clock.period
        mean = mean_of(gait, weights) * period * period
        begins = gait is not self._gait
        if begins:
            self._gait = gait
            self._particles = [Particle.steady(sectors, clock.phase, period) for sectors in gait.feet]
        height = -mean
        for weight, sectors, particle in zip(weights, gait.feet, self._particles, strict=True):
            height += weight * particle.height
            if clock.phase != self._phase:  # while the needle waits, so do they
                particle.tick(sectors, clock.phase, period, dt)
        self._phase = clock.phase
        if begins:
            self._rest = Ramp(self._height - height, _FASTEST_BOB)
        self._height = height + self._rest.step(0.0, dt)
        return self._height

    def _angle(self, footfalls: Footfalls, course: Pose) -> float:
        feet = [_seen(course, centre) for centre in footfalls.centres]
        return mean_angle(self._legs, feet) if self._gains.turn_by == "angles" else forward_angle(self._legs, feet)


def mean_of(gait: Gait, weights: Sequence[float]) -> float:
    """Return the mean of the feet's weighted particles in steady motion, at a period of 1 s, m; it goes with T^2."""
    return sum(weight * mean_height(sectors) for weight, sectors in zip(weights, gait.feet, strict=True))


def mean_angle(legs: Sequence[Leg], feet: Sequence[tuple[float, float]]) -> float:
    """Return the mean of the angles, about the body, from each foot's rest position to the foot, rad (LAYER)."""
    total = 0.0
    for leg, (x, y) in zip(legs, feet, strict=True):
        rest = leg.rest_foot
        total += math.atan2(rest.x * y - rest.y * x, rest.x * x + rest.y * y)
    return total / len(legs)


def forward_angle(legs: Sequence[Leg], feet: Sequence[tuple[float, float]]) -> float:
    """Return the angle by which the right foot is ahead of the left one, the mean over the sides, rad (PARAM)."""
    ahead, across = [0.0, 0.0], [0.0, 0.0]  # left, right
    count = [0, 0]
    for leg, (x, y) in zip(legs, feet, strict=True):
        if abs(leg.rest_foot.y) > _MIDDLE:
            side = int(leg.rest_foot.y < 0.0)
            ahead[side] += x - leg.rest_foot.x
            across[side] += y
            count[side] += 1
    if not all(count):
        return 0.0
    left, right = (Vec3(ahead[side] / count[side], across[side] / count[side], 0.0) for side in (0, 1))
    return math.atan2(right.x - left.x, left.y - right.y)


def _mean_lift(footfalls: Footfalls, ground: float) -> float:
    """Return how high the feet are over those that stand, the mean, m."""
    standing = [c.z for c, planted in zip(footfalls.centres, footfalls.planted, strict=True) if planted]
    level = sum(standing) / len(standing) if standing else ground
    return sum(centre.z for centre in footfalls.centres) / len(footfalls.centres) - level


def _seen(course: Pose, point: Vec3) -> tuple[float, float]:
    """Return where a point of odom is in the axes of a level body, m."""
    x, y = placed(course, (0.0, 0.0, 0.0))
    c, s = math.cos(course.yaw), math.sin(course.yaw)
    dx, dy = point.x - x, point.y - y
    return c * dx + s * dy, c * dy - s * dx
