"""The last gate before the servos, densely around each of its boundaries."""

import math
from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotwalk.limits import Gate, JointLimit
from robotwalk.self_collision import SelfCollision

DT = 0.01
FREE = JointLimit(-1.0, 1.0, 1e6, 1e9)
SLOW = JointLimit(-1e3, 1e3, 2.0, 1e9)  # 0.02 rad a tick
LAZY = JointLimit(-1e3, 1e3, 1e6, 10.0)  # 0.1 rad/s a tick
REAL = JointLimit(-1.0, 1.0, 2.0, 10.0)

near = st.floats(1e-9, 0.1)


def gate(limit: JointLimit, start: float = 0.0) -> Gate:
    made = Gate(["knee"], [limit])
    made.reset([start])
    return made


@given(near)
def test_position(by: float) -> None:
    for side in (1.0, -1.0):
        free = gate(FREE)
        assert free.step([side], DT) == (side,)
        assert free.step([side * (1.0 - by)], DT) == (side * (1.0 - by),)
        assert not free.cuts
        assert free.step([side * (1.0 + by)], DT) == pytest.approx((side,), abs=1e-12)
        assert free.cuts == {("knee", "position"): 1}


@given(near)
def test_speed(by: float) -> None:
    for side in (1.0, -1.0):
        slow = gate(SLOW)
        inside = side * 0.02 * (1.0 - by)
        assert slow.step([inside], DT) == (inside,)
        assert not slow.cuts
        assert slow.step([inside + side * 0.02 * (1.0 + by)], DT) == pytest.approx((inside + side * 0.02,), abs=1e-12)
        assert slow.cuts == {("knee", "speed"): 1}


@given(near, st.floats(-1.0, 1.0))
def test_acceleration(by: float, speed: float) -> None:
    for side in (1.0, -1.0):
        lazy = gate(LAZY)
        place = 0.0
        for tick in range(1, 101):  # up to a speed, within the acceleration
            place += speed * tick / 100 * DT
            assert lazy.step([place], DT) == (place,)
        inside = speed + side * 0.1 * (1.0 - by)
        place += inside * DT
        assert lazy.step([place], DT) == (place,)
        assert not lazy.cuts
        beyond = inside + side * 0.1 * (1.0 + by)
        assert lazy.step([place + beyond * DT], DT) == pytest.approx((place + (inside + side * 0.1) * DT,), abs=1e-9)
        assert lazy.cuts == {("knee", "acceleration"): 1}


def test_what_is_on_a_limit_is_sent_to_the_last_bit() -> None:
    """Ways and a time that a computer has not exactly: what is sent is no sum of them."""
    for index in range(200):
        for side in (1.0, -1.0):
            assert gate(FREE, -0.99 + 0.00987 * index).step([side], DT) == (side,)


def test_a_tick_of_twice_the_time_allows_twice_the_way() -> None:
    assert gate(SLOW).step([0.04], 0.02) == (0.04,)
    assert gate(LAZY).step([0.004], 0.02) == (0.004,)


def test_the_first_goal_counts_from_where_the_joint_is_at_rest() -> None:
    real = gate(REAL, 0.3)
    assert real.step([0.3], DT) == (0.3,)
    assert not real.cuts
    assert gate(REAL, 0.3).step([-0.5], DT) == pytest.approx((0.299,))
    real = gate(REAL, 0.3)
    for _ in range(50):
        real.step([0.9], DT)
    real.reset([-0.2])
    assert real.step([-0.2], DT) == (-0.2,)
    assert real.step([0.8], DT) == pytest.approx((-0.199,))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_a_number_never_gets_through(bad: float) -> None:
    gated = Gate(["hip", "knee"], [REAL, REAL])
    gated.reset([0.1, 0.2])
    for count in range(1, 500):
        assert gated.step([0.1, bad], DT) == (0.1, 0.2)
        assert gated.cuts == {("knee", "not a number"): count}
    assert gated.step([0.1, 0.2005], DT) == (0.1, 0.2005)


def test_a_joint_found_outside_its_range_comes_back_and_goes_no_farther() -> None:
    for side in (1.0, -1.0):
        real = gate(REAL, side * 1.5)
        goals = [side * real.step([side * 3.0], DT)[0] for _ in range(300)]
        assert goals[0] == max(goals) == pytest.approx(1.499)
        assert goals[-1] == pytest.approx(1.0, abs=1e-9)


def test_a_fast_goal_is_not_carried_over_the_edge_by_its_braking() -> None:
    real = gate(REAL, 0.0)
    goals = [real.step([5.0], DT)[0] for _ in range(200)]
    assert max(goals) == goals[-1] == 1.0


class InTheWay(SelfCollision):
    """Finds that the one leg there is must brake, at every step."""

    def __init__(self) -> None:
        pass

    def reset(self) -> None:
        pass

    def step(self, goals: Sequence[float], speeds: Sequence[float], dt: float) -> list[slice]:
        return [slice(0, 1)] if abs(goals[0]) > 0.99 else []


def test_braking_for_a_collision_carries_no_joint_over_its_edge() -> None:
    for side in (1.0, -1.0):
        held = Gate(["knee"], [REAL], InTheWay())
        held.reset([side * 0.6])
        goals = [side * held.step([side * 0.0195 * tick + side * 0.6], DT)[0] for tick in range(1, 40)]
        assert max(goals) == goals[-1] == 1.0, "so fast that it cannot stop before"
        assert held.cuts["knee", "collision"] > 0


def test_only_what_is_beyond_a_limit_is_counted() -> None:
    """On a limit is within it, whatever else is cut. Numbers that a computer has exactly."""
    exact = JointLimit(-1.0, 1.0, 2.0, 2.0)
    for side in (1.0, -1.0):
        fast = gate(exact)
        assert fast.step([side * 1.0], 0.5) == (side * 0.5,)  # at 2 rad/s and in range; 1 rad/s within a tick
        assert fast.cuts == {("knee", "acceleration"): 1}
        beyond = gate(exact, side * 0.5)
        assert beyond.step([side * 3.0], 0.5) == (side * 1.0,)  # where that is cut to, it has the acceleration
        assert beyond.cuts == {("knee", "position"): 1}


def test_there_is_a_goal_for_every_joint() -> None:
    for goals in ([0.1], [0.1, 0.2, 0.3]):
        gated = Gate(["hip", "knee"], [FREE, FREE])
        gated.reset([0.0, 0.0])
        with pytest.raises(ValueError, match="argument"):
            gated.step(goals, DT)


def test_each_joint_is_counted_by_its_name() -> None:
    names, limits = ["hip", "knee"], [FREE, SLOW]
    gated = Gate(names, limits)
    gated.reset([0.0, 0.0])
    names.reverse()  # what it was made from is its own
    limits.reverse()
    gated.step([2.0, 5.0], DT)
    gated.step([2.0, 0.02], DT)
    assert gated.cuts == {("hip", "position"): 2, ("knee", "speed"): 1}


@given(st.lists(st.floats(-3.0, 3.0) | st.sampled_from([math.nan, math.inf, -math.inf]), max_size=80))
def test_no_sequence_gets_through_unheld(goals: list[float]) -> None:
    real, last, speed = gate(REAL), 0.0, 0.0
    for goal in goals:
        (sent,) = real.step([goal], DT)
        assert -1.0 <= sent <= 1.0
        now = (sent - last) / DT
        assert abs(now) <= 2.0 + 1e-9
        assert abs(now - speed) <= 0.1 + 1e-9 or abs(sent) == 1.0
        last, speed = sent, now
