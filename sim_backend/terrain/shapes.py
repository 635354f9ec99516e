"""What a ground is made of: pieces that know how high they are, in metres, in the world's frame.

They know nothing of MuJoCo: `sim_backend.terrain.build` turns them into geoms.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.types import Vec3

Rows = Sequence[Sequence[float]]


class Span(NamedTuple):
    """A rectangle seen from above."""

    x0: float
    x1: float
    y0: float
    y1: float

    def holds(self, x: float, y: float) -> bool:
        """Return whether a point is in it."""
        return self.x0 <= x <= self.x1 and self.y0 <= y <= self.y1


class Slab(NamedTuple):
    """Level ground."""

    span: Span
    height: float
    friction: float | None = None  # None: as the rest of the world

    def top(self, x: float, y: float) -> float:
        """Return its height at a point, -inf where it is not."""
        return self.height if self.span.holds(x, y) else -math.inf


class Incline(NamedTuple):
    """A plank that rises or falls along x."""

    span: Span
    start: float  # its height at x0
    end: float  # its height at x1
    friction: float | None = None

    def top(self, x: float, y: float) -> float:
        """Return its height at a point, -inf where it is not."""
        if not self.span.holds(x, y):
            return -math.inf
        share = (x - self.span.x0) / (self.span.x1 - self.span.x0)
        return self.start + share * (self.end - self.start)


class Blocks(NamedTuple):
    """Square blocks side by side; `heights[row][column]` are their tops, rows along x, columns along y."""

    span: Span
    heights: Rows
    friction: float | None = None

    def top(self, x: float, y: float) -> float:
        """Return its height at a point, -inf where it is not."""
        if not self.span.holds(x, y):
            return -math.inf
        row, _ = _cell(x, self.span.x0, self.span.x1, len(self.heights))
        column, _ = _cell(y, self.span.y0, self.span.y1, len(self.heights[0]))
        return self.heights[row][column]

    def each(self) -> list[Slab]:
        """Return the blocks one by one."""
        rows, columns = len(self.heights), len(self.heights[0])
        dx, dy = (self.span.x1 - self.span.x0) / rows, (self.span.y1 - self.span.y0) / columns
        x0, y0 = self.span.x0, self.span.y0
        return [
            Slab(Span(x0 + row * dx, x0 + (row + 1) * dx, y0 + column * dy, y0 + (column + 1) * dy),
                 self.heights[row][column], self.friction)
            for row in range(rows) for column in range(columns)]


class HeightField(NamedTuple):
    """Rough ground: `heights[row][column]` at the points of a grid, two triangles between each four.

    Rows lie along x, columns along y. The triangles meet along the diagonal from the least x and y to the greatest, as
    MuJoCo has it.
    """

    span: Span
    heights: Rows
    friction: float | None = None

    def top(self, x: float, y: float) -> float:
        """Return its height at a point, -inf where it is not."""
        if not self.span.holds(x, y):
            return -math.inf
        row, u = _cell(x, self.span.x0, self.span.x1, len(self.heights) - 1)
        column, v = _cell(y, self.span.y0, self.span.y1, len(self.heights[0]) - 1)
        (near_right, near_left), (far_right, far_left) = (
            self.heights[row + ahead][column:column + 2] for ahead in (0, 1))
        middle = far_right if u > v else near_left
        return near_right + max(u, v) * (middle - near_right) + min(u, v) * (far_left - middle)


Shape = Slab | Incline | Blocks | HeightField


class LooseBody(NamedTuple):
    """A brick that lies around."""

    position: Vec3  # of its centre, m
    yaw: float  # rad
    size: Vec3  # m, its edges
    mass: float  # kg


def _cell(at: float, first: float, last: float, count: int) -> tuple[int, float]:
    """Return in which of `count` equal cells between `first` and `last` it lies, and how far into that, 0 to 1."""
    place = (at - first) / (last - first) * count
    cell = min(int(place), count - 1)
    return cell, place - cell
