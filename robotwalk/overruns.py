"""A computer that keeps no time: first the gait is slowed, then the robot sits (`safety: overruns` of its file).

Ticks that come too late are left out (`robotwalk.clock.Grid`), so what counts is the share of the last ones that were.
"""

from typing import NamedTuple

from robotwalk.config.safety import OverrunsConfig


class Late(NamedTuple):
    """What a tick makes of those before it."""

    slow: bool = False
    trouble: str | None = None  # why the robot should sit, in words
    news: str | None = None


IN_TIME = Late()


class Overruns:
    """Counts the ticks left out of a window that moves along."""

    def __init__(self, config: OverrunsConfig, rate_hz: int) -> None:
        self._config = config
        self._window = [False] * max(round(config.window_s * rate_hz), 1)  # of the grid's points, whether left out
        self._next = self._count = 0
        self._slow = False

    def step(self, missed: int) -> Late:
        """Take a tick, before which so many were left out."""
        if not missed and not self._count:
            return IN_TIME
        for _ in range(min(missed, len(self._window))):
            self._add(True)
        self._add(False)
        config, share = self._config, self._count / len(self._window)
        was_slow, self._slow = self._slow, share > (0.5 if self._slow else 1.0) * config.slow_share
        told = f"{share:.0%} of the last {config.window_s:g} s' ticks came too late"
        news = None
        if self._slow and not was_slow:
            news = f"{told}: it walks slower"
        elif was_slow and not self._slow:
            news = "the ticks come in time again"
        return Late(self._slow, told if share > config.sit_share else None, news)

    def _add(self, left_out: bool) -> None:
        self._count += left_out - self._window[self._next]
        self._window[self._next] = left_out
        self._next = (self._next + 1) % len(self._window)
