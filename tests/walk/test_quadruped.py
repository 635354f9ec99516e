"""The quadruped walks in MuJoCo through Feetech bytes, judged by what its body really does."""

import math
from typing import Any

import pytest

from robotwalk import assembly
from robotwalk.types import Command, Pose, Twist

from . import rig
from .rig import TURN
from .soak.sequences import Driver, Episode


def walk(robot: str | assembly.Blueprint = "quadruped", **plan: Any) -> dict[str, Any]:
    return rig.walk(robot, **plan)


def assert_sound(report: dict[str, Any]) -> None:
    rig.assert_sound(report, tilt_deg=10.0)


def assert_straight(report: dict[str, Any], metres: float, tolerance: float, turned: float = 8.0) -> None:
    assert_sound(report)
    assert report["distance_m"] == pytest.approx(metres, rel=tolerance)
    assert abs(report["heading_change_deg"]) < turned


def test_it_trots_if_nothing_is_said() -> None:
    report = walk(speed=0.15)
    assert report["gait"] == "trot"
    assert_straight(report, 1.5, 0.10)
    assert report["max_tilt_deg"] < 6.0
    assert abs(report["lateral_drift_m"]) < 0.10
    assert "limits" not in [event["kind"] for event in report["events"]]
    states = [event["text"] for event in report["events"] if event["kind"] == "state"]
    assert states == ["ready", "stand", "walk", "stand", "sit", "stop"]


def test_it_crawls() -> None:
    report = walk(speed=0.04, gait="crawl")
    assert_straight(report, 0.4, 0.08)
    assert report["max_tilt_deg"] < 4.0


@pytest.mark.parametrize("sign", [1, -1])
def test_it_turns_on_the_spot_in_trot(sign: int) -> None:
    report = walk(turn=sign * TURN, duration=9.0)
    assert_sound(report)
    assert report["heading_change_deg"] == pytest.approx(sign * 180.0, rel=0.10)
    assert math.hypot(report["displacement"]["x"], report["displacement"]["y"]) < 0.06


@pytest.mark.parametrize("seed", range(10))
def test_so_it_does_with_other_servos_than_its_files_say(seed: int) -> None:
    robot = rig.varied("quadruped", seed, 0.15)
    assert_straight(walk(robot, seed=seed, speed=0.15), 1.5, 0.15)
    # Its course is not held: odometry is not to be trusted while the body shifts.
    assert_straight(walk(robot, seed=seed, speed=0.04, gait="crawl"), 0.4, 0.12, turned=9.0)
    turned = walk(robot, seed=seed, turn=TURN, duration=6.0)
    assert_sound(turned)
    assert turned["heading_change_deg"] == pytest.approx(120.0, rel=0.15)


@pytest.mark.parametrize(("degrees", "servos_off_by"), [(180, 0.15), (135, 0.0)])
def test_on_flat_ground_it_crawls_no_worse_for_feeling_it(degrees: float, servos_off_by: float) -> None:
    robot = rig.varied("quadruped", 1, servos_off_by)
    blind = robot.blind
    vars(blind)["drives"] = robot.drives  # what its files say, not what its servos are
    plan: dict[str, Any] = {"speed": 0.04, "gait": "crawl", "direction": math.radians(degrees)}
    feels, trusts = walk(robot, **plan), walk(blind, **plan)
    assert feels["max_tilt_deg"] < trusts["max_tilt_deg"] + 0.3
    assert feels["distance_m"] > trusts["distance_m"] - 0.02 * 0.4
    assert abs(feels["heading_change_deg"]) < abs(trusts["heading_change_deg"]) + 1.0


@pytest.mark.parametrize(("gait", "speed"), [("trot", 0.10), ("crawl", 0.03)])
@pytest.mark.parametrize("degrees", [180, 90, -90])
def test_backwards_and_sideways_it_stays_up_and_roughly_on_course(gait: str, speed: float, degrees: float) -> None:
    report = walk(speed=speed, gait=gait, direction=math.radians(degrees))
    assert_sound(report)
    assert report["distance_m"] == pytest.approx(10.0 * speed, rel=0.20)


def test_it_stops_soon_after_it_crawled_to_a_side_though_odom_is_turned_under_its_feet() -> None:
    report = walk(speed=0.04, gait="crawl", direction=math.radians(-90))
    assert_sound(report)
    assert not [event for event in report["events"] if event["kind"] == "timeout"]
    assert report["ticks"] < 1900


@pytest.mark.parametrize("height", [0.135, 0.18])
@pytest.mark.parametrize(("gait", "speed"), [("trot", 0.15), ("crawl", 0.04)])
def test_it_walks_low_and_high(gait: str, speed: float, height: float) -> None:
    report = walk(speed=speed, gait=gait, height=height, duration=6.0)
    assert_sound(report)
    assert report["distance_m"] == pytest.approx(6.0 * speed, rel=0.15)


@pytest.mark.parametrize("rate_hz", [50, 200])
def test_it_walks_at_other_rates(rate_hz: int) -> None:
    assert_straight(walk(speed=0.15, duration=5.0, rate_hz=rate_hz), 0.75, 0.15)


def test_it_goes_over_from_trot_to_crawl_and_back() -> None:
    simulation = assembly.simulate("quadruped")
    tilts = []
    with simulation.robot as robot:
        robot.stand()
        robot.observers.append(lambda tick: tilts.append(max(
            abs(simulation.world.truth().base.roll), abs(simulation.world.truth().base.pitch))))
        for gait, speed in (("trot", 0.12), ("crawl", 0.04), ("trot", 0.12), ("crawl", -0.03)):
            robot.walk(vx=speed, seconds=3.0, gait=gait)
    assert max(tilts) < math.radians(10.0)


def test_a_pace_is_turned_back_and_left_with_another_posture() -> None:
    simulation = assembly.simulate("quadruped", seed=3)
    leaning = Pose(-0.029, 0.008, 0.016, math.radians(10.0), math.radians(5.0), math.radians(-5.0))
    aside = Pose(0.0, 0.029, 0.0, 0.0, math.radians(-4.5), math.radians(5.0))
    tilts = []
    with simulation.robot as robot:
        robot.stand()
        robot.observers.append(lambda tick: tilts.append(max(
            abs(simulation.world.truth().base.roll), abs(simulation.world.truth().base.pitch))))
        robot.follow(Driver([
            Episode(2.0, Command(Twist(0.0, -0.06, 0.0), gait="pace")),
            Episode(2.3, Command(Twist(0.0, 0.06, 0.0), gait="pace", posture=leaning)),
            Episode(1.2, Command(Twist(0.0, 0.06, 0.0), gait="wave", posture=aside))]), seconds=5.5)
    assert max(tilts) < math.radians(18.0)  # it leans by 10; it fell


def test_it_starts_seated_torque_off_well_inside_its_limits() -> None:
    simulation = assembly.simulate("quadruped")
    clock = simulation.world.clock
    clock.wait((), clock.now() + 500_000_000)
    truth = simulation.world.truth()
    for joint, angle in zip(simulation.robot.model.joints, truth.joints, strict=True):
        assert joint.lower + 0.3 <= angle <= joint.upper - 0.3, joint.name
    assert all(servo.table["torque_enable"] == 0 for servo in simulation.world.servos)
    assert truth.base.z == pytest.approx(0.045, abs=0.003)  # on its belly
