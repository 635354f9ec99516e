"""The body's course, height and posture."""

import math
from itertools import pairwise

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from robotwalk.body import Body, Ramp, advanced, composed, placed, seen_from
from robotwalk.types import LEVEL, STILL, Pose, Twist, Vec3

QUARTER = math.pi / 2.0
DT = 0.01

number = st.floats(-2.0, 2.0)
poses = st.builds(Pose, *[number] * 6)
twists = st.builds(Twist, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-2.0, 2.0))


@pytest.mark.parametrize(("twist", "seconds", "x", "y", "yaw"), [
    (Twist(0.1, 0.0, 0.0), 5.0, 0.5, 0.0, 0.0),
    (Twist(0.0, 0.1, 0.0), 5.0, 0.0, 0.5, 0.0),
    (Twist(0.1, 0.0, 1.0), QUARTER, 0.1, 0.1, QUARTER),
    (Twist(0.1, 0.0, 1.0), math.pi, 0.0, 0.2, math.pi),
    (Twist(0.1, 0.0, -0.5), 4.0 * math.pi, 0.0, 0.0, -2.0 * math.pi),
    (Twist(0.0, 0.1, 1.0), QUARTER, -0.1, 0.1, QUARTER),
    (Twist(0.1, 0.0, 1e-8), 1.0, 0.1, 0.0, 0.0),
])
def test_a_body_is_carried_along_an_arc(twist: Twist, seconds: float, x: float, y: float, yaw: float) -> None:
    pose = advanced(LEVEL, twist, seconds)
    assert pose == pytest.approx((x, y, 0.0, 0.0, 0.0, yaw), abs=1e-8)


def test_an_arc_begins_where_the_body_faces() -> None:
    pose = advanced(Pose(1.0, 2.0, 0.1, 0.0, 0.0, QUARTER), Twist(0.1, 0.0, 1.0), QUARTER)
    assert pose == pytest.approx((0.9, 2.1, 0.1, 0.0, 0.0, math.pi))


@given(poses, twists, st.floats(0.0, 3.0))
@example(LEVEL, Twist(0.0, 0.5, 1.2e-7), 1.0)
def test_many_short_steps_are_one_long_step(pose: Pose, twist: Twist, seconds: float) -> None:
    many = pose
    for _ in range(20):
        many = advanced(many, twist, seconds / 20)
    assert many == pytest.approx(advanced(pose, twist, seconds), abs=1e-9)


def test_placed() -> None:
    assert placed(Pose(1.0, 2.0, 0.0, 0.0, 0.0, QUARTER), Vec3(0.3, 0.1, 5.0)) == pytest.approx((0.9, 2.3))


def test_a_posture_is_a_displacement_in_the_bodys_axes() -> None:
    pose = composed(Pose(1.0, 2.0, 0.1, 0.0, 0.0, QUARTER), Pose(0.01, 0.02, 0.03, 0.1, 0.2, 0.3))
    assert pose == pytest.approx((0.98, 2.01, 0.13, 0.1, 0.2, QUARTER + 0.3))


@pytest.mark.parametrize(("attitude", "point", "seen"), [
    ((0.0, 0.0, QUARTER), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)),  # faces left: ahead is now on the right
    ((0.0, QUARTER, 0.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)),  # nose down: the ground is ahead
    ((QUARTER, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),  # lies on its right side: the sky is on the left
    ((0.0, QUARTER, QUARTER), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    ((0.0, QUARTER, QUARTER), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    ((QUARTER, QUARTER, QUARTER), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    ((QUARTER, QUARTER, QUARTER), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0)),
])
def test_points_seen_from_a_turned_body(
    attitude: tuple[float, ...], point: tuple[float, ...], seen: tuple[float, ...]
) -> None:
    roll, pitch, yaw = attitude
    there = Vec3(*(p + q for p, q in zip(point, (3.0, 4.0, 5.0), strict=True)))
    assert seen_from(Pose(3.0, 4.0, 5.0, roll, pitch, yaw), [there]) == [pytest.approx(seen, abs=1e-12)]


@given(poses, st.lists(st.builds(Vec3, *[number] * 3), min_size=2, max_size=4))
def test_looking_from_elsewhere_changes_no_distance(pose: Pose, points: list[Vec3]) -> None:
    seen = seen_from(pose, points)
    for (a, b), (c, d) in zip(pairwise(points), pairwise(seen), strict=True):
        assert math.dist(a, b) == pytest.approx(math.dist(c, d), abs=1e-12)
    assert seen_from(pose, [Vec3(pose.x, pose.y, pose.z)]) == [pytest.approx((0.0, 0.0, 0.0))]


@given(st.lists(st.tuples(number, st.integers(1, 300)), min_size=1, max_size=5), st.sampled_from([0.01, 0.005, 0.02]))
def test_a_ramp_keeps_below_its_speed_and_settles(targets: list[tuple[float, int]], dt: float) -> None:
    ramp = Ramp(0.0, speed=0.5)
    for target, ticks in targets:
        low, high = min(ramp.value, target), max(ramp.value, target)
        run_on = abs(ramp.rate) * 0.15
        for _ in range(ticks):
            before = ramp.value
            value = ramp.step(target, dt)
            assert abs(value - before) <= 0.5 * dt + 1e-12
            assert low - run_on - 2e-3 <= value <= high + run_on + 2e-3
    last = targets[-1][0]
    for _ in range(round(12.0 / dt)):
        ramp.step(last, dt)
    assert ramp.value == pytest.approx(last, abs=1e-6)
    assert ramp.settled(last, 1e-5)


def test_a_ramp_starts_and_stops_gently() -> None:
    ramp = Ramp(0.0, speed=0.06)
    values = [ramp.step(0.06, DT) for _ in range(400)]
    speeds = [(b - a) / DT for a, b in pairwise([0.0, *values])]
    changes = [b - a for a, b in pairwise([0.0, *speeds])]
    assert max(changes) < 0.3 * 0.06
    assert min(changes) > -0.1 * 0.06
    assert max(values) < 0.0601
    assert values[-1] == pytest.approx(0.06, abs=1e-6)


def test_a_ramp_on_its_way_is_not_settled() -> None:
    ramp = Ramp(0.0, speed=0.5)
    for _ in range(30):
        ramp.step(1.0, DT)
    assert not ramp.settled(1.0, 1e-3)
    assert not ramp.settled(ramp.value, 1e-3)  # it passes through


def test_the_body_rises_no_faster_than_its_feet_keep_their_load() -> None:
    body = Body(0.03)
    heights = [body.step(STILL, 0.109, LEVEL, DT).z for _ in range(300)]
    assert max(b - a for a, b in pairwise(heights)) == pytest.approx(0.06 * DT, rel=0.01)
    assert not Body(0.03).settled(0.109, LEVEL)
    assert body.settled(0.109, LEVEL)
    assert body.pose == pytest.approx((0.0, 0.0, 0.109, 0.0, 0.0, 0.0), abs=1e-3)


def test_the_body_leans_and_straightens_on_its_course() -> None:
    body = Body(0.1)
    posture = Pose(0.01, -0.02, 0.005, 0.1, -0.2, 0.3)
    for _ in range(300):
        body.step(Twist(0.1, 0.0, 0.0), 0.1, posture, DT)
    assert body.settled(0.1, posture)
    assert not body.settled(0.1, LEVEL)
    assert body.course == pytest.approx((0.3, 0.0, 0.1, 0.0, 0.0, 0.0), abs=1e-9)
    assert body.pose == pytest.approx((0.31, -0.02, 0.105, 0.1, -0.2, 0.3), abs=1e-4)
    for _ in range(400):
        body.step(STILL, 0.1, LEVEL, DT)
    assert body.pose == body.course
