"""Where a foot is for given joint angles, and the way back."""

import math
from dataclasses import replace

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from robotwalk.chain import chain_points, foot_position
from robotwalk.kinematics import closed_form_for, resting_angles, solver_for
from robotwalk.model import Axis, Joint, Leg, RobotModel
from robotwalk.swing_paths import swing_path
from robotwalk.types import Vec3
from tests.shortening import assert_shortened

LEGS = {"lf": 0, "lm": 1, "lr": 2, "rf": 3, "rm": 4, "rr": 5}
HIP, FEMUR, TIBIA = 0.052, 0.066, 0.133
# At this bend the leg is as long as it gets without being shortened: 0.98 of the way from 67 to 199 mm.
KNEE = math.acos(((TIBIA + FEMUR - 0.02 * 2.0 * FEMUR)**2 - FEMUR**2 - TIBIA**2) / (2.0 * FEMUR * TIBIA)) + 1e-6

angle = st.floats(-math.pi, math.pi)
leg_index = st.integers(0, 5)


def degrees(*values: float) -> tuple[float, ...]:
    return tuple(math.radians(value) for value in values)


@pytest.mark.parametrize(("name", "angles", "foot"), [
    ("lf", (0, 0, 0), (0.2874838, 0.2474838, 0.0)),  # straight out at 45 deg, 52 + 66 + 133 mm
    ("lm", (0, -27.7, 107.1), (0.0, 0.2349015, -0.1000508)),  # the rest pose
    ("lm", (30, 0, 90), (-0.059, 0.2021910, -0.133)),  # shin straight down
    ("rm", (90, 0, 0), (0.251, -0.1, 0.0)),  # swung forward
    ("rm", (0, -90, 0), (0.0, -0.152, 0.199)),  # straight up
    ("lr", (-45, 90, 0), (-0.11, 0.122, -0.199)),  # swung to the side, straight down
])
def test_foot_by_hand(hexapod: RobotModel, name: str, angles: tuple[float, ...], foot: tuple[float, ...]) -> None:
    leg = hexapod.legs[LEGS[name]]
    assert foot_position(leg, degrees(*angles)) == pytest.approx(foot, abs=1e-7)
    assert solver_for(leg).foot(degrees(*angles)) == pytest.approx(foot, abs=1e-7)


@pytest.mark.parametrize(("axis", "link", "foot"), [
    (Axis.YAW, Vec3(0.1, 0.0, 0.0), (1.0, 2.1, 3.0)),
    (Axis.PITCH, Vec3(0.1, 0.0, 0.0), (1.0, 2.0, 2.9)),
    (Axis.PITCH, Vec3(0.0, 0.0, 0.1), (1.1, 2.0, 3.0)),
    (Axis.ROLL, Vec3(0.0, 0.1, 0.0), (1.0, 2.0, 3.1)),
    (Axis.ROLL, Vec3(0.0, 0.0, 0.1), (1.0, 1.9, 3.0)),
])
def test_a_quarter_turn_about_each_axis(axis: Axis, link: Vec3, foot: tuple[float, ...]) -> None:
    joint = Joint("j", axis, link, -2.0, 2.0, 0.0, 0.1, 0.01)
    leg = Leg("one", Vec3(1.0, 2.0, 3.0), 0.0, (joint,), 0, Vec3(0.0, 0.0, 0.0), 0.1, 0.03, swing_path("ellipse"), None)
    assert foot_position(leg, degrees(90)) == pytest.approx(foot, abs=1e-12)


def test_chain_points_run_from_the_mount_to_the_foot(hexapod: RobotModel) -> None:
    points = chain_points(hexapod.legs[LEGS["lm"]], degrees(0, -90, 90))
    expected = [(0.0, 0.1, 0.0), (0.0, 0.152, 0.0), (0.0, 0.152, 0.066), (0.0, 0.285, 0.066)]
    assert points == [pytest.approx(point, abs=1e-12) for point in expected]


@given(leg_index, angle, angle, angle)
def test_fast_and_generic_forward_kinematics_agree(
    hexapod: RobotModel, index: int, coxa: float, femur: float, tibia: float
) -> None:
    leg = hexapod.legs[index]
    fast = solver_for(leg).foot((coxa, femur, tibia))
    assert math.dist(fast, foot_position(leg, (coxa, femur, tibia))) < 1e-12


def share_of_limits(joint: Joint, share: float) -> float:
    return joint.lower + share * (joint.upper - joint.lower)


@given(leg_index, st.tuples(*[st.floats(0.0, 1.0)] * 3))
@example(0, (0.0, 0.0, 0.0))
@example(3, (1.0, 0.4, 1.0))
@example(5, (0.5, 1.0, 0.0))
def test_inverse_kinematics_finds_every_foot_within_the_limits(
    hexapod: RobotModel, index: int, shares: tuple[float, ...]
) -> None:
    leg = hexapod.legs[index]
    angles = [share_of_limits(joint, share) for joint, share in zip(leg.joints, shares, strict=True)]
    out = HIP + FEMUR * math.cos(angles[1]) + TIBIA * math.cos(angles[1] + angles[2])
    assume(abs(angles[2]) > KNEE)
    assume(out > 0.001)  # the leg faces its foot; drawn in past the coxa's axis, a foot is reached facing away
    foot = foot_position(leg, angles)
    solution = solver_for(leg).solve(*foot)
    assert solution.miss == 0.0
    assert math.dist(foot_position(leg, solution.angles), foot) < 1e-6
    assert solution.angles == pytest.approx(angles, abs=1e-6)


@given(
    leg_index, st.floats(-1.5, 1.5), st.floats(-math.pi, math.pi),
    st.floats(0.001, 0.067) | st.floats(0.199, 0.5))
def test_what_is_out_of_reach_is_pointed_at(
    hexapod: RobotModel, index: int, turn: float, drop: float, distance: float
) -> None:
    leg = hexapod.legs[index]
    heading = leg.yaw + turn
    out = HIP + distance * math.cos(drop)
    assume(out > 0.001)
    target = Vec3(
        leg.mount.x + out * math.cos(heading), leg.mount.y + out * math.sin(heading),
        leg.mount.z - distance * math.sin(drop))
    solution = solver_for(leg).solve(*target)
    points = chain_points(leg, solution.angles)
    joint, foot = points[1], points[-1]
    assert_shortened(joint, foot, target, solution.miss, TIBIA - FEMUR, TIBIA + FEMUR)


@given(leg_index, *[st.floats(allow_nan=False, allow_infinity=False, min_value=-1e6, max_value=1e6)] * 3)
def test_any_target_has_a_finite_answer(hexapod: RobotModel, index: int, x: float, y: float, z: float) -> None:
    solution = solver_for(hexapod.legs[index]).solve(x, y, z)
    assert all(math.isfinite(value) for value in (*solution.angles, solution.miss))


@pytest.mark.parametrize("index", range(6))
def test_targets_on_the_coxa_axis_and_on_the_femur_joint(hexapod: RobotModel, index: int) -> None:
    leg = hexapod.legs[index]
    below = leg.mount._replace(z=-0.15)
    assert math.dist(foot_position(leg, solver_for(leg).solve(*below).angles), below) < 1e-6
    hip = chain_points(leg, (0.0, 0.0, 0.0))[1]
    assert solver_for(leg).solve(*hip).miss == pytest.approx(TIBIA - FEMUR, abs=1e-4)


def test_resting_angles_are_those_of_the_robots_file(hexapod: RobotModel) -> None:
    angles = resting_angles(hexapod, hexapod.heights.stand)
    assert [math.degrees(a) for a in angles] == pytest.approx([0.0, -27.7, 107.1] * 6, abs=0.1)


def with_joints(leg: Leg, *joints: Joint) -> Leg:
    return replace(leg, joints=joints)


def test_chains_without_a_closed_form(hexapod: RobotModel) -> None:
    leg = hexapod.legs[0]
    coxa, femur, tibia = leg.joints
    for chain in (
        (femur, coxa, tibia),
        (coxa, femur),
        (coxa, femur, tibia, tibia),
        (coxa._replace(axis=Axis.ROLL), femur, tibia),
        (coxa, femur._replace(link=Vec3(0.066, 0.001, 0.0)), tibia),
        (coxa, femur, tibia._replace(link=Vec3(0.133, 0.0, -0.01))),
        (coxa._replace(link=Vec3(-0.052, 0.0, 0.0)), femur, tibia),
    ):
        assert closed_form_for(with_joints(leg, *chain)) is None
