"""From wherever the joints are to the seated posture."""

from itertools import pairwise

import pytest

from robotwalk.unfold import Unfold

DT = 0.01


def angles(start: list[float], end: list[float]) -> list[list[float]]:
    unfold, rows = Unfold(start, end), [start]
    while not unfold.done:
        rows.append(unfold.step(DT))
    return rows


def test_all_joints_arrive_together_in_the_time_of_the_longest_way() -> None:
    for way in (1.6, -1.6):
        rows = angles([0.0, 1.0, 0.5], [way, 1.4, 0.5])
        assert len(rows) == pytest.approx(201, abs=1)  # 1.6 rad at 0.8 rad/s
        assert rows[-1] == pytest.approx([way, 1.4, 0.5])
        assert rows[100] == pytest.approx([0.5 * way, 1.2, 0.5])
        assert rows[50] == pytest.approx([0.103515625 * way, 1.0 + 0.103515625 * 0.4, 0.5])


def test_it_starts_and_ends_at_rest() -> None:
    rows = angles([0.0], [1.6])
    speeds = [(b[0] - a[0]) / DT for a, b in pairwise(rows)]
    assert max(speeds) == pytest.approx(1.5, rel=0.01)  # 15/8 of the average
    assert speeds[0] < 0.001
    assert speeds[-1] < 0.001
    assert min(speeds) >= 0.0


def test_a_short_way_is_not_hurried() -> None:
    assert len(angles([0.0], [0.001])) == pytest.approx(31, abs=1)
    assert len(angles([0.3], [0.3])) == pytest.approx(31, abs=1)


def test_without_time_it_holds_the_joints_where_they_were_found() -> None:
    unfold = Unfold([0.1, 0.2], [1.0, 1.0])
    for _ in range(100):
        assert unfold.step(0.0) == [0.1, 0.2]
    assert not unfold.done
