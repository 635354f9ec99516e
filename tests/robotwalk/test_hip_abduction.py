"""The quadruped's leg: where its foot is for given joint angles, and the way back."""

import math
from dataclasses import replace

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from robotwalk.chain import chain_points, foot_position
from robotwalk.config import library
from robotwalk.config.schema import RobotConfig
from robotwalk.kinematics import closed_form_for, resting_angles, solver_for
from robotwalk.model import Axis, Joint, Leg, RobotModel
from robotwalk.types import Vec3
from tests.shortening import assert_shortened

LEGS = {"lf": 0, "lr": 1, "rf": 2, "rr": 3}
OFFSET, THIGH, CALF = 0.040, 0.105, 0.120

angle = st.floats(-math.pi, math.pi)
leg_index = st.integers(0, 3)
knee_front = st.booleans()


@pytest.fixture(scope="module")
def quadruped() -> RobotModel:
    return RobotModel.from_config(library.open_document("robots", "quadruped").validate(RobotConfig))


def degrees(*values: float) -> tuple[float, ...]:
    return tuple(math.radians(value) for value in values)


def variant(leg: Leg, knee_front: bool) -> Leg:
    """Return a leg whose knee bends the other way at rest, and whose mount is turned, if asked for."""
    if not knee_front:
        return leg
    hip, thigh, calf = leg.joints
    flipped = calf._replace(rest=-calf.rest, lower=-calf.upper, upper=-calf.lower)
    return replace(leg, joints=(hip, thigh, flipped), yaw=0.7)


@pytest.mark.parametrize(("name", "angles", "foot"), [
    ("lf", (0, 0, 0), (0.105, 0.09, -0.2)),  # hanging straight: 225 mm below a hip 25 mm up
    ("rf", (0, 0, 0), (0.105, -0.09, -0.2)),
    ("lr", (0, 90, 0), (-0.33, 0.09, 0.025)),  # swung straight back
    ("rr", (0, 90, -90), (-0.21, -0.09, -0.095)),  # thigh back, calf down
    ("lf", (90, 0, 0), (0.105, 0.275, 0.065)),  # rolled out to the left: the offset now points up
    ("rf", (90, 0, 0), (0.105, 0.175, -0.015)),  # rolled in: its offset points down
    ("rf", (-90, 0, 0), (0.105, -0.275, 0.065)),
])
def test_foot_by_hand(quadruped: RobotModel, name: str, angles: tuple[float, ...], foot: tuple[float, ...]) -> None:
    leg = quadruped.legs[LEGS[name]]
    assert foot_position(leg, degrees(*angles)) == pytest.approx(foot, abs=1e-12)
    assert solver_for(leg).foot(degrees(*angles)) == pytest.approx(foot, abs=1e-12)


@given(leg_index, knee_front, angle, angle, angle)
def test_fast_and_generic_forward_kinematics_agree(
    quadruped: RobotModel, index: int, front: bool, hip: float, thigh: float, calf: float
) -> None:
    leg = variant(quadruped.legs[index], front)
    assert math.dist(solver_for(leg).foot((hip, thigh, calf)), foot_position(leg, (hip, thigh, calf))) < 1e-12


@given(leg_index, knee_front, st.tuples(*[st.floats(0.0, 1.0)] * 3))
@example(0, False, (0.0, 0.0, 0.0))
@example(3, False, (1.0, 0.4, 1.0))
@example(2, True, (0.5, 1.0, 0.0))
def test_inverse_kinematics_finds_every_foot_within_the_limits(
    quadruped: RobotModel, index: int, front: bool, shares: tuple[float, ...]
) -> None:
    leg = variant(quadruped.legs[index], front)
    angles = [j.lower + share * (j.upper - j.lower) for j, share in zip(leg.joints, shares, strict=True)]
    drop = THIGH * math.cos(angles[1]) + CALF * math.cos(angles[1] + angles[2])
    assume(math.hypot(drop, THIGH * math.sin(angles[1]) + CALF * math.sin(angles[1] + angles[2])) < 0.2207)
    assume(drop > 0.001)  # folded up past the hip's axis, a foot is reached with the leg turned over
    foot = foot_position(leg, angles)
    solution = solver_for(leg).solve(*foot)
    assert solution.miss == 0.0
    assert math.dist(foot_position(leg, solution.angles), foot) < 1e-6
    assert solution.angles == pytest.approx(angles, abs=1e-6)


@given(
    leg_index, knee_front, st.floats(-1.5, 1.5), st.floats(-1.5, 1.5),
    st.floats(0.001, 0.015) | st.floats(0.225, 0.6))
def test_what_is_out_of_reach_is_pointed_at(
    quadruped: RobotModel, index: int, front: bool, roll: float, swing: float, distance: float
) -> None:
    leg = variant(quadruped.legs[index], front)
    # A straight leg of that length, rolled and swung: what it reaches lies in the leg's plane.
    hip, thigh, calf = leg.joints
    stretched = replace(leg, joints=(
        hip, thigh._replace(link=Vec3(0.0, 0.0, -distance)), calf._replace(link=Vec3(0.0, 0.0, 0.0))))
    target = foot_position(stretched, (roll, swing, 0.0))
    solution = solver_for(leg).solve(*target)
    points = chain_points(leg, solution.angles)
    joint, foot = points[1], points[-1]
    assert_shortened(joint, foot, target, solution.miss, CALF - THIGH, CALF + THIGH)


@given(leg_index, st.floats(0.0, 0.0399), st.floats(-math.pi, math.pi), st.floats(0.02, 0.2))
def test_nearer_to_the_hips_axis_than_its_link_the_miss_is_still_true(
    quadruped: RobotModel, index: int, radius: float, around: float, ahead: float
) -> None:
    leg = quadruped.legs[index]
    target = Vec3(
        leg.mount.x + ahead, leg.mount.y + radius * math.cos(around), leg.mount.z + radius * math.sin(around))
    solution = solver_for(leg).solve(*target)
    foot = foot_position(leg, solution.angles)
    assert math.dist(foot, target) == pytest.approx(solution.miss, abs=1e-9)
    assert solution.miss == pytest.approx(OFFSET - radius, abs=1e-6)  # no place that the leg can take is nearer


@given(leg_index, *[st.floats(allow_nan=False, allow_infinity=False, min_value=-1e6, max_value=1e6)] * 3)
@example(0, 0.105, 0.05, 0.025)  # the hip itself
def test_any_target_has_a_finite_answer_within_one_turn(
    quadruped: RobotModel, index: int, x: float, y: float, z: float
) -> None:
    solution = solver_for(quadruped.legs[index]).solve(x, y, z)
    assert all(abs(value) < 2.0 * math.pi for value in solution.angles)
    assert math.isfinite(solution.miss)


def test_the_knee_bends_as_at_rest(quadruped: RobotModel) -> None:
    leg = quadruped.legs[LEGS["lf"]]
    target = Vec3(0.105, 0.09, -0.14)
    back = solver_for(leg).solve(*target)
    front = solver_for(replace(variant(leg, True), yaw=0.0)).solve(*target)
    assert back.angles[2] < 0.0 < front.angles[2]
    assert chain_points(leg, back.angles)[2].x < 0.105 < chain_points(leg, front.angles)[2].x


def test_the_robot_stands_on_its_rest_pose_and_sits_well_inside_its_limits(quadruped: RobotModel) -> None:
    angles = resting_angles(quadruped, quadruped.heights.stand)
    assert [math.degrees(a) for a in angles] == pytest.approx([0.0, 44.0, -75.0] * 4, abs=1.5)
    seated = resting_angles(quadruped, 0.045)  # on its belly
    for joint, seat in zip(quadruped.joints, seated, strict=True):
        assert joint.lower + 0.3 <= seat <= joint.upper - 0.3, joint.name


def test_chains_without_a_closed_form(quadruped: RobotModel) -> None:
    leg = quadruped.legs[0]
    hip, thigh, calf = leg.joints

    def refused(*joints: Joint) -> None:
        assert closed_form_for(replace(leg, joints=joints)) is None

    refused(thigh, hip, calf)
    refused(hip, thigh)
    refused(hip, thigh, calf, calf)
    refused(hip._replace(axis=Axis.YAW), thigh, calf)
    refused(hip._replace(link=Vec3(0.001, 0.04, 0.0)), thigh, calf)
    refused(hip._replace(link=Vec3(0.0, 0.04, -0.01)), thigh, calf)
    refused(hip, thigh._replace(link=Vec3(0.0, 0.0, 0.105)), calf)
    refused(hip, thigh, calf._replace(link=Vec3(0.0, 0.01, -0.12)))
    refused(hip, thigh, calf._replace(rest=0.0))  # which way would its knee bend?
