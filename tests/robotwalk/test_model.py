"""The hexapod's file in SI units."""

import math

import pytest

from robotwalk.config import library
from robotwalk.config.document import Document
from robotwalk.config.schema import RobotConfig
from robotwalk.model import Axis, RobotModel

LEGS = ("lf", "lm", "lr", "rf", "rm", "rr")


def test_joints_come_leg_by_leg_from_the_body_to_the_foot(hexapod: RobotModel) -> None:
    assert tuple(leg.name for leg in hexapod.legs) == LEGS
    assert hexapod.joint_names == tuple(f"{leg}_{joint}" for leg in LEGS for joint in ("coxa", "femur", "tibia"))
    assert [joint.axis for joint in hexapod.joints] == [Axis.YAW, Axis.PITCH, Axis.PITCH] * 6
    for index, leg in enumerate(hexapod.legs):
        assert leg.span == slice(3 * index, 3 * index + 3)
        assert hexapod.joints[leg.span] == leg.joints


def test_limits_are_relative_to_the_rest_pose_in_the_file_and_absolute_here(hexapod: RobotModel) -> None:
    found = [tuple(map(math.degrees, (joint.lower, joint.rest, joint.upper))) for joint in hexapod.legs[0].joints]
    expected = [(-50.0, 0.0, 50.0), (-132.7, -27.7, 52.3), (12.1, 107.1, 167.1)]
    assert found == [pytest.approx(limits) for limits in expected]


def test_lengths_and_masses(hexapod: RobotModel) -> None:
    assert hexapod.mass == pytest.approx(2.35)
    assert hexapod.body_mass == pytest.approx(1.15)
    assert hexapod.body_box == pytest.approx((0.24, 0.2, 0.05))
    assert (hexapod.foot_radius, hexapod.foot_mass) == pytest.approx((0.009, 0.003))
    tibia = hexapod.legs[5].joints[2]
    assert tibia.link == pytest.approx((0.133, 0.0, 0.0))
    assert (tibia.mass, tibia.radius) == pytest.approx((0.087, 0.009))


def test_legs_stand_straight_out_from_their_mounts(hexapod: RobotModel) -> None:
    by_name = {leg.name: leg for leg in hexapod.legs}
    assert by_name["lm"].rest_foot == pytest.approx((0.0, 0.235, -0.1), abs=1e-12)
    # 110 + 135 cos 45 deg, 70 + 135 sin 45 deg
    assert by_name["rr"].rest_foot == pytest.approx((-0.2054594, -0.1654594, -0.1), abs=1e-7)
    assert by_name["rr"].mount == pytest.approx((-0.11, -0.07, 0.0))
    assert math.degrees(by_name["rr"].yaw) == pytest.approx(-135.0)
    assert (by_name["rr"].max_stride, by_name["rr"].lift) == pytest.approx((0.1, 0.03))


def test_a_foot_may_rest_beside_its_mount() -> None:
    text = (library.root() / "robots" / "hexapod.yaml").read_text().replace("rest_mm: [135, 0]", "rest_mm: [135, 20]")
    model = RobotModel.from_config(Document.parse(text, "beside.yaml").validate(RobotConfig))
    # The left middle mount faces left; its left is behind the body.
    assert model.legs[1].rest_foot == pytest.approx((-0.02, 0.235, -0.1), abs=1e-12)


def test_motion_limits(hexapod: RobotModel) -> None:
    motion = hexapod.motion
    assert motion == pytest.approx((0.25, 1.0471976, 0.3, 2.0943951, 0.3))
    assert (hexapod.heights.sit, hexapod.heights.stand) == pytest.approx((0.03, 0.109))
    assert hexapod.heights.lowest < hexapod.heights.stand < hexapod.heights.highest
    assert all(leg.swing_path.retracts for leg in hexapod.legs)
