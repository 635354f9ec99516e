"""A joint near the end of its range: it is never sent beyond, and can always brake before."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotwalk.reach import Ranges

DT = 0.01
HIGH = 1.0  # rad
BRAKING = 150.0  # rad/s^2


def kept(path: list[float]) -> list[float]:
    """Return what becomes of a joint's angles, rad, one each tick; its upper limit is `HIGH`."""
    ranges = Ranges([(-HIGH, HIGH)])
    return [ranges.keep([angle], DT)[0] for angle in path]


@given(st.floats(0.1, 10.0), st.sampled_from([1.0, -1.0]))
def test_a_joint_brakes_before_the_end_of_its_range(speed: float, side: float) -> None:
    angles = kept([side * speed * DT * tick for tick in range(1000)])
    speeds = [(now - before) / DT for before, now in itertools.pairwise(angles)]
    assert max(side * angle for angle in angles) < HIGH - math.radians(2.0)
    assert side * angles[-1] > HIGH - math.radians(5.0)
    # In the last degree and a half the little that is left dies out.
    changes = [side * (before - now) / DT for before, now in itertools.pairwise(speeds)]
    assert max(changes) < 1.5 * BRAKING


def test_what_is_slow_enough_or_far_enough_goes_where_it_should() -> None:
    swing = [0.5 * math.sin(math.tau * DT * tick) for tick in range(200)]
    assert kept(swing) == swing
    up_and_down = [0.9 - abs(0.5 * DT * tick - 0.3) for tick in range(120)]
    assert kept(up_and_down) == up_and_down


def test_back_from_the_end_it_follows_without_a_jump() -> None:
    path = [1.3 - abs(2.0 * DT * tick - 1.3) for tick in range(130)]
    angles = kept(path)
    assert max(abs(now - before) for before, now in itertools.pairwise(angles)) < 1.5 * 2.0 * DT
    assert angles[-1] == pytest.approx(path[-1])
