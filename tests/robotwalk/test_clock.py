"""Deadlines, and waiting for them."""

import os
import threading
import time
import tty
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotwalk.clock import Grid, WallClock

NS = 1_000_000_000
MS = 1_000_000


class Line:
    """The reading end of a descriptor, with the writing end beside it."""

    def __init__(self, reading: int, writing: int) -> None:
        self.reading, self.writing = reading, writing

    def fileno(self) -> int:
        return self.reading

    def write(self, data: bytes) -> None:
        os.write(self.writing, data)

    def waiting(self) -> int:
        raise NotImplementedError

    def read(self) -> bytes:
        return os.read(self.reading, 4096)

    def close(self) -> None:
        os.close(self.reading)
        os.close(self.writing)


@pytest.fixture(params=["pipe", "pty"])
def line(request: pytest.FixtureRequest) -> Iterator[Line]:
    if request.param == "pipe":
        made = Line(*os.pipe())
    else:
        ours, theirs = os.openpty()
        tty.setraw(theirs)
        made = Line(theirs, ours)
    yield made
    made.close()


@given(st.integers(10, 1000), st.integers(0, 10**15))
def test_deadlines_do_not_drift_whatever_the_rate(rate_hz: int, start: int) -> None:
    grid = Grid(rate_hz, after=start)
    first = grid.deadline
    assert start < first <= start + NS // rate_hz + 1
    for tick in range(1, 50):
        grid.advance(grid.deadline)
        assert abs(grid.deadline * rate_hz - (first * rate_hz + tick * NS)) < 2 * rate_hz  # 2 ns
    assert grid.missed == 0


@pytest.mark.parametrize("rate_hz", [60, 70, 333])
def test_a_minute_at_a_rate_that_divides_no_second(rate_hz: int) -> None:
    grid = Grid(rate_hz, after=0)
    first = grid.deadline
    assert first == NS // rate_hz
    for _ in range(60 * rate_hz):
        grid.advance(grid.deadline + 1000)
    assert grid.deadline == first + 60 * NS
    assert grid.missed == 0


def test_a_late_tick_delays_none_after_it() -> None:
    grid = Grid(100, after=-1)
    assert grid.deadline == 0
    grid.advance(9 * MS)
    assert grid.deadline == 10 * MS
    grid.advance(20 * MS)  # just in time for the next
    assert (grid.deadline, grid.missed) == (20 * MS, 0)


def test_an_overrun_skips_and_counts() -> None:
    grid = Grid(100, after=-1)
    grid.advance(35 * MS)
    assert (grid.deadline, grid.missed) == (40 * MS, 3)
    grid.advance(50 * MS + 1)
    assert (grid.deadline, grid.missed) == (60 * MS, 4)


def test_waiting_ends_at_the_deadline_and_not_before(line: Line) -> None:
    clock = WallClock()
    for ms in (0.2, 1.5, 20.0):
        for ports in ((), (line,)):
            deadline = clock.now() + round(ms * MS)
            clock.wait(ports, deadline)
            assert 0 <= clock.now() - deadline < 0.5 * NS


def test_waiting_sleeps() -> None:
    clock, before = WallClock(), time.process_time()
    clock.wait((), clock.now() + 100 * MS)
    assert time.process_time() - before < 0.02


def test_bytes_end_the_wait(line: Line) -> None:
    clock = WallClock()
    began = clock.now()
    threading.Timer(0.05, line.write, [b"\xff"]).start()
    clock.wait((line,), began + 20 * NS)
    assert 0.04 * NS < clock.now() - began < 5 * NS
    # They are there until read, so the next wait ends at once.
    clock.wait((line,), began + 20 * NS)
    assert clock.now() - began < 5 * NS
    assert line.read() == b"\xff"
    clock.wait((line,), clock.now() + 10 * MS)
    assert clock.now() - began > 0.05 * NS


def test_a_deadline_that_is_past_is_not_waited_for(line: Line) -> None:
    clock = WallClock()
    began = clock.now()
    clock.wait((line,), began - NS)
    clock.wait((line,), began)
    assert clock.now() - began < NS // 10


def test_time_is_the_monotonic_clock() -> None:
    before = time.monotonic_ns()
    assert before <= WallClock().now() <= time.monotonic_ns()
