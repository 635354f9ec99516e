"""Profiles arrive, at rest, within their limits."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_backend.motion_profile import Trajectories, profile_by_speed, profile_by_time

MS = 1_000_000  # ns

TICKS = st.integers(-20_000, 20_000).map(float)


@given(
    start=TICKS, goal=TICKS, speed=st.integers(-4000, 4000).map(float), limit=st.floats(50.0, 4000.0),
    acceleration=st.floats(100.0, 50_000.0))
def test_profiles_by_speed_end_at_rest_at_the_goal_and_keep_their_limits(
    start: float, goal: float, speed: float, limit: float, acceleration: float,
) -> None:
    profile = profile_by_speed(start, speed, goal, limit, acceleration)
    assert min(profile.ramp_s, profile.cruise_s, profile.brake_s) >= 0.0
    assert abs(profile.cruise_speed) <= limit * (1 + 1e-12)
    assert abs(profile.cruise_speed - speed) <= acceleration * profile.ramp_s + 1e-6
    assert abs(profile.cruise_speed) <= acceleration * profile.brake_s + 1e-6
    trajectories = Trajectories(1)
    trajectories.follow(0, profile, now=5)
    trajectories.advance(5)
    assert (trajectories.position[0], trajectories.speed[0]) == (start, speed)
    trajectories.advance(2_000_000_000_000)
    assert trajectories.position[0] == pytest.approx(goal, abs=1e-5)
    assert trajectories.speed[0] == 0.0


@given(
    start=TICKS, goal=TICKS, speed=st.integers(-4000, 4000).map(float), span=st.integers(1, 32767),
    ramp=st.integers(0, 32767))
def test_profiles_by_time_arrive_in_time(
    start: float, goal: float, speed: float, span: int, ramp: int,
) -> None:
    profile = profile_by_time(start, speed, goal, 1e-3 * span, 1e-3 * ramp)
    assert profile.ramp_s + profile.cruise_s + profile.brake_s == pytest.approx(1e-3 * span)
    trajectories = Trajectories(1)
    trajectories.follow(0, profile, now=0)
    trajectories.advance((span + 1) * MS)
    assert trajectories.position[0] == pytest.approx(goal, abs=1e-4)
