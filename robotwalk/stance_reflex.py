"""The stance reflex: while the robot stands, a leg that is out of its place steps back to rest (ARTH section 6.1).

A leg may be stretched: feet that a shove has dragged aside stay there, for friction holds them, and servos push against
each other until one is overloaded. Goals do not tell of that, joints do. Or the ground may have given way beneath one:
it bore its part, and bears nothing any more. It steps alone, if the body stays well over the others; then the next one.

In what order: a robot that is stopped, held or on its way down takes no such step, nor one beside an edge, where feet
stand wherever there is ground; feet that look for ground come first, and a command to walk has all feet step anyway.
It does not fidget: a leg is stretched only once a shove has come to its end; what three steps in a row did not mend no
fourth one will; and a foot that never bore much, as on rough ground, has lost nothing.
"""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from robotwalk.body import placed, seen_from
from robotwalk.contact import Felt
from robotwalk.gait import Gait
from robotwalk.kinematics import resting_angles
from robotwalk.model import RobotModel
from robotwalk.stability import stability
from robotwalk.statics import GRAVITY
from robotwalk.support import centre_of_mass
from robotwalk.types import Pose, Vec3

_FAR = 0.2  # of its largest stride, that a foot is off rest; servos that are 30 % off their files have it half as far
_STEADY_FOR = 0.25  # s that one must be so far off; overloaded servos let go after 2 s
_STEADY = 4e-3  # m that it may move in that time
_MARGIN = 0.01  # m inside the feet that stay, for the centre of mass
_TRIES = 3
_FIRM = 0.1  # of the weight, that a foot bears
_FIRM_FOR = 1.0  # s of that, after which its ground was there
_LOST_FOR = 0.3  # s without any load, after which it is not


class Recall(NamedTuple):
    """A leg that is to step back to rest now."""

    leg: int
    why: str


class StanceReflex:
    """Finds the leg of one robot that is to step back."""

    def __init__(self, model: RobotModel, gaits: Iterable[Gait]) -> None:
        """Step by one of these gaits if the present one is balanced only by its motion: one that shifts the body."""
        self._legs = model.legs
        self._firm = _FIRM * model.mass * GRAVITY
        self._slips = model.contact is not None and model.contact.slip
        self._centre = centre_of_mass(model, resting_angles(model, model.heights.stand))
        self._balanced = next((gait for gait in gaits if gait.balance is not None), None)
        self._rests: Sequence[Vec3] = ()  # in the base frame, m
        self._lies: tuple[Pose, Pose] | None = None  # the body, where these are so
        self.forget()

    def forget(self) -> None:
        """Begin anew: the robot is under way, or on its way down."""
        self._tries = [0] * len(self._legs)  # steps of each that did not mend it
        self.pause()

    def pause(self) -> None:
        """Begin anew to look: the robot does not stand still."""
        self._farthest: int | None = None  # a leg that is stretched
        self._off = 0.0  # m, how far when that was noticed
        self._for = 0.0  # s since then
        self._firm_for = [0.0] * len(self._legs)  # s that each foot has borne its part
        self._lost_for = [0.0] * len(self._legs)  # s since one that did bears nothing

    def gait(self, gait: Gait) -> Gait:
        """Return the gait to step back in while the robot stands in this one."""
        return self._balanced if gait.dynamic and self._balanced is not None else gait

    def step(
        self, feet: Sequence[Vec3 | None], felt: Sequence[Felt | None], places: Sequence[Vec3], pose: Pose,
        course: Pose, gait: Gait, dt: float,
    ) -> Recall | None:
        """Look at a tick of a robot that stands at rest.

        Args:
            feet: where joints have them, in the base frame, m; None where one did not answer.
            felt: by each foot; empty where nothing can be felt.
            places: where they are told to stand, in odom, m.
            pose: of the body in odom, as it is told to be.
            course: of the body, over the ground that its feet stand on.
            gait: in which it stands.
            dt: s.
        """
        if (pose, course) != self._lies:
            self._lies = pose, course
            self._rests = seen_from(pose, [
                Vec3(*placed(course, leg.rest_foot), place.z) for leg, place in zip(self._legs, places, strict=True)])
        leg, why = self._groundless(felt, dt), "the ground gave way under it"
        if leg is None:
            leg, why = self._stretched(feet, dt), "it was stretched"
            if leg is not None:
                self._tries[leg] += 1
        if leg is None or not self._spared(leg, feet, pose, gait):
            return None
        self.pause()
        return Recall(leg, why)

    def _stretched(self, feet: Sequence[Vec3 | None], dt: float) -> int | None:
        """Return the leg that is stretched most, once it stays so."""
        farthest, most = None, 1.0
        for index, (leg, foot, rest) in enumerate(zip(self._legs, feet, self._rests, strict=True)):
            if foot is None:
                self._farthest = None
                return None
            share = math.hypot(foot.x - rest.x, foot.y - rest.y) / (_FAR * leg.max_stride)
            if share <= 0.5:
                self._tries[index] = 0
            elif share > most and self._tries[index] < _TRIES:
                farthest, most = index, share
        if farthest is None:
            self._farthest = None
            return None
        off = most * _FAR * self._legs[farthest].max_stride
        if farthest != self._farthest or abs(off - self._off) > _STEADY:
            self._farthest, self._off, self._for = farthest, off, 0.0
            return None
        self._for += dt
        return farthest if self._for >= _STEADY_FOR else None

    def _groundless(self, felt: Sequence[Felt | None], dt: float) -> int | None:
        """Return a leg whose foot bears nothing any more."""
        if not self._slips:
            return None
        for index, foot in enumerate(felt):
            if foot is None or foot.touching:
                self._lost_for[index] = 0.0
                if foot is not None and foot.load >= self._firm:
                    self._firm_for[index] += dt
            elif self._firm_for[index] >= _FIRM_FOR:
                self._lost_for[index] += dt
                if self._lost_for[index] >= _LOST_FOR:
                    return index
        return None

    def _spared(self, leg: int, feet: Sequence[Vec3 | None], pose: Pose, gait: Gait) -> bool:
        """Tell whether the body stays up without a foot: the others hold it where it is, or it shifts over them."""
        if self.gait(gait).balance is not None:
            return True
        others = [foot for index, foot in enumerate(feet) if index != leg and foot is not None]
        margin = stability(self._centre, others, [True] * len(others), pose).margin
        return margin is not None and margin > _MARGIN
