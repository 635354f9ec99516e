"""Where the centre of mass is, and how far inside the feet that stand."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotwalk import assembly
from robotwalk.chain import chain_points
from robotwalk.kinematics import resting_angles
from robotwalk.model import RobotModel
from robotwalk.stability import stability
from robotwalk.support import Masses
from robotwalk.types import LEVEL

ROBOTS = {name: assembly.load(name).model for name in ("hexapod", "quadruped")}


@given(st.sampled_from(sorted(ROBOTS)), st.lists(st.floats(-math.pi, math.pi), min_size=18, max_size=18))
def test_centre_and_feet_are_those_of_the_chains(name: str, drawn: list[float]) -> None:
    model = ROBOTS[name]
    angles = drawn[:len(model.joints)]
    moment, mass = [0.0, 0.0, 0.0], model.body_mass
    feet = []
    for leg in model.legs:
        points = chain_points(leg, angles[leg.span])
        feet.append(points[-1])
        lumps = [(joint.mass, [0.5 * (a + b) for a, b in zip(near, far, strict=True)])
                 for joint, near, far in zip(leg.joints, points, points[1:], strict=False)]
        for lump, place in [*lumps, (model.foot_mass, points[-1])]:
            mass += lump
            moment = [total + lump * component for total, component in zip(moment, place, strict=True)]
    centre, found = Masses(model).centre_and_feet(angles)
    assert centre == pytest.approx([component / mass for component in moment], abs=1e-12)
    assert found == [pytest.approx(foot, abs=1e-12) for foot in feet]


def stance(model: RobotModel, *standing: int, roll: float = 0.0, pitch: float = 0.0) -> float | None:
    planted = [index in standing for index in range(len(model.legs))]
    angles = resting_angles(model, model.heights.stand)
    return stability(*Masses(model).centre_and_feet(angles), planted, LEVEL._replace(roll=roll, pitch=pitch)).margin


def test_a_hexapod_on_its_tripod_and_on_fewer_feet() -> None:
    model = ROBOTS["hexapod"]
    # Left front and rear, right middle: 205.5, -205.5 and 0 mm ahead; the edge between front and middle is nearest.
    margin = stance(model, 0, 2, 4)
    assert margin == pytest.approx(0.1072, abs=1e-3)
    assert stance(model, 0, 1, 2) == pytest.approx(-0.165, abs=2e-3)  # all on the left
    assert stance(model, 0, 2) is None
    assert stance(model) is None


def test_on_a_slope_the_centre_of_mass_moves_downhill() -> None:
    model = ROBOTS["hexapod"]
    level = stance(model, 0, 1, 2, 3, 4, 5)
    assert level is not None
    # The nose up by 20 deg: the centre of mass, 90 mm above the feet, moves back by 31 mm over them.
    angles = resting_angles(model, model.heights.stand)
    uphill = stability(*Masses(model).centre_and_feet(angles), [True] * 6, LEVEL._replace(pitch=math.radians(-20.0)))
    base = stability(*Masses(model).centre_and_feet(angles), [True] * 6, LEVEL)
    over = [found.centre.x - sum(foot.x for foot in found.standing) / 6.0 for found in (base, uphill)]
    above = base.centre.z - base.standing[0].z
    assert over[1] - over[0] == pytest.approx(-above * math.sin(math.radians(20.0)), abs=1e-9)
    # Rolled to the left, the left side comes nearer.
    assert stance(model, 0, 2, 4, roll=math.radians(-15.0)) != stance(model, 0, 2, 4, roll=math.radians(15.0))
