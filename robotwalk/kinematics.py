"""From the feet to the joints, one leg at a time, in the base frame.

A closed form where the chain has one, cyclic coordinate descent for any other; a robot's file may choose (locomotion
sources: PPS section 3, PARAM's leg).
"""

from collections.abc import Sequence
from typing import Protocol

from robotwalk.ccd import CyclicDescent
from robotwalk.closed_forms import CoxaFemurTibia, HipAbduction
from robotwalk.model import Leg, RobotModel
from robotwalk.reach import Solution
from robotwalk.types import Vec3


class LegSolver(Protocol):
    """Both kinematics of one leg."""

    def foot(self, angles: Sequence[float]) -> Vec3:
        """Return what `foot_position` does, faster."""
        ...

    def solve(self, x: float, y: float, z: float) -> Solution:
        """Return the angles for a foot centre at (x, y, z) m in the base frame. Never raises."""
        ...


_CLOSED_FORMS: tuple[type[CoxaFemurTibia] | type[HipAbduction], ...] = (CoxaFemurTibia, HipAbduction)


def resting_angles(model: RobotModel, height: float) -> list[float]:
    """Return all joints' angles with the body level at `height` m and the feet at rest on the ground."""
    angles: list[float] = []
    for leg in model.legs:
        foot = leg.rest_foot
        angles.extend(solver_for(leg).solve(foot.x, foot.y, model.foot_radius - height).angles)
    return angles


def closed_form_for(leg: Leg) -> LegSolver | None:
    """Return the closed form for a leg's chain, if there is one."""
    return next((closed_form(leg) for closed_form in _CLOSED_FORMS if closed_form.fits(leg)), None)


def solver_for(leg: Leg) -> LegSolver:
    """Return a solver for one leg: the closed form for its chain, if there is one and its file does not forbid it."""
    return (None if leg.solver == "ccd" else closed_form_for(leg)) or CyclicDescent(leg)
