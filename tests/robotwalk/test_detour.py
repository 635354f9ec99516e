"""Where ways are barred: what a detour makes of barriers, in the test's hands."""

import math

import pytest

from robotwalk.barriers import Barrier, Barriers, GivingUp
from robotwalk.behaviours import KeepHeading
from robotwalk.detour import Detour
from robotwalk.estimator import Estimate
from robotwalk.types import LEVEL, STILL, Pose, Twist

DT = 0.01
AHEAD, LEFT, BACK = Twist(0.1, 0.0, 0.0), Twist(0.0, 0.1, 0.0), Twist(-0.1, 0.0, 0.0)


def obstacle(way: float) -> GivingUp:
    return GivingUp("obstacle", way)


def test_a_way_is_barred_where_feet_gave_up_twice_and_as_long_as_the_body_is_there() -> None:
    barriers, there = Barriers(), LEVEL
    assert barriers.step(there, AHEAD, obstacle(0.1)) is None
    assert barriers.step(there, AHEAD, obstacle(0.1)) is None  # still the same foot
    assert barriers.step(there, AHEAD, None) is None
    found = barriers.step(there._replace(x=0.1), AHEAD, obstacle(0.0))
    assert found == Barrier("obstacle", 0.1, 0.0, 0.0)
    assert barriers.step(there, LEFT, None) is barriers.step(there, BACK, None) is None
    assert barriers.step(there._replace(yaw=math.pi), BACK, None) is found
    assert barriers.step(there, Twist(0.0, 0.0, 0.3), None) is None
    assert barriers.step(there._replace(x=-0.1), AHEAD, None) is None
    assert barriers.near == ()


def test_far_from_each_other_one_foot_and_another_may_be_unlucky() -> None:
    barriers = Barriers()
    for x in (0.0, 0.2, 0.4):
        assert barriers.step(LEVEL._replace(x=x), AHEAD, obstacle(0.0)) is None
        assert barriers.step(LEVEL._replace(x=x), AHEAD, None) is None


def steered(detour: Detour, *ways: float, pose: Pose = LEVEL) -> float | None:
    """Return the way that is taken at a place with these barriers, rad in odom; None: it stands."""
    barriers = tuple(Barrier("edge", pose.x, pose.y, way) for way in ways)
    command = detour.step(Estimate(pose, 6, barriers=barriers), DT)
    if command.twist == STILL:
        return None
    assert math.hypot(command.twist.vx, command.twist.vy) == pytest.approx(0.1)
    return math.remainder(pose.yaw + math.atan2(command.twist.vy, command.twist.vx), math.tau)


def test_it_goes_back_aside_and_past_and_farther_on_the_other_side_if_that_is_barred() -> None:
    detour = Detour(KeepHeading(0.0, speed=0.1, facing=0.0))
    assert steered(detour) == pytest.approx(0.0)
    assert abs(steered(detour, -0.2) or 0.0) == pytest.approx(math.pi - 0.2)  # an obstacle to the right of ahead
    left, right = -0.2 + math.radians(100.0), -0.2 - math.radians(100.0)
    assert steered(detour, -0.2, pose=LEVEL._replace(x=-0.13)) == pytest.approx(left)
    there = LEVEL._replace(x=-0.13, y=0.1)
    assert steered(detour, 1.4, pose=there) == pytest.approx(1.4 - math.pi)  # barred to the left: back from there
    there = LEVEL._replace(x=-0.13, y=-0.03)
    for y in (-0.03, -0.8):
        assert steered(detour, pose=there._replace(y=y)) == pytest.approx(right)
    assert steered(detour, pose=there._replace(y=-0.85)) == pytest.approx(-0.2)
    assert steered(detour, pose=there._replace(x=0.4, y=-0.85)) == pytest.approx(0.0)


def test_with_barriers_all_around_it_stands() -> None:
    assert steered(Detour(KeepHeading(0.0, speed=0.1)), 0.0, 1.57, 3.14, -1.57) is None
