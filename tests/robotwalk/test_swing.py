"""A foot's way through the air."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotwalk.config.schema import BezierConfig
from robotwalk.swing import Swing, least_jerk, way_made
from robotwalk.swing_paths import Motion, SwingPath, swing_path
from robotwalk.types import Vec3

DT = 0.01
REST = Motion(0.0, 0.0, 0.0)

place = st.floats(-0.2, 0.2)


def carried(motion: Motion, target: float, seconds: float, dt: float = DT) -> list[Motion]:
    """Follow one target to the end, solved anew in each tick."""
    motions = [motion]
    for tick in range(round(seconds / dt)):
        motions.append(least_jerk(motions[-1], target, seconds - tick * dt, dt))
    return motions


def test_a_fixed_target_gives_the_minimum_jerk_curve() -> None:
    motions = carried(REST, 0.1, 0.4)
    # Flash and Hogan: x(t) = X (10 u^3 - 15 u^4 + 6 u^5), u = t / T; here at a quarter, half, three quarters.
    assert [motions[i].position for i in (10, 20, 30)] == pytest.approx([0.0103515625, 0.05, 0.0896484375], abs=1e-12)
    assert motions[20].velocity == pytest.approx(1.875 * 0.1 / 0.4, abs=1e-9)
    assert motions[20].acceleration == pytest.approx(0.0, abs=1e-9)
    assert motions[10].acceleration == pytest.approx(5.625 * 0.1 / 0.16, abs=1e-9)
    assert motions[40] == pytest.approx((0.1, 0.0, 0.0), abs=1e-12)


@given(place, st.floats(-1.0, 1.0), st.floats(-5.0, 5.0), place, st.floats(0.1, 1.0))
def test_it_arrives_at_rest_at_the_stated_time(
    position: float, velocity: float, acceleration: float, target: float, seconds: float
) -> None:
    motion, remaining = Motion(position, velocity, acceleration), seconds
    while remaining > DT:
        motion = least_jerk(motion, target, remaining, DT)
        remaining -= DT
    # It has not landed yet, and is all but there.
    assert motion.position == pytest.approx(target, abs=0.02)
    assert least_jerk(motion, target, remaining, DT) == Motion(target, 0.0, 0.0)
    finer = carried(Motion(position, velocity, acceleration), target, 0.5, 0.001)
    assert finer[-2].position == pytest.approx(target, abs=1e-5)
    assert abs(finer[-2].velocity) < 0.01


@given(st.lists(st.tuples(st.integers(1, 24), st.floats(-0.05, 0.15)), max_size=4))
def test_a_moved_target_leaves_position_velocity_and_acceleration_continuous(moves: list[tuple[int, float]]) -> None:
    dt = 0.001
    targets, at = dict(moves), 0.1
    motion, seconds = REST, 0.4
    for tick in range(250):
        at = targets.get(tick // 10, at)
        before, motion = motion, least_jerk(motion, at, seconds - tick * dt, dt)
        # The largest jerk in reach: 60 m / T^3 over a way of 0.2 m and what was left of the velocity, in 0.15 s.
        assert abs(motion.acceleration - before.acceleration) < 25_000.0 * dt
        assert motion.velocity - before.velocity == pytest.approx(
            0.5 * (motion.acceleration + before.acceleration) * dt, abs=25_000.0 * dt * dt)
        assert motion.position - before.position == pytest.approx(
            0.5 * (motion.velocity + before.velocity) * dt, abs=25_000.0 * dt**3)


def test_the_same_motion_at_any_tick_rate() -> None:
    start = Motion(0.02, -0.3, 1.0)
    coarse, fine = carried(start, 0.1, 0.3, 0.03), carried(start, 0.1, 0.3, 0.001)
    for index in range(10):
        assert coarse[index] == pytest.approx(fine[30 * index], abs=1e-8)


def test_way_made() -> None:
    assert [way_made(u) for u in (-0.5, 0.0, 0.25, 0.5, 0.75, 1.0, 1.5)] == pytest.approx(
        [0.0, 0.0, 0.103515625, 0.5, 0.896484375, 1.0, 1.0])


WINDING = BezierConfig.model_validate({
    "bezier": [[[0, 0], [-0.1, 0.1], [-0.1, 0.9], [0.3, 1.2]], [[0.3, 1.2], [0.6, 1.425], [1.1, 0.6], [1, 0]]],
    "retraction": [[[1, 0], [0.95, -0.3], [0, -0.4], [0, 0]]]})
PATHS = [swing_path(config) for config in ("parabola", "half_ellipse", "ellipse", WINDING)]
TARGET = Vec3(0.1, -0.04, 0.02)
START = Vec3(0.0, 0.0, 0.009)

path = st.sampled_from(PATHS)
# In mid-swing: another place, another path and lift, another duration.
change = st.one_of(
    st.builds(Vec3, place, place, st.floats(-0.05, 0.05)), st.tuples(path, st.floats(0.0, 0.08)), st.floats(0.25, 0.8))


def above_chord(place: Vec3) -> float:
    return place.z - START.z - (place.x - START.x) / (TARGET.x - START.x) * (TARGET.z - START.z)


@pytest.mark.parametrize("path", PATHS)
def test_from_lift_off_to_touchdown_and_back(path: SwingPath) -> None:
    swing = Swing(path, 0.03, START)
    swing.retarget(TARGET)
    forth = [START, *(swing.step(DT, 0.4) for _ in range(40))]
    assert swing.progress == 1.0
    assert forth[-1] == pytest.approx(TARGET, abs=1e-12)
    assert max(above_chord(place) for place in forth) == pytest.approx(0.03, abs=2e-4)
    assert all(p.y / TARGET.y == pytest.approx(p.x / TARGET.x) for p in forth)  # straight, seen from above
    back = [swing.step(DT, 0.4) for _ in range(41)]
    if path.retracts:
        assert back[39] == back[40] == pytest.approx(START, abs=1e-12)
        assert min(above_chord(place) for place in back) < -0.005
    else:
        assert set(back) == {TARGET}


@given(path, st.floats(0.0, 0.08))
def test_a_foot_leaves_and_meets_the_ground_without_speed(path: SwingPath, lift: float) -> None:
    swing = Swing(path, lift, START)
    swing.retarget(TARGET)
    assert swing.velocity == (0.0, 0.0, 0.0)
    for half in (1.0, 2.0):
        before = swing.position
        assert math.dist(swing.step(1e-3, 0.5), before) < 1e-6
        while swing.progress < half:
            swing.step(1e-3, 0.5)
        assert swing.velocity == (0.0, 0.0, 0.0)


@given(path, st.dictionaries(st.integers(0, 9), change, max_size=4))
def test_nothing_that_changes_in_mid_swing_makes_a_foot_jump(path: SwingPath, changes: dict[int, object]) -> None:
    dt, seconds = 1e-3, 0.4
    swing = Swing(path, 0.03, START)
    swing.retarget(TARGET)
    tick = 0
    while swing.progress < 0.7:
        now = changes.get(tick // 25) if tick % 25 == 0 else None
        before, speed = swing.position, swing.velocity
        if isinstance(now, Vec3):
            swing.retarget(now)
        elif isinstance(now, tuple):
            swing.replace(*now)
        elif isinstance(now, float):
            seconds = now
        assert swing.velocity == pytest.approx(speed, abs=1e-9)
        swing.step(dt, seconds)
        # As far as the mean of both speeds takes it; and no speed changes by more than 170 m/s^2 would: 154 is the
        # most that any search has found, four changes in a row.
        mean = [0.5 * (a + b) * dt for a, b in zip(speed, swing.velocity, strict=True)]
        assert [a - b for a, b in zip(swing.position, before, strict=True)] == pytest.approx(mean, abs=2e-5)
        assert math.dist(swing.velocity, speed) < 170.0 * dt
        tick += 1
    target = swing.target
    while swing.progress < 1.0:
        swing.step(dt, seconds)
    assert swing.position == pytest.approx(target, abs=1e-12)


def test_with_a_fixed_target_and_an_even_path_the_foot_goes_with_least_jerk() -> None:
    swing = Swing(PATHS[2], 0.03, START)
    swing.retarget(TARGET)
    motion = REST
    for tick in range(40):
        if tick == 10:
            swing.retarget(Vec3(0.14, 0.0, 0.0))
        motion = least_jerk(motion, 0.14 if tick >= 10 else 0.1, 0.4 - tick * DT, DT)
        assert swing.step(DT, 0.4).x == pytest.approx(motion.position, abs=1e-12)


def test_a_swing_lies_in_the_plane_of_its_direction_and_the_bodys_up_axis() -> None:
    up = Vec3(math.sin(0.3), 0.0, math.cos(0.3))
    swing = Swing(PATHS[2], 0.03, START)
    swing.retarget(Vec3(0.1, 0.0, 0.009))
    for _ in range(20):
        swing.step(DT, 0.4, up)
    assert swing.position == pytest.approx((0.05 + 0.03 * up.x, 0.0, 0.009 + 0.03 * up.z))
