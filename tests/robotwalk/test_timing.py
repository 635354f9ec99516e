"""How long things took."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotwalk.timing import Histogram


def counted(*microseconds: float) -> Histogram:
    histogram = Histogram()
    for us in microseconds:
        histogram.add(round(1e3 * us))
    return histogram


def test_percentiles_of_known_data() -> None:
    found = counted(*range(1, 10_001)).percentiles()
    assert found.p50 == pytest.approx(5_000, rel=0.02)
    assert found.p99 == pytest.approx(9_900, rel=0.02)
    assert found.p999 == pytest.approx(9_990, rel=0.02)
    assert (found.p50 >= 5_000, found.p99 >= 9_900, found.p999 >= 9_990) == (True, True, True)
    assert found.max == 10_000.0


def test_one_straggler_shows_where_it_should() -> None:
    found = counted(*[100.0] * 999, 54_321.0).percentiles()
    assert found.p50 == found.p99 == found.p999 == pytest.approx(100.0, rel=0.02)
    assert found.max == 54_321.0
    found = counted(*[100.0] * 989, *[2_000.0] * 11).percentiles()
    assert found.p50 == pytest.approx(100.0, rel=0.02)
    assert found.p99 == found.max == 2_000.0


def test_nothing_counted() -> None:
    assert tuple(Histogram().percentiles()) == (0.0, 0.0, 0.0, 0.0)


def test_being_early_counts_as_no_time() -> None:
    found = counted(-5.0, -5.0, -5.0, 7.0).percentiles()
    assert found.p50 <= 1.0
    assert found.max == 7.0


@given(st.lists(st.integers(1_000, 10**10), min_size=1, max_size=50))
def test_a_percentile_is_an_upper_bound_within_a_bucket(nanoseconds: list[int]) -> None:
    histogram = Histogram()
    for ns in nanoseconds:
        histogram.add(ns)
    found, ordered = histogram.percentiles(), sorted(nanoseconds)
    median = 1e-3 * ordered[(len(ordered) - 1) // 2]
    assert median - 0.051 <= found.p50 <= 1.02 * median + 0.051  # shown with one decimal
    assert found.max == round(1e-3 * ordered[-1], 1)
    assert found.p50 <= found.p99 <= found.p999 <= found.max
