"""The body follows the plane of its feet."""

import math

import pytest

from robotwalk import assembly
from robotwalk.model import RobotModel
from robotwalk.orientation import Orientation
from robotwalk.settings import OrientationSettings
from robotwalk.types import LEVEL, Vec3

DT = 0.01
SETTINGS = OrientationSettings("full", 36.0, 12.0, 0.0, 1.0, in_swing=False)


@pytest.fixture(scope="module", params=["hexapod", "quadruped", "pentapod"])
def model(request: pytest.FixtureRequest) -> RobotModel:
    return assembly.load(request.param).model


def feet_on(model: RobotModel, ahead: float, left: float) -> list[Vec3]:
    """Return the resting feet on a plane that rises by these slopes and is 0.02 m high at the body's middle."""
    height = 0.02 + model.foot_radius
    return [
        Vec3(leg.rest_foot.x, leg.rest_foot.y, height + ahead * leg.rest_foot.x + left * leg.rest_foot.y)
        for leg in model.legs]


@pytest.mark.parametrize("mode", ["cheap", "full", "as_needed"])
def test_it_comes_to_lie_as_its_feet_do(model: RobotModel, mode: str) -> None:
    orientation = Orientation(model, SETTINGS._replace(mode=mode))  # type: ignore[arg-type]  # a literal
    for _ in range(500):
        change = orientation.step(feet_on(model, 0.2, -0.1), LEVEL, DT)
    assert change.pitch == pytest.approx(-math.atan(0.2), abs=0.005)  # uphill ahead: nose up
    assert change.roll == pytest.approx(math.atan(-0.1), abs=0.005)
    assert orientation.plane.at(LEVEL, 0.1, 0.0) == pytest.approx(0.04, abs=0.002)


def test_it_takes_its_time_and_does_not_overshoot_when_damped_critically(model: RobotModel) -> None:
    orientation = Orientation(model, SETTINGS)
    pitches = [orientation.step(feet_on(model, 0.2, 0.0), LEVEL, DT).pitch for _ in range(300)]
    assert abs(pitches[0]) < 0.001
    assert pitches == sorted(pitches, reverse=True)
    assert min(pitches) >= -math.atan(0.2) - 1e-3


def test_the_frontal_bias_makes_the_front_feet_count_more() -> None:
    hexapod = assembly.load("hexapod").model
    feet = [
        Vec3(leg.rest_foot.x, leg.rest_foot.y, 0.04 if leg.name.endswith("f") else 0.0) for leg in hexapod.legs]
    pitch = []
    for bias in (0.0, 2.0):
        orientation = Orientation(hexapod, SETTINGS._replace(frontal_bias=bias))
        for _ in range(500):
            change = orientation.step(feet, LEVEL, DT)
        pitch.append(-change.pitch)
    assert 0.0 < pitch[0] < pitch[1]
