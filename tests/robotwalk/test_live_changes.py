"""Gait, period, speed, direction, turn and height change while the robot walks; no foot is teleported."""

import math
import random

import pytest

from robotwalk import assembly
from robotwalk.types import Command, Twist

from .conftest import PerfectRobot

# A foot is carried over its stride, the body's way and its lift in a swing, fastest half way.
FASTEST_FOOT = 2.0  # m/s


@pytest.mark.parametrize("name", ["hexapod", "octopod", "pentapod", "quadruped"])
def test_whatever_changes_no_foot_is_teleported(name: str) -> None:
    blueprint = assembly.load(name)
    able = [gait for gait in blueprint.gaits if gait not in blueprint.refused]
    robot, rng = PerfectRobot(blueprint.model, blueprint.gaits, blueprint.default_gait), random.Random(name)
    robot.walk(Command(), 0.1)
    heights = blueprint.model.heights
    walked, before = set(), robot.tick()
    for _ in range(16):
        direction, speed = rng.uniform(-math.pi, math.pi), rng.choice([0.0, 0.03, 0.08, 0.15])
        command = Command(
            Twist(speed * math.cos(direction), speed * math.sin(direction), rng.choice([0.0, 0.0, 0.3, -0.3])),
            height=rng.uniform(heights.lowest, heights.highest), gait=rng.choice(able),
            period=rng.choice([None, 0.6, 1.5, 4.0]))
        robot.command = command
        for frame in robot.run(rng.uniform(0.3, 3.0)):
            fastest = max(math.dist(a, b) / robot.dt for a, b in zip(before.feet, frame.feet, strict=True))
            assert fastest < FASTEST_FOOT, (command, fastest)
            assert frame.wanted.reach_error < 1e-3, command
            walked.add(robot.controller._clock.gait.name)
            before = frame
    assert len(walked) > len(able) // 2


def test_a_period_may_be_asked_for_within_what_strides_and_servos_allow() -> None:
    gait = assembly.load("hexapod").gaits["tripod"]
    slow, fast = Twist(0.05, 0.0, 0.0), Twist(0.2, 0.0, 0.0)
    assert gait.period(slow) == 1.0
    assert gait.period(slow, 0.8) == 0.8
    assert gait.period(slow, 3.0) == 3.0
    assert gait.period(slow, 9.0) == pytest.approx(4.0)  # a stride of 0.1 m in half a turn
    assert gait.period(fast, 3.0) == pytest.approx(1.0)
    assert gait.period(slow, 0.1) == gait.fastest_period
