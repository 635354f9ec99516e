"""A heading that is kept by odometry while nothing else holds it."""

import math

import pytest

from robotwalk.steering import Steering
from robotwalk.types import STILL, Twist

DT = 0.01
AHEAD = Twist(0.1, 0.02, 0.0)


def veering(twist: Twist, rate: float, seconds: float = 10.0, held: bool = False) -> float:
    """Return the heading (rad) that a robot reaches whose legs add `rate` (rad/s) to every turn, from yaw 1."""
    steering, yaw = Steering(), 1.0
    for _ in range(round(seconds / DT)):
        steered = steering.step(twist, yaw, DT, held=held)
        assert steered[:2] == twist[:2]
        yaw += (steered.wz + rate) * DT
    return yaw - 1.0


def test_legs_that_walk_an_arc_are_steered_straight() -> None:
    # 2 deg/s: one degree is left alone, and two more are needed to ask for 2 deg/s the other way.
    assert math.degrees(veering(AHEAD, math.radians(2.0))) == pytest.approx(3.0, abs=0.1)
    assert math.degrees(veering(AHEAD, math.radians(-2.0))) == pytest.approx(-3.0, abs=0.1)


def test_turns_that_fall_short_are_made_up_for() -> None:
    assert math.degrees(veering(Twist(0.0, 0.0, 0.35), -0.03)) == pytest.approx(math.degrees(3.5), abs=3.0)


def test_a_degree_is_left_alone() -> None:
    steering = Steering()
    steering.step(AHEAD, 0.0, DT, held=False)
    for yaw in (0.99, -0.99):
        assert steering.step(AHEAD, math.radians(yaw), DT, held=False) is AHEAD


def test_the_correction_is_bounded() -> None:
    steering = Steering()
    steering.step(AHEAD, 0.0, DT, held=False)
    assert steering.step(AHEAD, 2.0, DT, held=False).wz == pytest.approx(-math.radians(6.0))


def test_a_held_heading_and_a_stand_still_are_not_interfered_with_and_forget_what_was() -> None:
    assert veering(AHEAD, 0.03, held=True) == pytest.approx(0.3, abs=1e-3)
    steering = Steering()
    steering.step(AHEAD, 0.0, DT, held=False)
    assert steering.step(STILL, 1.0, DT, held=False) == STILL
    assert steering.step(AHEAD, 1.0, DT, held=False) == AHEAD
