"""Where the feet are set down, and that they stay there."""

import math
from itertools import pairwise
from typing import Any

import pytest

from robotwalk.body import advanced
from robotwalk.contact import Felt
from robotwalk.gait import Gait, GaitClock
from robotwalk.model import RobotModel
from robotwalk.senses import BodyInOdom, Sense
from robotwalk.stepping import Stepping
from robotwalk.types import LEVEL, STILL, Command, Twist, Vec3

DT = 0.01
STEADY = 3.0  # s after which a walk from standing is steady


def stances(frames: list[Any], foot: int) -> list[list[Any]]:
    """Return the frames of every whole stance of a foot."""
    spans: list[list[Any]] = [[]]
    for frame in frames:
        if frame.wanted.planted[foot]:
            spans[-1].append(frame)
        elif spans[-1]:
            spans.append([])
    return spans[1:-1]


@pytest.mark.parametrize(("twist", "gait"), [
    (Twist(0.1, 0.0, 0.0), "tripod"),
    (Twist(0.0, -0.1, 0.0), "tripod"),
    (Twist(-0.06, 0.03, 0.3), "tripod"),
    (Twist(0.0, 0.0, -0.4), "ripple"),
    (Twist(0.05, 0.05, 0.0), "ripple"),
    (Twist(0.04, 0.0, 0.0), "wave"),
])
def test_at_the_middle_of_its_stance_a_foot_is_at_rest_below_the_body(robot: Any, twist: Twist, gait: str) -> None:
    frames = robot.walk(Command(twist, gait=gait), 12.0)[round(STEADY / DT):]
    for foot, leg in enumerate(robot.model.legs):
        found = stances(frames, foot)
        assert len(found) >= 2
        for stance in found[1:]:
            early, late = (stance[i].feet_in_base[foot] for i in ((len(stance) - 1) // 2, len(stance) // 2))
            middle = (0.5 * (early.x + late.x), 0.5 * (early.y + late.y))
            assert math.dist(middle, leg.rest_foot[:2]) < 1e-3


def test_strides_in_steady_tripod(robot: Any) -> None:
    frames = robot.walk(Command(Twist(0.1, 0.0, 0.0)), 12.0)[round(STEADY / DT):]
    for foot in range(6):
        found = stances(frames, foot)
        # At 0.1 m/s the period is the slowest, 1 s: half of it, 50 mm, passes below the body in a stance.
        for stance in found:
            seen = [frame.feet_in_base[foot].x for frame in stance]
            assert max(seen) - min(seen) == pytest.approx(0.05, abs=2e-3)
            assert len(stance) == pytest.approx(50, abs=1)
        places = [stance[0].feet[foot] for stance in found]
        for before, after in pairwise(places):
            assert math.dist(before, after) == pytest.approx(0.1, abs=1e-3)
            assert after.y == pytest.approx(before.y, abs=1e-6)


def test_in_the_air_a_foot_rises_by_its_lift_and_comes_down(robot: Any) -> None:
    frames = robot.walk(Command(Twist(0.1, 0.0, 0.0)), 5.0)
    heights = [frame.feet[0].z for frame in frames[300:]]
    assert max(heights) == pytest.approx(0.009 + 0.03, abs=1e-4)
    assert min(heights) == pytest.approx(0.009, abs=1e-9)


@pytest.mark.parametrize(("gait", "at_least"), [("tripod", 3), ("ripple", 4), ("wave", 5)])
@pytest.mark.parametrize("twist", [Twist(0.04, 0.0, 0.0), Twist(0.5, 0.0, 0.0), Twist(0.0, 0.5, 1.0)])
def test_a_gait_keeps_its_feet_on_the_ground(robot: Any, gait: str, at_least: int, twist: Twist) -> None:
    frames = robot.walk(Command(twist, gait=gait), 10.0)
    if gait != "tripod":
        del frames[:200]  # it starts in its default gait
    assert min(sum(frame.wanted.planted) for frame in frames) == at_least


@pytest.mark.parametrize(
    "twist", [Twist(0.5, 0.0, 0.0), Twist(0.0, -0.5, 0.0), Twist(0.3, 0.3, 0.6), Twist(0.0, 0.0, 9.0)])
@pytest.mark.parametrize("gait", ["tripod", "ripple", "wave"])
def test_the_top_speed_is_reached_and_kept(robot: Any, gait: str, twist: Twist) -> None:
    frames = robot.walk(Command(twist, gait=gait), 14.0)[600:]
    twists = {frame.wanted.twist for frame in frames}
    scale = frames[-1].wanted.scale
    assert twists == {Twist(*(scale * component for component in twist))}
    assert 0.0 < scale < 1.0


@pytest.mark.parametrize("seconds", [3.0, 3.1, 3.2, 3.3, 3.4])
def test_no_swing_is_shorter_than_the_servos_can(robot: Any, seconds: float) -> None:
    """Not even while the cadence rises from a wave to a run."""
    frames = robot.walk(Command(Twist(0.02, 0.0, 0.0), gait="wave"), seconds)
    frames += robot.walk(Command(Twist(0.25, 0.0, 0.0)), 4.0)
    for foot in range(6):
        lengths, length = [], 0
        for frame in frames:
            if not frame.wanted.planted[foot]:
                length += 1
            elif length:
                lengths.append(length)
                length = 0
        assert len(lengths) > 4
        assert min(lengths) * DT >= 0.3 - 1.5 * DT


def test_feet_that_wait_too_long_for_their_turn_hold_the_body_back(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    stepping, clock = Stepping(hexapod, LEVEL), GaitClock(gaits["wave"])
    assert stepping.stance.bearable(clock, LEVEL, STILL) == 1.0
    assert stepping.stance.bearable(clock, LEVEL, Twist(0.01, 0.0, 0.0)) == 1.0
    # The last foot's turn is 2.3 s away: 0.2 m/s would stretch it by 470 mm, and about 60 mm are allowed.
    assert stepping.stance.bearable(clock, LEVEL, Twist(0.2, 0.0, 0.0)) == pytest.approx(0.118, abs=0.01)
    # Feet that are stretched already allow nothing but the way back.
    ahead = advanced(LEVEL, Twist(0.07, 0.0, 0.0), 1.0)
    assert stepping.stance.bearable(clock, ahead, Twist(0.01, 0.0, 0.0)) == 0.0
    assert not stepping.stance.settled(ahead)
    assert stepping.stance.settled(advanced(LEVEL, Twist(0.0014, 0.0, 0.0), 1.0))


def test_standing_feet_do_not_step_on_the_spot(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    stepping, clock = Stepping(hexapod, LEVEL), GaitClock(gaits["tripod"])
    for _ in range(300):
        clock.advance(STILL, DT, 1.0)
        assert all(stepping.step(clock, LEVEL, STILL, DT).planted)


def test_a_foot_off_its_place_steps_to_it_though_the_body_stands(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    stepping, clock = Stepping(hexapod, LEVEL), GaitClock(gaits["tripod"])
    moved = advanced(LEVEL, Twist(0.02, 0.01, 0.1), 1.0)
    for _ in range(150):
        clock.advance(STILL, DT, 1.0)
        stepping.step(clock, moved, STILL, DT)
    assert stepping.stance.settled(moved)
    assert not stepping.stance.settled(LEVEL)


def test_the_needle_waits_for_feet_that_are_late_though_nobody_feels(
    hexapod: RobotModel, gaits: dict[str, Gait]
) -> None:
    # Else the tripod after one that lands late may sit its swing out, and is over-stretched.
    stepping, clock = Stepping(hexapod, LEVEL), GaitClock(gaits["tripod"])
    twist, course = Twist(0.25, 0.0, 0.0), LEVEL
    clock.period, clock.phase = clock.gait.fastest_period, 0.25  # half its turn has gone by before it lifts off
    footfalls = stepping.step(clock, course, twist, DT)
    assert not footfalls.planted[0]
    while not footfalls.planted[0]:
        if not footfalls.late:
            clock.advance(twist, DT, 1.0)
        course = advanced(course, twist, DT)
        footfalls = stepping.step(clock, course, twist, DT)
    assert clock.phase <= 0.5 + DT / clock.period


def test_a_foot_that_feels_no_more_ends_its_search(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    stepping, clock = Stepping(hexapod, LEVEL), GaitClock(gaits["wave"])
    rest = stepping.footfalls().centres
    felt = Felt(Vec3(0.0, 0.0, 0.0), 0.0, touching=False, sure=False)
    body = BodyInOdom(LEVEL, rest, (True,) * 6, rest, [felt] * 6)
    nothing = [Sense(felt, place, body) for place in rest]
    twist = Twist(0.02, 0.0, 0.0)
    while min(foot.z for foot in stepping.footfalls().centres) > rest[0].z - 0.02:
        clock.advance(twist, DT, 1.0)
        stepping.step(clock, LEVEL, twist, DT, senses=nothing)
    assert stepping.searches
    for _ in range(30):
        stepping.step(clock, LEVEL, twist, DT, hold=True)
    assert not stepping.searches
    assert min(foot.z for foot in stepping.footfalls().centres) == pytest.approx(rest[0].z, abs=1e-4)


def test_the_first_feet_stand_where_the_course_begins(hexapod: RobotModel) -> None:
    footfalls = Stepping(hexapod, LEVEL._replace(x=1.0, yaw=math.pi / 2.0)).footfalls()
    assert footfalls.planted == (True,) * 6
    assert footfalls.centres[1] == pytest.approx((1.0 - 0.235, 0.0, 0.009), abs=1e-9)  # the left middle foot
