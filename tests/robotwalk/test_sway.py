"""The body's shift over the feet that stand."""

import math
from collections.abc import Iterator
from dataclasses import replace
from random import Random
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotwalk.chain import foot_position
from robotwalk.config import library
from robotwalk.config.gait_schema import GaitConfig
from robotwalk.config.schema import RobotConfig
from robotwalk.controller import Controller, Wanted, twist_of
from robotwalk.estimator import Estimate
from robotwalk.gait import Gait
from robotwalk.gait_rules import fitted, read_gait
from robotwalk.kinematics import resting_angles
from robotwalk.model import RobotModel
from robotwalk.supervisor import State
from robotwalk.support import HalfPlane, centre_of_mass, nearest_inside, support_margin
from robotwalk.types import LEVEL, Command, Twist, Vec3

DT = 0.01
MARGIN, FIRMEST = 0.020, 1.8  # what the crawl's file asks for
AHEAD = Command(Twist(0.04, 0.0, 0.0))


def load_model(name: str) -> RobotModel:
    return RobotModel.from_config(library.open_document("robots", name).validate(RobotConfig))


def load_gait(name: str, model: RobotModel, balance: dict[str, float] | None = None) -> Gait:
    config = fitted(read_gait(library.open_document("gaits", name)), model.legs)
    assert config is not None
    if balance is not None:
        config = GaitConfig.model_validate(config.model_dump(by_alias=True) | {"balance": balance})
    return Gait(config, model)


@pytest.fixture(scope="module")
def quadruped() -> RobotModel:
    return load_model("quadruped")


class Frame(NamedTuple):
    """One tick, with perfect joints."""

    wanted: Wanted
    feet: tuple[Vec3, ...]  # in the base frame
    centre: Vec3  # of mass, in the base frame

    @property
    def margin(self) -> float:
        standing = [foot for foot, planted in zip(self.feet, self.wanted.planted, strict=True) if planted]
        return support_margin(standing, self.centre)


class Walker:
    """A controller alone."""

    def __init__(self, model: RobotModel, *gaits: Gait) -> None:
        self.model = model
        self.controller = Controller(model, {gait.name: gait for gait in gaits}, gaits[0].name)
        self.controller.start(resting_angles(model, model.heights.sit))
        while not self.tick(State.STAND, Command()).wanted.standing:
            pass

    def tick(self, state: State, command: Command) -> Frame:
        wanted = self.controller.step(state, command, Estimate(LEVEL, len(self.model.legs)), DT)
        feet = tuple(foot_position(leg, wanted.angles[leg.span]) for leg in self.model.legs)
        return Frame(wanted, feet, centre_of_mass(self.model, wanted.angles))

    def walk(self, command: Command, seconds: float) -> list[Frame]:
        return [self.tick(State.WALK, command) for _ in range(round(seconds / DT))]


def crawler(model: RobotModel) -> Walker:
    return Walker(model, load_gait("crawl", model), load_gait("trot", model))


def planted_motion(frames: list[Frame]) -> Iterator[tuple[Vec3, ...]]:
    """Yield (before, now, after) of a foot that stands through three ticks, in the base frame."""
    for before, now, after in zip(frames, frames[1:], frames[2:], strict=False):
        foot = next(i for i in range(4) if all(f.wanted.planted[i] for f in (before, now, after)))
        yield before.feet[foot], now.feet[foot], after.feet[foot]


@pytest.mark.parametrize("degrees", [0, 180, 90, -45, 135])
def test_the_centre_of_mass_keeps_its_margin_whichever_foot_is_in_the_air(quadruped: RobotModel, degrees: int) -> None:
    frames = crawler(quadruped).walk(Command(twist_of(0.03, math.radians(degrees), 0.0)), 12.0)
    lifted = [frame.margin for frame in frames if not all(frame.wanted.planted)]
    assert len(lifted) > 500
    # The legs' own masses do not come along all the way.
    assert min(lifted) > 0.8 * MARGIN
    assert all(sum(frame.wanted.planted) >= 3 for frame in frames)


def test_so_it_does_while_turning_and_with_a_lean_and_a_displaced_body(quadruped: RobotModel) -> None:
    posture = LEVEL._replace(x=0.01, y=-0.015, pitch=0.05)
    for command in (
        Command(Twist(0.0, 0.0, 0.3)), Command(Twist(0.03, 0.0, -0.1)), AHEAD._replace(posture=posture)):
        frames = crawler(quadruped).walk(command, 10.0)
        assert min(frame.margin for frame in frames if not all(frame.wanted.planted)) > 0.65 * MARGIN


def test_so_it_does_when_the_gait_and_the_way_change_while_a_foot_is_in_the_air(quadruped: RobotModel) -> None:
    gaits = [load_gait("crawl", quadruped), load_gait("wave-few", quadruped)]
    for seed in range(7, 17):
        walker, rng = Walker(quadruped, *gaits), Random(seed)
        first, second = gaits[seed % 2], gaits[1 - seed % 2]
        walker.walk(Command(twist_of(0.2, rng.uniform(-math.pi, math.pi), 0.0), gait=first.name), rng.uniform(2.0, 4.0))
        frames = walker.walk(
            Command(twist_of(0.2, rng.uniform(-math.pi, math.pi), rng.uniform(-0.6, 0.6)), gait=second.name), 1.5)
        assert min(frame.margin for frame in frames) > 0.65 * MARGIN  # -30 mm, or two feet in the air


def test_without_the_shift_it_would_fall(quadruped: RobotModel) -> None:
    bare = load_gait("crawl", quadruped)
    bare.balance = None
    frames = Walker(quadruped, bare).walk(AHEAD, 10.0)
    assert min(frame.margin for frame in frames) < 0.0


def test_the_first_foot_waits_until_the_body_has_shifted(quadruped: RobotModel) -> None:
    frames = crawler(quadruped).walk(AHEAD, 1.0)
    lift_off = next(i for i, frame in enumerate(frames) if not all(frame.wanted.planted))
    # 25 mm and a bit, with a peak of 1.8 m/s^2, take 0.28 s or more.
    assert 0.27 <= lift_off * DT <= 0.5
    assert frames[lift_off].margin > 0.8 * MARGIN


def test_the_shift_is_smooth(quadruped: RobotModel) -> None:
    walker = crawler(quadruped)
    frames = walker.walk(AHEAD, 8.0) + walker.walk(Command(Twist(-0.03, 0.02, 0.0)), 8.0)
    largest = max(
        math.dist((a.x - n.x, a.y - n.y), (n.x - b.x, n.y - b.y)) / DT**2 for b, n, a in planted_motion(frames))
    # Its own acceleration, and 0.3 m/s^2 of the course; small corrections on the way add some.
    assert 1.0 < largest < 1.5 * FIRMEST


@pytest.mark.parametrize("degrees", [180, 135, -120])
def test_a_shift_takes_the_time_that_the_feet_can_bear(quadruped: RobotModel, degrees: int) -> None:
    walker, worst = crawler(quadruped), math.inf
    for turned in (0, 90, 180):
        frames = walker.walk(Command(twist_of(0.05, math.radians(degrees + turned), 0.0)), 5.0)
        for (before, now, after), frame in zip(planted_motion(frames), frames[1:], strict=False):
            # The body's acceleration is the reverse of the standing foot's; the point where it presses on the ground:
            lever = 0.165 / 9.81 / DT**2
            x = frame.centre.x + lever * (after.x - 2.0 * now.x + before.x)
            y = frame.centre.y + lever * (after.y - 2.0 * now.y + before.y)
            standing = [foot for foot, planted in zip(frame.feet, frame.wanted.planted, strict=True) if planted]
            worst = min(worst, support_margin(standing, Vec3(x, y, 0.0)))
    assert worst > 0.0


def test_a_lean_is_kept_while_the_body_shifts(quadruped: RobotModel) -> None:
    command = AHEAD._replace(posture=LEVEL._replace(roll=0.06, pitch=-0.05))
    for frame in crawler(quadruped).walk(command, 6.0)[200:]:
        left, _, right, rear = frame.feet
        if all(frame.wanted.planted):
            # 180 mm apart to the sides, 0.21 m along the body, give or take the strides.
            assert left.z - right.z == pytest.approx(-0.18 * 0.06, abs=4e-3)
            assert abs(right.z - rear.z) == pytest.approx(0.21 * 0.05, abs=5e-3)


def test_in_steady_crawl_the_body_goes_from_side_to_side(quadruped: RobotModel) -> None:
    frames = crawler(quadruped).walk(AHEAD, 14.0)[600:]
    sides = [-0.5 * (frame.feet[0].y + frame.feet[2].y) for frame in frames if frame.wanted.planted[0]
             and frame.wanted.planted[2]]
    # The diagonals cross at 49 deg to the sides; 20 mm from both, and half of what the feet have moved by.
    assert 0.015 < max(sides) < 0.035
    assert -0.035 < min(sides) < -0.015


def test_it_returns_to_its_course_when_it_stands(quadruped: RobotModel) -> None:
    walker = crawler(quadruped)
    walker.walk(AHEAD, 5.0)
    for _ in range(800):
        frame = walker.tick(State.STAND, Command(gait="crawl"))
        if frame.wanted.standing:
            break
    rest = [leg.rest_foot for leg in quadruped.legs]
    assert [math.dist(a[:2], b[:2]) < 2.5e-3 for a, b in zip(frame.feet, rest, strict=True)] == [True] * 4


def test_a_trot_out_of_a_crawl_starts_on_its_course(quadruped: RobotModel) -> None:
    walker = crawler(quadruped)
    walker.walk(AHEAD, 5.3)
    frames = walker.walk(AHEAD._replace(gait="trot"), 4.0)
    first = next(frame for frame in frames if sum(frame.wanted.planted) == 2)
    standing = [foot for foot, planted in zip(first.feet, first.wanted.planted, strict=True) if planted]
    ahead, behind = max(standing), min(standing)
    way = (ahead.x - behind.x, ahead.y - behind.y)
    to = (first.centre.x - behind.x, first.centre.y - behind.y)
    assert abs(way[0] * to[1] - way[1] * to[0]) / math.hypot(*way) < 0.015  # from the line between the feet


def test_a_gait_that_does_not_ask_for_it_is_left_alone(quadruped: RobotModel) -> None:
    frames = Walker(quadruped, load_gait("trot", quadruped)).walk(Command(Twist(0.1, 0.0, 0.0)), 3.0)
    for frame in frames:
        for foot, leg in zip(frame.feet, quadruped.legs, strict=True):
            assert foot.y == pytest.approx(leg.rest_foot.y, abs=1e-6)


def test_any_legs_and_any_gait_may_ask() -> None:
    hexapod = load_model("hexapod")
    ask = {"margin_mm": 90.0, "acceleration_mps2": 1.0}
    command = Command(Twist(0.2, 0.0, 0.0))

    def least_margin(gait: Gait) -> float:
        return min(frame.margin for frame in Walker(hexapod, gait).walk(command, 6.0)[300:])

    plain, asked = load_gait("tripod", hexapod), load_gait("tripod", hexapod, ask)
    # Standing on three feet, the hexapod keeps 70 mm by itself; where its margin suffices, it does not shift.
    assert least_margin(plain) < 0.075
    assert least_margin(asked) > least_margin(plain) + 0.003
    content = load_gait("wave", hexapod, {"margin_mm": 60.0, "acceleration_mps2": 1.0})
    for frame in Walker(hexapod, content).walk(Command(Twist(0.03, 0.0, 0.0)), 5.0):
        assert frame.wanted.planted.count(False) <= 1
        middle = hexapod.legs[1].rest_foot
        if frame.wanted.planted[1]:
            assert frame.feet[1].y == pytest.approx(middle.y, abs=1e-6)


def test_two_feet_carry_the_body_over_the_middle_between_them(quadruped: RobotModel) -> None:
    trot = load_gait("trot", quadruped, {"margin_mm": 10.0, "acceleration_mps2": 2.0})
    displaced = replace(quadruped, legs=tuple(
        replace(leg, rest_foot=leg.rest_foot._replace(x=leg.rest_foot.x + 0.02)) for leg in quadruped.legs))
    for model, shift in ((quadruped, 0.0), (displaced, 0.02)):
        frames = Walker(model, trot).walk(Command(Twist(0.0, 0.0, 0.1)), 6.0)[300:]
        middles = []
        for frame in frames:
            standing = [foot for foot, planted in zip(frame.feet, frame.wanted.planted, strict=True) if planted]
            if len(standing) == 2:
                middles.append(sum(foot.x for foot in standing) / 2 - frame.centre.x)
        assert len(middles) > 100
        assert max(abs(middle) for middle in middles) < 0.006, shift


planes = st.builds(
    lambda angle, bound: HalfPlane(math.cos(angle), math.sin(angle), bound),
    st.floats(-math.pi, math.pi), st.floats(-1.0, 0.3))
coordinate = st.floats(-2.0, 2.0)


def inside(x: float, y: float, sides: list[HalfPlane]) -> bool:
    return all(nx * x + ny * y >= bound - 1e-7 for nx, ny, bound in sides)


@given(coordinate, coordinate, st.lists(planes, max_size=8))
def test_the_nearest_point_inside_is_inside_and_nearest(x: float, y: float, sides: list[HalfPlane]) -> None:
    found = nearest_inside(x, y, sides)
    reached = math.inf if found is None else math.dist((x, y), found)
    if found is not None:
        assert inside(*found, sides)
    # No point of a grid around is inside and nearer.
    for row in range(-20, 21):
        for column in range(-20, 21):
            point = (0.15 * column, 0.15 * row)
            if math.dist(point, (x, y)) < reached - 1e-6:
                assert not all(nx * point[0] + ny * point[1] >= bound + 1e-6 for nx, ny, bound in sides)


def test_nearest_by_hand() -> None:
    square = [HalfPlane(1.0, 0.0, 1.0), HalfPlane(-1.0, 0.0, -3.0), HalfPlane(0.0, 1.0, 1.0),
              HalfPlane(0.0, -1.0, -2.0)]
    assert nearest_inside(0.0, 0.0, square) == pytest.approx((1.0, 1.0))
    assert nearest_inside(2.0, 5.0, square) == pytest.approx((2.0, 2.0))
    assert nearest_inside(2.0, 1.5, square) == (2.0, 1.5)
    assert nearest_inside(9.0, 9.0, square) == pytest.approx((3.0, 2.0))
    assert nearest_inside(0.0, 0.0, [*square, HalfPlane(1.0, 1.0, 6.0)]) is None
    assert nearest_inside(0.0, 0.0, [HalfPlane(1.0, 0.0, 1.0), HalfPlane(-1.0, 0.0, 0.0)]) is None
