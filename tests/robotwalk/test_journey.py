"""What a walk came to."""

import math

import pytest

from robotwalk.journey import Journey, Summary
from robotwalk.types import Pose

QUARTER = math.pi / 2.0


def pose(
    x: float = 0.0, y: float = 0.0, yaw: float = 0.0, *, z: float = 0.1, roll: float = 0.0, pitch: float = 0.0
) -> Pose:
    return Pose(x, y, z, roll, pitch, yaw)


def travelled(*poses: Pose, direction: float = 0.0) -> Summary:
    journey = Journey(poses[0], direction=direction, nominal_height=0.1)
    for each in poses[1:]:
        journey.add(each)
    return journey.summary()


def test_straight_ahead() -> None:
    summary = travelled(*(pose(1.0 + 0.1 * i, 2.0 + 0.01 * i) for i in range(11)))
    assert summary.distance == pytest.approx(1.0)
    assert summary.displacement == pytest.approx((1.0, 0.1, 0.0, 0.0, 0.0, 0.0))
    assert not summary.fell


def test_back_counts_negative() -> None:
    assert travelled(pose(), pose(0.5), pose(0.2)).distance == pytest.approx(0.2)
    assert travelled(pose(), pose(-0.5)).distance == pytest.approx(-0.5)


def test_sideways() -> None:
    summary = travelled(*(pose(0.02 * i, 0.1 * i) for i in range(11)), direction=QUARTER)
    assert summary.distance == pytest.approx(1.0)
    assert summary.displacement[:2] == pytest.approx((0.2, 1.0))


def test_the_displacement_is_in_the_frame_of_the_start() -> None:
    summary = travelled(pose(3.0, 4.0, QUARTER), pose(2.9, 4.5, QUARTER + 0.2, z=0.12))
    assert summary.displacement == pytest.approx((0.5, 0.1, 0.02, 0.0, 0.0, 0.2))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_turns_of_more_than_a_circle_add_up(side: float) -> None:
    angles = [side * math.radians(i) for i in range(451)]
    circle = [
        pose(0.5 * math.sin(abs(a)), side * 0.5 * (1.0 - math.cos(a)), math.remainder(a, math.tau)) for a in angles]
    summary = travelled(*circle)
    assert math.degrees(summary.displacement.yaw) == pytest.approx(side * 450.0)
    assert summary.distance == pytest.approx(0.5 * math.radians(450.0), rel=1e-4)
    assert summary.displacement[:2] == pytest.approx((0.5, side * 0.5))


def test_a_step_on_an_arc_counts_as_its_chord() -> None:
    quarter = [pose(math.sin(a), 1.0 - math.cos(a), a) for a in (0.0, math.pi / 6.0, math.pi / 3.0, QUARTER)]
    assert travelled(*quarter).distance == pytest.approx(3.0 * 2.0 * math.sin(math.pi / 12.0))


@pytest.mark.parametrize(("roll", "pitch", "tilt", "fell"), [
    (44.0, 0.0, 44.0, False),
    (46.0, 0.0, 46.0, True),
    (0.0, -46.0, 46.0, True),
    (30.0, 30.0, 41.41, False),  # cos 41.41 deg = cos 30 deg x cos 30 deg
    (35.0, 35.0, 47.86, True),
    (180.0, 0.0, 180.0, True),
])
def test_a_tilt_of_more_than_45_degrees_is_a_fall(roll: float, pitch: float, tilt: float, fell: bool) -> None:
    summary = travelled(pose(), pose(roll=math.radians(roll), pitch=math.radians(pitch)), pose())
    assert math.degrees(summary.max_tilt) == pytest.approx(tilt, abs=0.01)
    assert summary.fell is fell


def test_below_half_of_its_height_it_fell() -> None:
    assert not travelled(pose(), pose(z=0.051), pose()).fell
    low = travelled(pose(), pose(z=0.049), pose())
    assert low.fell
    assert low.min_height == 0.049
