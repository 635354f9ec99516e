"""How long things took: every value counted, none kept."""

from array import array
from bisect import bisect_right
from typing import NamedTuple

# Buckets are 2 % wide from 1 us to about 10 s: 1.02^800 = 7.6e6.
_GROWTH = 1.02
_BUCKETS = 820


class Percentiles(NamedTuple):
    """Of a histogram, in microseconds."""

    p50: float
    p99: float
    p999: float
    max: float


def _edges() -> tuple[float, ...]:
    edges, edge = [0.0], 1.0
    for _ in range(_BUCKETS):
        edges.append(edge)
        edge *= _GROWTH
    return tuple(edges)


class Histogram:
    """Counts durations in logarithmic buckets; its memory never grows."""

    _EDGES = _edges()

    def __init__(self) -> None:
        self._counts = array("Q", bytes(8 * _BUCKETS))
        self._max = 0.0

    def add(self, nanoseconds: int) -> None:
        """Count a duration; negative ones count as 0."""
        us = nanoseconds * 1e-3
        if us > self._max:
            self._max = us
        self._counts[min(bisect_right(self._EDGES, us), _BUCKETS) - 1 if us > 0.0 else 0] += 1

    def percentiles(self) -> Percentiles:
        """Return upper bounds of the percentiles, right to a bucket's 2 % up to 11 s; all 0 if nothing was counted."""
        return Percentiles(self._quantile(0.5), self._quantile(0.99), self._quantile(0.999), round(self._max, 1))

    def _quantile(self, share: float) -> float:
        wanted = share * sum(self._counts)
        seen = 0
        for index, count in enumerate(self._counts):
            seen += count
            if count and seen >= wanted:
                return round(min(self._EDGES[index + 1], self._max), 1)
        return 0.0
