"""A whole walk with perfect joints: what the feet do in the world, and what the joints are asked for."""

import math
import random
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import pytest

from robotwalk.checks import gait_reach, support_margin
from robotwalk.controller import twist_of
from robotwalk.gait import Gait
from robotwalk.model import RobotModel
from robotwalk.supervisor import State
from robotwalk.types import STILL, Command, Pose, Twist, Vec3

DT = 0.01
FASTEST_FOOT = 1.5  # m/s: 200 mm in 0.3 s with least jerk, 1.25 m/s, and what a moved target adds
FIRMEST_FOOT = 20.0  # m/s^2: the same step takes 12.8 m/s^2


def whims(robot: Any, seed: int, seconds: float) -> Iterator[Any]:
    """Yield the frames of a walk whose driver keeps changing his mind."""
    rng, heights = random.Random(seed), robot.model.heights
    robot.stand_up()
    robot.state = State.WALK
    ticks = 0
    while ticks < 100 * seconds:
        turn = rng.choice([0.0, rng.uniform(-1.2, 1.2)])
        twist = twist_of(rng.uniform(0.0, 0.3), rng.uniform(-math.pi, math.pi), turn)
        robot.command = Command(
            rng.choice([twist, twist, twist, STILL]),
            heading=rng.choice([None, None, rng.uniform(-3.0, 3.0)]),
            height=rng.choice([None, rng.uniform(heights.lowest, heights.highest)]),
            gait=rng.choice([None, "tripod", "ripple", "wave"]))
        for _ in range(rng.choice([10, 30, 100, 200, 400])):
            yield robot.tick()
            ticks += 1


def speeds(before: Any, after: Any) -> list[Vec3]:
    """Return the feet's velocities in odom between two ticks."""
    return [
        Vec3(*((b - a) / DT for a, b in zip(old, new, strict=True)))
        for old, new in zip(before.feet, after.feet, strict=True)
    ]


@pytest.mark.parametrize("seed", range(5))
def test_whatever_the_driver_does(robot: Any, seed: int) -> None:
    model, before, velocity = robot.model, None, None
    for frame in whims(robot, seed, 40.0):
        wanted = frame.wanted
        assert wanted.reach_error == 0.0
        for angle, joint in zip(wanted.angles, model.joints, strict=True):
            assert joint.lower <= angle <= joint.upper, joint.name
        standing = [foot for foot, planted in zip(frame.feet_in_base, wanted.planted, strict=True) if planted]
        assert len(standing) >= 3
        assert support_margin(standing, Vec3(0.0, 0.0, 0.0)) > 0.03
        assert max(foot.z for foot in standing) - min(foot.z for foot in standing) < 1e-6
        if before is not None:
            now = speeds(before, frame)
            for foot in range(6):
                if wanted.planted[foot] and before.wanted.planted[foot]:
                    assert math.dist(frame.feet[foot], before.feet[foot]) < 1e-6
                assert math.hypot(*now[foot]) < FASTEST_FOOT
                if velocity is not None:
                    assert math.dist(now[foot], velocity[foot]) < FIRMEST_FOOT * DT
            velocity = now
        before = frame


@pytest.mark.parametrize("seed", range(3))
def test_a_stop_brings_all_feet_to_rest_whatever_came_before(robot: Any, seed: int) -> None:
    for _ in whims(robot, 100 + seed, 5.0 + seed):
        pass
    robot.state, robot.command = State.STAND, Command()
    frames = robot.until(lambda wanted: wanted.standing, 10.0)
    rest = [leg.rest_foot for leg in robot.model.legs]
    for foot, place in zip(frames[-1].feet_in_base, rest, strict=True):
        assert math.dist(foot, place) < 3e-3
    after = list(robot.run(1.0))
    assert all(frame.wanted.standing and frame.wanted.twist == STILL for frame in after)
    assert after[-1].wanted.angles == pytest.approx(frames[-1].wanted.angles, abs=0.02)


def test_a_stop_is_not_put_off(robot: Any) -> None:
    robot.walk(Command(Twist(0.2, 0.0, 0.0)), 4.0)
    robot.state, robot.command = State.STAND, Command()
    frames = list(robot.run(1.0))
    # 0.2 m/s at 0.3 m/s^2
    assert frames[68].wanted.twist == STILL
    assert frames[68].x - frames[0].x == pytest.approx(0.2**2 / 0.6, rel=0.05)


def test_standing_up(robot: Any) -> None:
    frames = robot.stand_up()
    heights = [frame.height for frame in frames]
    assert all(all(frame.wanted.planted) for frame in frames)
    assert all(b >= a - 1e-9 for a, b in pairwise(heights))
    assert (heights[0], heights[-1]) == pytest.approx((0.025, 0.109), abs=1e-3)
    for frame in frames:
        for foot, place in zip(frame.feet, frames[-1].feet, strict=True):
            assert math.dist(foot[:2], place[:2]) < 5e-4
    assert not any(frame.wanted.seated for frame in frames)
    assert [frame.wanted.standing for frame in frames] == [False] * (len(frames) - 1) + [True]


@pytest.mark.parametrize("state", [State.SIT, State.FAULT])
def test_sitting_down(robot: Any, state: State) -> None:
    start = robot.stand_up()[-1]
    robot.state = state
    frames = robot.until(lambda wanted: wanted.seated)
    heights = [frame.height for frame in frames]
    assert all(b <= a + 1e-9 for a, b in pairwise(heights))
    assert heights[-1] == pytest.approx(0.03, abs=1e-3)
    for frame in frames:
        assert all(frame.wanted.planted)
        assert not frame.wanted.standing
        for foot, place in zip(frame.feet, start.feet, strict=True):
            assert math.dist(foot, place) < 1e-6


def test_a_walking_robot_steps_to_rest_before_it_sits(robot: Any) -> None:
    robot.walk(Command(Twist(0.15, 0.05, 0.3)), 3.3)
    robot.state = State.SIT
    frames = robot.until(lambda wanted: wanted.seated)
    for frame in frames:
        if not all(frame.wanted.planted):
            assert frame.height == pytest.approx(0.109, abs=1e-3)
    assert frames[-1].height == pytest.approx(0.03, abs=1e-3)
    for foot, leg in zip(frames[-1].feet_in_base, robot.model.legs, strict=True):
        assert math.dist(foot[:2], leg.rest_foot[:2]) < 2e-3


def test_a_robot_that_sits_may_stand_up_again(robot: Any) -> None:
    robot.stand_up()
    robot.state = State.SIT
    list(robot.run(0.7))
    frames = robot.stand_up()
    assert min(frame.height for frame in frames) > 0.06
    assert frames[-1].height == pytest.approx(0.109, abs=1e-3)


def test_until_it_is_told_to_stand_a_robot_holds_its_joints(robot: Any) -> None:
    found = [joint.rest + 0.1 for joint in robot.model.joints]
    robot.controller.start(found)
    robot.state = State.READY
    for frame in robot.run(1.0):
        assert frame.wanted.angles == pytest.approx(found)
        assert not frame.wanted.standing
        assert not frame.wanted.seated
    before = found
    robot.state = State.STAND
    for frame in robot.run(6.0):
        assert max(abs(b - a) for a, b in zip(before, frame.wanted.angles, strict=True)) < 2.0 * DT
        before = list(frame.wanted.angles)
    assert frame.wanted.standing


def test_a_robot_told_to_sit_before_it_stood_is_seated(robot: Any) -> None:
    robot.state = State.STAND
    list(robot.run(0.1))
    robot.state = State.FAULT
    # It may have been found standing: its joints arrive before it counts as seated.
    assert not robot.tick().wanted.seated
    assert robot.until(lambda wanted: wanted.seated, 4.0)


@pytest.mark.parametrize("wz", [0.5, -0.5])
def test_turning(robot: Any, wz: float) -> None:
    frames = robot.walk(Command(Twist(0.0, 0.0, wz)), 6.0)
    # 0.24 s to reach the rate.
    assert frames[-1].yaw == pytest.approx(wz * (6.0 - 0.5 * 0.5 / math.radians(120.0)), rel=0.01)
    assert math.hypot(frames[-1].x, frames[-1].y) < 1e-9
    half_a_turn = round(math.pi / abs(wz) / DT)
    arc = robot.walk(Command(Twist(0.1, 0.0, wz)), 12.0)
    here, there = arc[300], arc[300 + half_a_turn]
    assert math.dist((here.x, here.y), (there.x, there.y)) == pytest.approx(2.0 * 0.1 / 0.5, rel=0.01)


@pytest.mark.parametrize("gait", ["tripod", "wave"])
@pytest.mark.parametrize("heading", [1.2, -4.0])
def test_a_heading_is_turned_to_and_held(robot: Any, heading: float, gait: str) -> None:
    twist = Twist(0.05, 0.0, 0.7)  # the rate gives way to the heading
    frames = robot.walk(Command(twist, heading=heading, gait=gait), 25.0)
    yaws = [frame.yaw for frame in frames]
    assert all(yaw == pytest.approx(heading, abs=0.005) for yaw in yaws[-300:])
    assert max(abs(yaw) for yaw in yaws) < abs(heading) + 0.05
    if gait == "tripod":  # the turn is cut to what the robot can, so that the speed is not
        assert min(frame.wanted.scale for frame in frames) > 0.9
    assert max(abs(b - a) for a, b in pairwise(yaws)) <= math.radians(60.0) * DT + 1e-9
    way = math.atan2(frames[-1].y - frames[-300].y, frames[-1].x - frames[-300].x)
    assert math.remainder(way - heading, math.tau) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize(("gait", "most_in_air", "speed"), [("wave", 1, 0.0667), ("ripple", 2, 0.1667)])
def test_a_change_of_gait_takes_place_while_walking(robot: Any, gait: str, most_in_air: int, speed: float) -> None:
    robot.walk(Command(Twist(0.25, 0.0, 0.0)), 4.0)
    robot.walk(Command(Twist(0.25, 0.0, 0.0), gait=gait), 8.0)
    frames = robot.walk(Command(Twist(0.25, 0.0, 0.0), gait=gait), 4.0)
    assert min(sum(frame.wanted.planted) for frame in frames) == 6 - most_in_air
    assert frames[-1].wanted.twist.vx == pytest.approx(speed, rel=0.06)
    robot.walk(Command(Twist(0.25, 0.0, 0.0), gait="tripod"), 8.0)
    assert robot.tick().wanted.twist.vx == pytest.approx(0.25)


@pytest.mark.parametrize("ticks", range(0, 60, 6))
def test_a_change_of_gait_stretches_no_foot_at_whatever_moment_it_comes(robot: Any, ticks: int) -> None:
    robot.walk(Command(Twist(0.16, 0.0, 0.0)), 3.0 + ticks * DT)
    for frame in robot.walk(Command(Twist(0.16, 0.0, 0.0), gait="ripple"), 2.5):
        for foot, leg, planted in zip(frame.feet_in_base, robot.model.legs, frame.wanted.planted, strict=True):
            # Half a stride is 50 mm.
            assert not planted or math.dist(foot[:2], leg.rest_foot[:2]) < 0.07


def test_a_start_does_not_wait_for_the_needle(robot: Any) -> None:
    for seconds in (1.0, 1.3, 1.7, 2.2):
        robot.walk(Command(Twist(0.03, 0.0, 0.0), gait="wave"), seconds)
        robot.state = State.STAND
        robot.until(lambda wanted: wanted.standing)
        frames = robot.walk(Command(Twist(0.03, 0.0, 0.0), gait="wave"), 0.03)
        assert not all(frames[-1].wanted.planted)


def test_a_posture_beyond_the_legs_is_taken_in_part(robot: Any, hexapod: RobotModel) -> None:
    robot.stand_up()
    robot.command = Command(posture=Pose(0.0, 0.0, 0.1, 0.0, 0.0, 0.0))
    frames = list(robot.run(5.0))
    # From the femur's joint, 83 mm out and 200 mm down would be 216.5 mm; femur and tibia are 199 mm.
    assert 0.03 < frames[-1].height - hexapod.heights.stand < 0.08
    assert all(frame.wanted.reach_error < 1e-4 for frame in frames)


def test_height_follows_the_command_within_the_robots_range(robot: Any, hexapod: RobotModel) -> None:
    low, high = hexapod.heights.lowest, hexapod.heights.highest
    for asked, expected in ((high, high), (9.0, high), (0.0, low), (None, 0.109)):
        frames = robot.walk(Command(Twist(0.05, 0.0, 0.0), height=asked), 3.0)
        assert frames[-1].height == pytest.approx(expected, abs=1e-3)
        rises = [abs(b.height - a.height) for a, b in pairwise(frames)]
        assert max(rises) < 0.061 * DT


def test_a_posture_turns_the_body_over_feet_that_stay(robot: Any) -> None:
    robot.stand_up()
    start = robot.tick().feet_in_base
    robot.state, robot.command = State.WALK, Command(posture=Pose(0.02, 0.0, 0.01, 0.1, 0.0, 0.0))
    for frame in robot.run(3.0):
        feet = frame.feet_in_base
        for a in range(6):
            for b in range(a):
                assert math.dist(feet[a], feet[b]) == pytest.approx(math.dist(start[a], start[b]), abs=1e-9)
    # 20 mm ahead, 10 mm up, rolled 0.1 rad to the right: the left middle foot, 235 mm out and 110 mm below.
    expected = (-0.02, 0.235 * math.cos(0.1) - 0.11 * math.sin(0.1), -0.235 * math.sin(0.1) - 0.11 * math.cos(0.1))
    assert feet[1] == pytest.approx(expected, abs=1e-3)


def test_a_robot_that_stands_does_not_walk(robot: Any) -> None:
    robot.stand_up()
    robot.command = Command(Twist(0.2, 0.1, 0.3), heading=1.0)
    assert all(frame.wanted.twist == STILL and all(frame.wanted.planted) for frame in robot.run(2.0))


@pytest.mark.parametrize("height", ["lowest", "stand", "highest"])
@pytest.mark.parametrize("gait", ["tripod", "ripple", "wave"])
def test_what_check_finds_in_reach_is_in_reach_at_full_speed(
    robot: Any, gaits: dict[str, Gait], gait: str, height: str
) -> None:
    reach = gait_reach(robot.model, gaits[gait])
    assert reach.miss == 0.0
    assert reach.tightest.margin > 0.0
    for degrees in (0, 45, 90, 225):
        twist = twist_of(0.3, math.radians(degrees), 0.0)
        robot.walk(Command(twist, height=getattr(robot.model.heights, height), gait=gait), 3.0)
        for frame in robot.run(1.8):
            assert frame.wanted.reach_error == 0.0
            for angle, joint in zip(frame.wanted.angles, robot.model.joints, strict=True):
                assert joint.lower <= angle <= joint.upper, f"{joint.name} at {degrees} deg"


def test_the_scale_tells_how_much_of_the_command_is_feasible(robot: Any) -> None:
    assert robot.walk(Command(Twist(0.1, 0.0, 0.0)), 1.0)[-1].wanted.scale == 1.0
    assert robot.walk(Command(Twist(0.5, 0.0, 0.0)), 1.0)[-1].wanted.scale == pytest.approx(0.5)


def test_twist_of() -> None:
    assert twist_of(0.1, 0.0, 0.3) == Twist(0.1, 0.0, 0.3)
    assert twist_of(0.1, math.pi / 2.0, 0.0) == pytest.approx((0.0, 0.1, 0.0))
    assert twist_of(-0.1, math.pi, 0.0) == pytest.approx((0.1, 0.0, 0.0))
