"""A foot's way through the air."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotwalk.swing import SWING_PATHS, Motion, half_ellipse, least_jerk, parabola, way_made

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


@pytest.mark.parametrize("path", SWING_PATHS.values())
def test_a_lift_is_zero_at_both_ends_and_one_half_way(path: object) -> None:
    assert callable(path)
    assert path(0.0) == pytest.approx(0.0, abs=1e-12)
    assert path(1.0) == pytest.approx(0.0, abs=1e-12)
    assert path(0.5) == pytest.approx(1.0, abs=1e-12)
    heights = [path(index / 100) for index in range(101)]
    assert heights[:51] == sorted(heights[:51])
    assert heights == pytest.approx(heights[::-1])


@pytest.mark.parametrize("path", SWING_PATHS.values())
def test_a_foot_leaves_and_meets_the_ground_without_speed(path: object) -> None:
    assert callable(path)
    du = 1e-4
    for progress in (0.0, 1.0 - du):
        assert abs(path(way_made(progress + du)) - path(way_made(progress))) / du < 1e-5


def test_shapes() -> None:
    assert parabola(0.25) == pytest.approx(0.75)
    assert parabola(0.1) == pytest.approx(0.36)
    # The ellipse is the steeper one: 2 sqrt(w (1 - w)) is 0.6 at a tenth of the way, and its ends are rounded.
    assert half_ellipse(0.1) == pytest.approx(0.5440, abs=1e-4)
    assert half_ellipse(0.25) == pytest.approx(0.8464, abs=1e-4)
