"""How the body answers to its feet: by data, bounded, without a jump, and gone when the robot stands."""

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest

from robotwalk import checks
from robotwalk.body import placed
from robotwalk.config import library
from robotwalk.config.document import Document
from robotwalk.config.schema import RobotConfig
from robotwalk.errors import ConfigError
from robotwalk.gait import Gait, GaitClock
from robotwalk.model import RobotModel
from robotwalk.reaction import Reaction, forward_angle, mean_angle
from robotwalk.stepping import Stepping
from robotwalk.types import Command, Pose, Twist, Vec3

from .conftest import PerfectRobot

AHEAD = Command(Twist(0.08, 0.0, 0.0))


def answers(
    model: RobotModel, gaits: Mapping[str, Gait], gait: str, **gains: Any
) -> tuple[list[float], PerfectRobot]:
    """Walk until all has settled; return the heights of two turns, from lift-off to lift-off, and the robot."""
    robot = PerfectRobot(replace(model, reactions=model.reactions._replace(**gains)), gaits)
    robot.walk(AHEAD._replace(gait=gait), 14.0)
    frames = list(robot.run(6.0))
    stands = [frame.wanted.planted[0] for frame in frames]
    lift_offs = [tick for tick in range(1, len(stands)) if stands[tick - 1] and not stands[tick]]
    return [frame.height for frame in frames[lift_offs[0]:lift_offs[2]]], robot


def swing(values: list[float]) -> float:
    return max(values) - min(values)


def test_without_gains_the_body_floats(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    assert hexapod.reactions.off
    assert swing(answers(hexapod, gaits, "ripple")[0]) < 1e-9


def test_pseudo_physics_moves_the_body_and_cancels_in_antiphase(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    front_left = tuple(0.5 if leg.name == "lf" else 0.1 for leg in hexapod.legs)
    heights, _ = answers(hexapod, gaits, "ripple", height=0.05, weights=front_left, largest_bob=0.02)
    # Half as far with half the gain: it is the feet's motion, scaled.
    half, _ = answers(hexapod, gaits, "ripple", height=0.025, weights=front_left, largest_bob=0.02)
    assert swing(heights) > 2e-3
    assert swing(half) == pytest.approx(0.5 * swing(heights), rel=0.05)
    assert abs(sum(heights) / len(heights) - hexapod.heights.stand) < 1e-3 * swing(heights)
    assert swing(answers(hexapod, gaits, "ripple", height=1.0)[0]) < 1e-4
    # Only feet of unequal weight move the body in tripod.
    assert swing(answers(hexapod, gaits, "tripod", height=0.1)[0]) < 5e-4
    weights = tuple(0.3 if leg.name in ("lf", "lr", "rm") else 0.1 / 3 for leg in hexapod.legs)
    assert swing(answers(hexapod, gaits, "tripod", height=0.02, weights=weights)[0]) > 4e-3


def test_no_answer_is_larger_than_allowed_and_none_jumps(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    heights, _ = answers(hexapod, gaits, "ripple", height=50.0, bob=2.0, turn=20.0)
    assert max(abs(height - hexapod.heights.stand) for height in heights) < 0.008 + 1e-6
    _, robot = answers(hexapod, gaits, "ripple", height=0.2, bob=0.5, turn=1.0)
    smooth = [frame.height for frame in robot.run(3.0)]
    smooth += [frame.height for frame in robot.walk(AHEAD._replace(gait="tripod"), 3.0)]
    assert max(abs(after - before) for before, after in pairwise(smooth)) < 2.5e-3  # m a tick; 2.1 mm from end to end


def test_it_stands_as_before_when_it_has_stopped(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    _, robot = answers(hexapod, gaits, "ripple", height=1.0, bob=0.5, turn=1.0)
    robot.command = Command()
    frame = robot.until(lambda wanted: wanted.standing)[-1]
    assert frame.height == pytest.approx(hexapod.heights.stand, abs=1e-3)


def test_the_body_turns_towards_its_feet(hexapod: RobotModel) -> None:
    rest = [(leg.rest_foot.x, leg.rest_foot.y) for leg in hexapod.legs]
    turned = [(x * math.cos(0.1) - y * math.sin(0.1), x * math.sin(0.1) + y * math.cos(0.1)) for x, y in rest]
    assert mean_angle(hexapod.legs, rest) == forward_angle(hexapod.legs, rest) == pytest.approx(0.0)
    assert mean_angle(hexapod.legs, turned) == pytest.approx(0.1)
    right_ahead = [(x + (0.02 if y < 0.0 else -0.02), y) for x, y in rest]
    assert forward_angle(hexapod.legs, right_ahead) > 0.05
    assert mean_angle(hexapod.legs, right_ahead) > 0.02


@pytest.mark.parametrize(("gain", "yaw"), [(0.5, 0.05), (2.0, 0.08), (0.0, 0.0)])
def test_the_turn_has_a_gain_and_a_limit(
    hexapod: RobotModel, gaits: dict[str, Gait], gain: float, yaw: float
) -> None:
    model = replace(hexapod, reactions=hexapod.reactions._replace(turn=gain, largest_turn=0.08))
    course = Pose(1.0, 2.0, 0.1, 0.0, 0.0, 0.3)
    feet = [placed(course._replace(yaw=0.4), leg.rest_foot) for leg in hexapod.legs]
    resting = Stepping(model, course).footfalls()
    footfalls = resting._replace(centres=tuple(Vec3(x, y, 0.009) for x, y in feet))
    reaction, clock = Reaction(model), GaitClock(gaits["tripod"])
    for _ in range(300):
        pose = reaction.step(course, clock, footfalls, course, True, 0.01)
    assert pose.yaw - course.yaw == pytest.approx(yaw, abs=1e-3)
    assert pose[:5] == pytest.approx(course[:5])


def test_weights_are_of_legs_that_there_are() -> None:
    text = library.open_document("robots", "hexapod").text
    text = text.replace("  swing_path:", "  reaction: {height: 0.1, weights: {lx: 2}}\n  swing_path:", 1)
    document = Document.parse(text, "own.yaml")
    with pytest.raises(ConfigError, match=r"reaction\.weights\.lx: no such leg; there are lf, lm"):
        checks.require_consistent(document, document.validate(RobotConfig))
