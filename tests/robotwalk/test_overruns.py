"""A computer that keeps no time, tick by tick: what the watcher makes of it."""

import pytest

from robotwalk.clock import Grid
from robotwalk.config.safety import OverrunsConfig
from robotwalk.overruns import IN_TIME, Overruns

CONFIG = OverrunsConfig(window_s=1.0, slow_share=0.2, sit_share=0.5, pace=0.5)


def test_a_few_ticks_left_out_are_nothing() -> None:
    overruns = Overruns(CONFIG, 100)
    for tick in range(1000):
        assert not overruns.step(int(tick % 10 == 0)).slow
    assert overruns.step(20).slow is True, "a stall of 0.2 s on top of that is"


def test_it_slows_then_sits_and_is_well_again_when_few_are_left_out() -> None:
    overruns = Overruns(CONFIG, 100)
    told = [overruns.step(1) for _ in range(60)]
    first = next(index for index, late in enumerate(told) if late.slow)
    assert first == 20, "with the 21st of the last 100"
    assert [late.news for late in told if late.news] == ["21% of the last 1 s' ticks came too late: it walks slower"]
    assert all(late.trouble is None for late in told), "half of them are left out, not more"
    worse = [overruns.step(3) for _ in range(10)]
    assert worse[-1].trouble is not None
    assert worse[-1].trouble.endswith("% of the last 1 s' ticks came too late")
    better = [overruns.step(0) for _ in range(110)]
    assert "the ticks come in time again" in [late.news for late in better]
    assert better[-1] == IN_TIME


@pytest.mark.parametrize("stall_ms", [15, 95, 400])
def test_a_stall_leaves_ticks_out_and_bunches_none(stall_ms: int) -> None:
    """After a stall the next tick is a whole period's grid point, and what was missed is counted once."""
    grid, overruns, ms = Grid(100, after=0), Overruns(CONFIG, 100), 1_000_000
    counted = 0
    now = 0
    for tick in range(100):
        before = grid.missed
        now = max(now, grid.deadline) + (stall_ms * ms if tick == 50 else ms)
        grid.advance(now)
        assert 0 <= grid.deadline - now < 10 * ms
        counted += grid.missed - before
        overruns.step(grid.missed - before)
    assert counted == grid.missed == (stall_ms - 1) // 10
