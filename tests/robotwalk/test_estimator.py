"""Leg odometry, fed with the joints of a robot whose servos are perfect."""

import math
from collections.abc import Sequence
from typing import Any

import pytest

from robotwalk.estimator import Estimate, Odometry
from robotwalk.model import RobotModel
from robotwalk.support import Masses
from robotwalk.types import Command, JointState, Twist

DT = 0.01


def heard(angles: Sequence[float], *, lost: Sequence[int] = ()) -> JointState:
    """Return the joints as read; those `lost` say nothing true."""
    n = len(angles)
    return JointState(
        tuple(0.7 if i in lost else a for i, a in enumerate(angles)), (0.0,) * n, (0.0,) * n,
        tuple(i not in lost for i in range(n)), (0.0,) * n)


def step(
    odometry: Odometry, model: RobotModel, joints: JointState, planted: Sequence[bool], commanded: Twist
) -> Estimate:
    _, feet = Masses(model).centre_and_feet(joints.position)
    return odometry.step(joints, feet, planted, commanded, DT)


def measured(
    robot: Any, twist: Twist, seconds: float = 10.0, gait: str | None = None, lost: Sequence[int] = ()
) -> tuple[list[Estimate], list[Any]]:
    """Walk, and return what odometry says, and what was."""
    odometry = Odometry(robot.model)
    estimates, frames = [], robot.walk(Command(twist, gait=gait), seconds)
    for frame in frames:
        joints = heard(frame.wanted.angles, lost=lost)
        estimates.append(step(odometry, robot.model, joints, frame.wanted.planted, frame.wanted.twist))
    return estimates, frames


@pytest.mark.parametrize("gait", ["tripod", "ripple", "wave"])
@pytest.mark.parametrize("twist", [Twist(0.06, 0.0, 0.0), Twist(0.0, -0.06, 0.0), Twist(0.03, 0.02, -0.2)])
def test_it_recovers_where_the_body_went(robot: Any, twist: Twist, gait: str) -> None:
    estimates, frames = measured(robot, twist, gait=gait)
    pose, first, last = estimates[-1].pose, frames[0], frames[-1]
    gone = math.dist((first.x, first.y), (last.x, last.y))
    assert math.dist((pose.x, pose.y), (last.x - first.x, last.y - first.y)) < 0.005 * gone
    assert pose.yaw == pytest.approx(last.yaw - first.yaw, rel=0.005, abs=1e-6)
    assert pose.z == pytest.approx(0.109, abs=1e-4)


def test_turning_on_the_spot_is_not_wrapped(robot: Any) -> None:
    estimates, frames = measured(robot, Twist(0.0, 0.0, 0.8), 10.0)
    assert frames[-1].yaw > 7.0
    assert estimates[-1].pose.yaw == pytest.approx(frames[-1].yaw, rel=0.005)
    assert abs(estimates[-1].pose.x) < 0.002
    assert abs(estimates[-1].pose.y) < 0.002


def test_it_needs_no_word_of_the_command(robot: Any) -> None:
    """The feet alone tell: a body that is told to go and does not, does not go."""
    odometry, still = Odometry(robot.model), robot.stand_up()[-1]
    for _ in range(200):
        estimate = step(odometry, robot.model, heard(still.wanted.angles), (True,) * 6, Twist(0.1, 0.0, 0.5))
    assert estimate.standing_feet == 6
    # Feet count 60 ms after they were set down; until then the command is all there is.
    assert math.hypot(estimate.pose.x, estimate.pose.y) < 0.1 * 0.07
    assert abs(estimate.pose.yaw) < 0.5 * 0.07


@pytest.mark.parametrize("lost", [[0], [7], [3, 17]])
def test_a_leg_with_a_silent_joint_is_left_out(robot: Any, lost: list[int]) -> None:
    estimates, frames = measured(robot, Twist(0.06, 0.0, 0.2), 6.0, "wave", lost)
    pose, first, last = estimates[-1].pose, frames[0], frames[-1]
    gone = math.dist((first.x, first.y), (last.x, last.y))
    assert math.dist((pose.x, pose.y), (last.x - first.x, last.y - first.y)) < 0.005 * gone
    assert pose.yaw == pytest.approx(last.yaw - first.yaw, rel=0.005)
    assert max(estimate.standing_feet for estimate in estimates) == 6 - len({joint // 3 for joint in lost})


@pytest.mark.parametrize(("planted", "lost"), [
    ((), ()),
    ((False,) * 6, ()),
    ((True,) * 6, range(18)),
    ((True,) + (False,) * 5, ()),
    ((True,) * 6, range(3, 18)),
])
def test_with_too_few_feet_it_goes_by_the_command(
    robot: Any, planted: tuple[bool, ...], lost: Sequence[int]
) -> None:
    odometry, still = Odometry(robot.model), robot.stand_up()[-1]
    for _ in range(100):
        joints = heard(still.wanted.angles, lost=lost)
        estimate = step(odometry, robot.model, joints, planted, Twist(0.1, 0.0, math.pi / 2.0))
    assert estimate.standing_feet < 2
    radius = 0.1 / (math.pi / 2.0)
    assert estimate.pose[:2] == pytest.approx((radius, radius))
    assert estimate.pose.yaw == pytest.approx(math.pi / 2.0)


def test_it_begins_seated(hexapod: RobotModel) -> None:
    estimate = step(Odometry(hexapod), hexapod, heard([0.0] * 18), (), Twist(0.0, 0.0, 0.0))
    assert estimate.pose == (0.0, 0.0, 0.03, 0.0, 0.0, 0.0)
