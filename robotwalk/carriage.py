"""How the body may be carried: as high, as far aside and as tilted as is asked for, if legs reach and feet hold it.

A posture must leave each foot room for a part of its stride, no joint near its limits, and the centre of mass where
the gait has it: well within the feet that stand, or no farther from their line than without the posture, for a gait
that is balanced only by its motion has nothing to spare. One that rocks the body has it level and no higher than usual:
rocked while it leaned, or higher up, it fell over.
"""

import math
from collections.abc import Callable, Set
from typing import NamedTuple

from robotwalk.body import seen_from
from robotwalk.gait import Gait
from robotwalk.kinematics import resting_angles, solver_for
from robotwalk.model import RobotModel
from robotwalk.support import beyond_edge, centre_of_mass
from robotwalk.types import LEVEL, Pose, Vec3

USUAL_ROOM = 0.55  # of its largest stride, that a foot may be from rest; half in a steady gait
MOST_ROOM = 0.85  # of it, at the most
_LEAST_ROOM = 0.3  # of it, that a posture must leave
_SPARES = tuple(math.radians(degrees) for degrees in (5.0, 3.0, 1.0, 0.0))  # to a joint's limit: servos overshoot
_MISS = 1e-4  # m
_NO_SWAY = 1e-3  # m
_DIRECTIONS = tuple((math.cos(k * math.tau / 6), math.sin(k * math.tau / 6)) for k in range(6))
_NEAR_ENOUGH = 1.0 / 16.0  # of a way
_MARGIN = 0.025  # m inside the feet that a posture must leave the centre of mass, where there was so much
_OFF_LINE = 3e-3  # m farther from the feet that it may be


class Carriage(NamedTuple):
    """A height and a posture, and what they leave the feet."""

    height: float  # m
    posture: Pose
    room: float  # share of its largest stride that a foot may be from rest

    @property
    def part(self) -> float:
        """The part of the usual strides that there is room for."""
        return min(self.room / USUAL_ROOM, 1.0)


class Bearable:
    """Goes from one bearable carriage of a robot to the next, as near to what is asked for as there is one.

    A tick tries one step, for it takes some solutions of each leg: all of the way, or half as much as before where
    legs did not reach that far.
    """

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self._solvers = tuple(solver_for(leg) for leg in model.legs)
        self._centre = centre_of_mass(model, resting_angles(model, model.heights.stand))
        self._asked: tuple[float, Pose, Set[Gait]] | None = None
        self._aim = self._now = Carriage(model.heights.stand, LEVEL, MOST_ROOM)
        self._step = self._widening = 0.0  # share of the way, to the aim and to the most room
        self._sway = 0.0  # m
        self._sways: dict[Gait, float] = {}
        # A robot that has less room at rest is as it is.
        self._start = self._now._replace(room=_LEAST_ROOM)
        self._spare = next((spare for spare in _SPARES if self._reaches(self._start, spare)), -math.inf)

    def step(self, height: float, posture: Pose, gaits: Set[Gait]) -> Carriage:
        """Return how to carry the body, m and rad, in these gaits, any of them; none while all feet stand."""
        asked = height, posture, gaits
        if asked != self._asked:
            self._asked = asked
            self._sway = max(map(self._sway_of, gaits), default=0.0)
            while self._sway > _NO_SWAY and not self._reaches(self._start, self._spare):
                self._sway *= 0.5
            if any(gait.rocking > 0.0 for gait in gaits):
                usual = self._model.heights.stand
                height = min(height, usual)
                posture = LEVEL._replace(z=min(posture.z, usual - height))
            share = _largest(lambda share: self._holds(_shifted(posture, share), gaits))
            self._aim = Carriage(height, _shifted(posture, share), MOST_ROOM)
            self._step, self._widening = 1.0, 1.0
            self._retreat()
        if self._now[:2] != self._aim[:2] and self._step > _NEAR_ENOUGH:
            self._approach()
        elif self._now.room < MOST_ROOM and self._widening > _NEAR_ENOUGH:
            self._widen()
        return self._now

    def _retreat(self) -> None:
        """Give up what cannot be borne in another gait, room first."""
        for kept in (self._now, self._now._replace(room=_LEAST_ROOM)):
            if self._reaches(kept, self._spare):
                self._now = kept
                return
        self._now = self._start

    def _approach(self) -> None:
        now, aim, step = self._now, self._aim, self._step
        if step < 1.0:
            posture = Pose(*(a + step * (b - a) for a, b in zip(now.posture, aim.posture, strict=True)))
            aim = Carriage(now.height + step * (aim.height - now.height), posture, MOST_ROOM)
        if self._reaches(aim, self._spare):
            self._now, self._widening = aim, 1.0
        elif self._reaches(aim._replace(room=_LEAST_ROOM), self._spare):
            self._now, self._widening = aim._replace(room=_LEAST_ROOM), 0.5
        else:
            self._step *= 0.5

    def _widen(self) -> None:
        """Look for more room."""
        wider = self._now._replace(room=self._now.room + self._widening * (MOST_ROOM - self._now.room))
        if self._reaches(wider, self._spare):
            self._now = wider
        else:
            self._widening *= 0.5

    def _sway_of(self, gait: Gait) -> float:
        """Return how far about a gait shifts the body over the feet that stand, m."""
        if gait.balance is None:
            return 0.0
        if gait not in self._sways:
            rest = [leg.rest_foot for leg in self._model.legs]
            off = max(
                beyond_edge([foot for foot, stands in zip(rest, support.standing, strict=True) if stands], self._centre)
                for support in gait.supports)
            self._sways[gait] = max(off + gait.balance.margin, 0.0)
        return self._sways[gait]

    def _reaches(self, carriage: Carriage, spare: float) -> bool:
        """Tell whether each foot can be anywhere so near to rest, and lifted there, joints so far off their limits."""
        height, posture, room = carriage
        body = posture._replace(z=height + posture.z)
        for leg, solver in zip(self._model.legs, self._solvers, strict=True):
            (x, y, _), ground = leg.rest_foot, self._model.foot_radius
            radius = room * leg.max_stride + self._sway
            places = [Vec3(x + radius * dx, y + radius * dy, ground) for dx, dy in _DIRECTIONS]
            for place in seen_from(body, [*places, Vec3(x, y, ground + leg.lift)]):
                angles, miss = solver.solve(*place)
                if miss > _MISS and spare >= 0.0:
                    return False
                for joint, angle in zip(leg.joints, angles, strict=True):
                    if not joint.lower + spare <= angle <= joint.upper - spare:
                        return False
        return True

    def _holds(self, posture: Pose, gaits: Set[Gait]) -> bool:
        """Tell whether the centre of mass is well over the feet that stand, or near enough to where it is level."""
        x, y, z = self._centre
        cr, sr = math.cos(posture.roll), math.sin(posture.roll)
        cp, sp = math.cos(posture.pitch), math.sin(posture.pitch)
        y, z = cr * y - sr * z, sr * y + cr * z
        x, z = cp * x + sp * z, cp * z - sp * x
        cy, sy = math.cos(posture.yaw), math.sin(posture.yaw)
        leaning = Vec3(posture.x + cy * x - sy * y, posture.y + sy * x + cy * y, z)
        return all(
            beyond_edge(feet, leaning) <= max(beyond_edge(feet, self._centre) + _OFF_LINE, -_MARGIN)
            for feet in self._standing(gaits))

    def _standing(self, gaits: Set[Gait]) -> list[list[Vec3]]:
        """Return the feet that stand together, at rest; a gait that shifts the body over them does so anyhow."""
        rest = [leg.rest_foot for leg in self._model.legs]
        return [rest] + [
            [foot for foot, stands in zip(rest, support.standing, strict=True) if stands]
            for gait in gaits if gait.balance is None
            for support in gait.supports if any(support.standing)]


def _shifted(posture: Pose, share: float) -> Pose:
    """Return a posture with a share of its shift aside."""
    return posture if share == 1.0 else posture._replace(x=share * posture.x, y=share * posture.y)


def _largest(allowed: Callable[[float], bool]) -> float:
    """Return a share, 1 or about as large as is allowed; 0 if none is."""
    if allowed(1.0):
        return 1.0
    low, step = 0.0, 0.5
    while step >= _NEAR_ENOUGH:
        low, step = (low + step if allowed(low + step) else low), 0.5 * step
    return low
