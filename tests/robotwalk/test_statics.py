"""What a standing robot's joints bear, against potential energy and the balance of moments."""

import math

import pytest

from robotwalk import assembly
from robotwalk.chain import chain_points, foot_position
from robotwalk.kinematics import resting_angles
from robotwalk.model import Leg, RobotModel
from robotwalk.statics import GRAVITY, Bearing, LegMasses, shared_loads, up_in_base
from robotwalk.support import centre_of_mass
from robotwalk.types import LEVEL, Vec3

STEP = 1e-5  # rad
UP = Vec3(0.0, 0.0, 1.0)


@pytest.fixture(scope="module", params=["hexapod", "quadruped"])
def model(request: pytest.FixtureRequest) -> RobotModel:
    return assembly.load(request.param).model


def bent(leg: Leg) -> list[float]:
    return [joint.rest + 0.2 * (index - 0.7) for index, joint in enumerate(leg.joints)]


def potential(model: RobotModel, leg: Leg, angles: list[float], up: Vec3) -> float:
    points = chain_points(leg, angles)
    height = [point.x * up.x + point.y * up.y + point.z * up.z for point in points]
    links = sum(j.mass * 0.5 * (a + b) for j, a, b in zip(leg.joints, height, height[1:], strict=False))
    return GRAVITY * (links + model.foot_mass * height[-1])


def test_jacobian_and_weights_are_the_derivatives_of_foot_and_potential(model: RobotModel) -> None:
    leg, up = model.legs[1], Vec3(*up_in_base(0.2, -0.3))
    angles = bent(leg)
    statics, _ = LegMasses(leg, model.foot_mass).statics(angles, up)
    assert statics.foot == pytest.approx(foot_position(leg, angles))
    for index in range(len(angles)):
        high, low = angles.copy(), angles.copy()
        high[index] += STEP
        low[index] -= STEP
        column = [
            (b - a) / (2.0 * STEP) for a, b in zip(foot_position(leg, low), foot_position(leg, high), strict=True)]
        assert statics.columns[index] == pytest.approx(column, abs=1e-8)
        lift = sum(a * b for a, b in zip(column, up, strict=True))
        assert statics.lifts[index] == pytest.approx(lift, abs=1e-8)
        slope = (potential(model, leg, high, up) - potential(model, leg, low, up)) / (2.0 * STEP)
        assert statics.weights[index] == pytest.approx(slope, abs=1e-8)


def test_up_is_seen_from_the_tilted_base() -> None:
    assert up_in_base(0.0, 0.1) == pytest.approx((-math.sin(0.1), 0.0, math.cos(0.1)))  # nose down: up lies behind
    assert up_in_base(0.1, 0.0) == pytest.approx((0.0, math.sin(0.1), math.cos(0.1)))


def test_loads_balance_the_weight_and_its_moments() -> None:
    feet, centre = [Vec3(0.2, 0.1, 0.0), Vec3(-0.15, 0.12, 0.0), Vec3(0.05, -0.2, 0.0)], Vec3(0.02, 0.0, 0.1)
    loads = shared_loads(feet, [1.0, 0.6, 1.0], centre, 20.0, UP)
    assert sum(loads) == pytest.approx(20.0)
    # The share with which a foot stands does not matter while three of them do: a little, for feet nearly in a line.
    assert sum(n * foot.x for n, foot in zip(loads, feet, strict=True)) == pytest.approx(20.0 * centre.x, abs=0.03)
    assert sum(n * foot.y for n, foot in zip(loads, feet, strict=True)) == pytest.approx(0.0, abs=0.1)


def test_a_foot_in_the_air_bears_nothing_and_none_pulls() -> None:
    feet = [Vec3(0.2, 0.1, 0.0), Vec3(-0.2, 0.1, 0.0), Vec3(0.0, -0.1, 0.0), Vec3(0.0, 0.1, 0.0)]
    loads = shared_loads(feet, [1.0, 1.0, 1.0, 0.0], Vec3(0.0, 0.15, 0.1), 20.0, UP)
    assert loads[3] == 0.0
    assert loads[2] == 0.0
    assert sum(loads) == pytest.approx(20.0)


def test_two_feet_bear_nothing_steadily() -> None:
    assert shared_loads([Vec3(0.1, 0.1, 0.0), Vec3(-0.1, -0.1, 0.0)], [1.0, 1.0], Vec3(0.0, 0.0, 0.1), 20.0, UP) == (
        pytest.approx((0.0, 0.0)))


def test_a_robot_at_rest_bears_its_weight_and_a_seated_one_none(model: RobotModel) -> None:
    angles, planted = resting_angles(model, model.heights.stand), (True,) * len(model.legs)
    bearing = Bearing(model)
    for _ in range(50):
        statics = bearing.step(angles, LEVEL, model.heights.stand, planted, 0.01)
    assert sum(statics.loads) == pytest.approx(model.mass * GRAVITY)
    centre = centre_of_mass(model, angles)
    moment = sum(load * (leg.foot[0] - centre.x) for load, leg in zip(statics.loads, statics.legs, strict=True))
    assert moment == pytest.approx(0.0, abs=0.02)
    seated = bearing.step(angles, LEVEL, model.heights.sit, planted, 0.01)
    assert seated.loads == pytest.approx((0.0,) * len(planted))
