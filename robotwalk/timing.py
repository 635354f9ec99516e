"""How long things took: every value counted, none kept."""

from array import array
from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple

# Buckets are 2 % wide from 1 us to about 10 s: 1.02^800 = 7.6e6.
_GROWTH = 1.02
_BUCKETS = 820
HISTOGRAM_SIZE = 8 * (_BUCKETS + 1)  # bytes


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

    def __init__(self, memory: memoryview | None = None) -> None:
        """Begin with nothing counted; in `memory`, of HISTOGRAM_SIZE bytes, go on from what is there."""
        # The last element is the longest duration, ns.
        self._counts = memory.cast("Q") if memory is not None else array("Q", bytes(HISTOGRAM_SIZE))

    def add(self, nanoseconds: int) -> None:
        """Count a duration; negative ones count as 0."""
        counts, us = self._counts, nanoseconds * 1e-3
        if nanoseconds > counts[_BUCKETS]:
            counts[_BUCKETS] = nanoseconds
        counts[min(bisect_right(self._EDGES, us), _BUCKETS) - 1 if us > 0.0 else 0] += 1

    @property
    def count(self) -> int:
        """How many durations were counted."""
        return sum(self._counts[:_BUCKETS])

    def clear(self) -> None:
        """Begin anew."""
        for index in range(len(self._counts)):
            self._counts[index] = 0

    def percentiles(self) -> Percentiles:
        """Return upper bounds of the percentiles, right to a bucket's 2 % up to 11 s; all 0 if nothing was counted."""
        counts, longest = self._counts[:_BUCKETS], 1e-3 * self._counts[_BUCKETS]
        p50, p99, p999 = (self._quantile(share, counts, longest) for share in (0.5, 0.99, 0.999))
        return Percentiles(p50, p99, p999, round(longest, 1))

    def _quantile(self, share: float, counts: Sequence[int], longest: float) -> float:
        wanted = share * sum(counts)
        seen = 0
        for index, count in enumerate(counts):
            seen += count
            if count and seen >= wanted:
                return round(min(self._EDGES[index + 1], longest), 1)
        return 0.0
