"""Legs against legs and the body: capsules against sampling, and the gate around the boundary."""

import itertools
import math
from collections.abc import Iterable, Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotwalk import assembly
from robotwalk.assembly.session import gate_of
from robotwalk.capsules import between_segments, to_box
from robotwalk.config import library
from robotwalk.kinematics import resting_angles
from robotwalk.limits import Gate, JointLimit
from robotwalk.model import RobotModel
from robotwalk.self_collision import MARGIN, SelfCollision
from robotwalk.supervisor import State
from robotwalk.types import Command, Twist, Vec3

from .conftest import Frame, PerfectRobot

DT = 0.01
FAST, BRAKE = 6.0, 200.0  # rad/s, rad/s^2


def looking(model: RobotModel) -> SelfCollision:
    return SelfCollision(model, [FAST] * len(model.joints), [BRAKE] * len(model.joints))


MODELS = {name: assembly.load(name).model for name in ("hexapod", "quadruped")}
LOOKS = {name: looking(model) for name, model in MODELS.items()}

coordinate = st.floats(-1.0, 1.0)
points = st.builds(Vec3, coordinate, coordinate, coordinate)


def along(a: Vec3, b: Vec3, count: int) -> list[Vec3]:
    return [Vec3(*(p + index / count * (q - p) for p, q in zip(a, b, strict=True))) for index in range(count + 1)]


@settings(max_examples=40)
@given(points, points, points, points)
def test_segments_are_as_far_apart_as_their_points(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> None:
    count = 40
    sampled = min(math.dist(p, q) for p, q in itertools.product(along(a, b, count), along(c, d, count)))
    spacing = (math.dist(a, b) + math.dist(c, d)) / count
    assert sampled - spacing <= between_segments(a, b, c, d) <= sampled + 1e-6  # shorter than that is a point


@pytest.mark.parametrize(("c", "d", "distance"), [
    (Vec3(0.5, -1.0, 2.0), Vec3(0.5, 1.0, 2.0), 2.0),  # crossing
    (Vec3(0.2, 3.0, 0.0), Vec3(0.9, 3.0, 0.0), 3.0),  # parallel
    (Vec3(2.0, 0.0, 0.0), Vec3(5.0, 0.0, 0.0), 1.0),  # in a line
    (Vec3(0.3, 0.4, 0.0), Vec3(0.3, 0.4, 0.0), 0.4),  # a point
    (Vec3(-3.0, 4.0, 0.0), Vec3(-3.0, 4.0, 0.0), 5.0),  # a point behind
    (Vec3(4.0, 0.0, 4.0), Vec3(4.0, 0.0, 4.0), 5.0),  # a point ahead
    (Vec3(-3.0, 4.0, 0.0), Vec3(-3.0, 9.0, 0.0), 5.0),  # end to end
])
def test_segments_by_hand(c: Vec3, d: Vec3, distance: float) -> None:
    a, b = Vec3(0.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0)
    for p, q in ((c, d), (d, c)):
        assert between_segments(a, b, p, q) == pytest.approx(distance)
        assert between_segments(p, q, b, a) == pytest.approx(distance)


@settings(max_examples=40)
@given(points, points)
def test_a_segment_is_as_far_from_a_box_as_its_points(a: Vec3, b: Vec3) -> None:
    half = Vec3(0.3, 0.2, 0.1)
    sampled = min(
        math.hypot(*(max(abs(value) - edge, 0.0) for value, edge in zip(point, half, strict=True)))
        for point in along(a, b, 400))
    assert to_box(a, b, half) == pytest.approx(sampled, abs=0.004 * math.dist(a, b) + 1e-9)


def pose(model: RobotModel, shares: Sequence[float]) -> list[float]:
    return [j.lower + share * (j.upper - j.lower) for j, share in zip(model.joints, shares, strict=False)]


shares = st.lists(st.floats(0.0, 1.0), min_size=18, max_size=18)


@settings(max_examples=40)
@given(st.sampled_from(sorted(MODELS)), shares)
def test_the_quick_bound_is_one_and_who_is_not_looked_at_cannot_meet(name: str, drawn: list[float]) -> None:
    model = MODELS[name]
    collision = LOOKS[name]
    angles = pose(model, drawn)
    for pair in collision.pairs:
        assert pair.gap(angles) <= pair.apart(angles) + 1e-3
    # Tibiae of legs that are no pair, and so are never looked at.
    looked_at = {(pair.first, pair.second) for pair in collision.pairs}
    limbs = collision.limbs
    for one, other in itertools.combinations(limbs, 2):
        if (one, other) not in looked_at:
            (a, b), (c, d) = one.points(angles)[-2:], other.points(angles)[-2:]
            assert between_segments(a, b, c, d) > one.radii[-1] + other.radii[-1]


def test_a_foot_is_as_thick_as_its_ball_which_may_be_thicker_than_its_leg() -> None:
    model = MODELS["quadruped"]
    (pair,) = [pair for pair in LOOKS["quadruped"].pairs
               if pair.second is not None and (pair.first.leg.name, pair.second.leg.name) == ("lf", "rf")]
    assert pair.second is not None
    angles = [j.rest for j in model.joints]
    for name, turn in (("lf_hip", -0.2), ("rf_hip", 0.2)):  # foot towards foot
        angles[model.joint_names.index(name)] += turn
    feet = math.dist(pair.first.points(angles)[-1], pair.second.points(angles)[-1])
    assert pair.apart(angles) == pytest.approx(feet - 2.0 * model.foot_radius)


def gate(model: RobotModel) -> Gate:
    made = Gate(
        model.joint_names, [JointLimit(j.lower, j.upper, FAST, BRAKE) for j in model.joints],
        looking(model))
    made.reset([j.rest for j in model.joints])
    return made


def nearest(model: RobotModel, angles: Sequence[float]) -> float:
    """Return how near anything is to anything, m, by a look at all of it."""
    return min(pair.apart(angles) for pair in LOOKS[model.name].pairs)


@pytest.mark.parametrize("speed", [0.3, 1.0, 3.0, 5.9])
def test_neighbours_that_swing_at_each_other_stop_short_and_part_again(speed: float) -> None:
    """The front leg back and the middle one ahead, at any speed: a hair apart, and not before."""
    model = MODELS["hexapod"]
    held = gate(model)
    way = [0.0] * 18
    way[0], way[3] = 1.0, -1.0
    rest = [j.rest for j in model.joints]
    goals, least = tuple(rest), math.inf
    for tick in range(1, int(1.0 / speed / DT) + 1):
        goals = held.step([angle + w * speed * tick * DT for angle, w in zip(rest, way, strict=True)], DT)
        if held.cuts or tick % 10 == 0:
            least = min(least, nearest(model, goals))
    assert held.cuts["lf_coxa", "collision"] > 0
    assert held.cuts["lm_tibia", "collision"] == held.cuts["lf_coxa", "collision"]
    assert held.cuts["rf_coxa", "collision"] == 0
    assert 0.0 < least < MARGIN + 0.002 + 0.015 * speed
    for _ in range(200):
        goals = held.step(rest, DT)
    assert goals == pytest.approx(rest)


def test_legs_that_take_their_time_to_stop_brake_no_harder_than_they_may() -> None:
    model, weak = MODELS["hexapod"], 30.0  # rad/s^2: a tenth of a second from 3 rad/s
    count = len(model.joints)
    held = Gate(
        model.joint_names, [JointLimit(j.lower, j.upper, FAST, weak) for j in model.joints],
        SelfCollision(model, [FAST] * count, [weak] * count))
    rest = [j.rest for j in model.joints]
    held.reset(rest)
    goals, rates = tuple(rest), [0.0] * count
    for tick in range(1, 60):
        before, rates_before, way = goals, rates, 3.0 * tick * DT
        goals = held.step([rest[0] + way, *rest[1:3], rest[3] - way, *rest[4:]], DT)
        rates = [(goal - last) / DT for goal, last in zip(goals, before, strict=True)]
        assert max(abs(a - b) for a, b in zip(rates, rates_before, strict=True)) <= weak * DT + 1e-9
        assert nearest(model, goals) > 0.0
    assert held.cuts["lf_coxa", "collision"] > 8
    assert max(map(abs, rates)) < 1e-9


def test_a_foot_is_not_put_into_the_body() -> None:
    model = MODELS["hexapod"]
    held = gate(model)
    wanted = [j.rest for j in model.joints]
    wanted[4], wanted[5] = 0.91, 2.90  # the middle leg folds up below the body, and into it
    assert nearest(model, wanted) < -0.005
    for _ in range(60):
        assert nearest(model, held.step(wanted, DT)) > 0.0
    assert held.cuts["lm_femur", "collision"] > 0
    assert held.cuts["lf_femur", "collision"] == 0


@settings(max_examples=6)
@given(st.sampled_from(sorted(MODELS)), st.lists(shares, min_size=3, max_size=3))
def test_no_sequence_of_goals_brings_anything_together(name: str, targets: list[list[float]]) -> None:
    model = MODELS[name]
    held = gate(model)
    for drawn in targets:
        for tick in range(40):
            goals = held.step(pose(model, drawn), DT)
            assert tick % 4 or nearest(model, goals) > 0.0


def test_who_is_too_near_at_first_may_part_and_not_come_nearer() -> None:
    model = MODELS["hexapod"]
    rest = [j.rest for j in model.joints]
    close = next(
        angles for angles in (
            [*rest[:0], rest[0] + 0.01 * k, rest[1], rest[2], rest[3] - 0.01 * k, *rest[4:]] for k in range(100))
        if nearest(model, angles) < 0.5 * MARGIN)
    held = gate(model)
    held.step(rest, DT)  # where all is well, and need not be looked at again for a while
    held.reset(close)
    before = nearest(model, close)
    worse = list(close)
    worse[0], worse[3] = close[0] + 0.2, close[3] - 0.2
    for _ in range(20):
        assert nearest(model, held.step(worse, DT)) >= before - 1e-3
    for _ in range(200):
        goals = held.step(rest, DT)
    assert goals == pytest.approx(rest)


@pytest.mark.parametrize("name", library.names("robots"))
def test_no_walk_is_cut_in_any_gait_at_full_speed_in_any_direction(name: str) -> None:
    blueprint = assembly.load(name)
    model, held = blueprint.model, gate_of(blueprint)
    robot = PerfectRobot(model, blueprint.gaits, blueprint.default_gait)
    held.reset(resting_angles(model, 0.5 * model.body_box.z))

    def pass_on(frames: Iterable[Frame]) -> None:
        for frame in frames:
            held.step(frame.wanted.angles, robot.dt)

    pass_on(robot.stand_up())
    robot.state = State.WALK
    limits = model.motion
    for gait in [gait for gait in blueprint.gaits if gait not in blueprint.refused]:
        for index in range(6):
            angle, turn = math.tau * index / 6, (0.0, limits.turn, -limits.turn)[index % 3]
            way = Twist(1.5 * limits.speed * math.cos(angle), 1.5 * limits.speed * math.sin(angle), turn)
            robot.command = Command(way, gait=gait)
            pass_on(robot.run(0.5))
    assert {joint for joint, what in held.cuts if what == "collision"} == set()
