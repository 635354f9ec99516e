"""A line through waypoints on the ground, and how far along it somebody is."""

import itertools
import math
from collections.abc import Sequence

_SEARCH = 0.10  # m along the line; so far ahead of the last place is the nearest one looked for
_LEAST = 1e-9  # m; shorter pieces are none


class Track:
    """A polyline, followed from its start. Progress never goes back.

    Attributes:
        length: m.
        progress: m from the start, of the place on the line that is nearest to where somebody was last.
    """

    def __init__(self, points: Sequence[tuple[float, float]]) -> None:
        """Join the points, m, the first of them the start."""
        self._pieces: list[tuple[float, float, float, float, float]] = []  # x, y, unit vector, length
        for (ax, ay), (bx, by) in itertools.pairwise(points):
            length = math.hypot(bx - ax, by - ay)
            if length > _LEAST:
                self._pieces.append((ax, ay, (bx - ax) / length, (by - ay) / length, length))
        self._end = points[-1]
        self.length = sum(piece[4] for piece in self._pieces)
        self.progress = 0.0

    def at(self, progress: float) -> tuple[float, float]:
        """Return the place so far from the start, m; beyond its end, the end."""
        for x, y, ux, uy, length in self._pieces:
            if progress <= length:
                return x + ux * progress, y + uy * progress
            progress -= length
        return self._end

    def advance(self, x: float, y: float) -> float:
        """Take a new place and return the progress.

        Only what lies shortly ahead is looked at: a line that crosses itself, or comes back beside itself, is not cut.
        """
        begin, nearest, least = 0.0, self.progress, math.inf
        for ax, ay, ux, uy, length in self._pieces:
            low, high = max(self.progress - begin, 0.0), min(self.progress + _SEARCH - begin, length)
            if low <= high:
                along = min(max((x - ax) * ux + (y - ay) * uy, low), high)
                off = math.hypot(x - ax - ux * along, y - ay - uy * along)
                if off < least:
                    nearest, least = begin + along, off
            begin += length
        self.progress = nearest
        return nearest
