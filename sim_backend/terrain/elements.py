"""The elements that courses are composed of. Each one goes on where the one before it ended, at its height.

Chance comes from the run's seed: equal seeds give equal ground.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from random import Random
from typing import Annotated, Literal, NamedTuple, get_args

from pydantic import AfterValidator, Field

from robotwalk.config.schema import Range, Section
from robotwalk.types import Vec3
from sim_backend.terrain.shapes import Blocks, HeightField, Incline, LooseBody, Shape, Slab, Span

_MOST_CELLS = 5000  # of one element; MuJoCo would crawl

Length = Annotated[float, Field(gt=0, le=100_000)]
Height = Annotated[float, Field(ge=-2000, le=2000)]
Friction = Annotated[float, Field(gt=0, le=5, description="sliding friction, instead of the world's")]


def _within_reason(pair: tuple[float, float]) -> tuple[float, float]:
    if max(map(abs, pair)) > 2000.0:
        raise ValueError("should be within -2000 and 2000")
    return pair


def _of_matter(pair: tuple[float, float]) -> tuple[float, float]:
    if pair[0] <= 0.0:
        raise ValueError("should be above 0")
    return pair


Heights = Annotated[Range, AfterValidator(_within_reason)]
Sizes = Annotated[Range, AfterValidator(_of_matter)]


class Strip(NamedTuple):
    """Where an element begins, m."""

    x: float
    height: float
    width: float  # across the course, which has y = 0 in its middle

    def span(self, length: float, start: float = 0.0) -> Span:
        """Return its rectangle from `start` on, for a length."""
        return Span(self.x + start, self.x + start + length, -0.5 * self.width, 0.5 * self.width)


class Laid(NamedTuple):
    """An element in its place, m."""

    shapes: list[Shape]
    length: float
    rise: float  # how much higher the next one begins
    lowest: float  # height of its lowest point, which the floor must not hide
    bodies: Sequence[LooseBody] = ()


class Element(Section, ABC):
    """A stretch of ground. Its first key, `element`, is its name."""

    @classmethod
    def kind(cls) -> str:
        """Return the element's name."""
        name: str = get_args(cls.model_fields["element"].annotation)[0]
        return name

    def flaw(self, width: float) -> tuple[str, str] | None:
        """Return a key and what is wrong with it on a course of that width, m; None if nothing is."""
        return None

    @abstractmethod
    def lay(self, strip: Strip, chance: Random) -> Laid:
        """Return it, laid where `strip` says."""


class Level(Element):
    """Level ground."""

    element: Literal["level"]
    length_mm: Length
    friction: Friction | None = None

    def lay(self, strip: Strip, chance: Random) -> Laid:
        """Return it, laid where `strip` says."""
        length = 1e-3 * self.length_mm
        return Laid([Slab(strip.span(length), strip.height, self.friction)], length, 0.0, strip.height)


class Ramp(Element):
    """A slope, up or down; its length is measured along the level."""

    element: Literal["ramp"]
    length_mm: Length
    slope_deg: Annotated[float, Field(gt=-60, lt=60, description="up if positive")]
    friction: Friction | None = None

    def lay(self, strip: Strip, chance: Random) -> Laid:
        """Return it, laid where `strip` says."""
        length = 1e-3 * self.length_mm
        rise = length * math.tan(math.radians(self.slope_deg))
        plank = Incline(strip.span(length), strip.height, strip.height + rise, self.friction)
        return Laid([plank], length, rise, strip.height + min(rise, 0.0))


class Stairs(Element):
    """Steps, up or down: each is a riser and the tread behind it."""

    element: Literal["stairs"]
    steps: Annotated[int, Field(ge=1, le=1000)]
    rise_mm: Height  # of each step; down if negative
    tread_mm: Length
    friction: Friction | None = None

    def lay(self, strip: Strip, chance: Random) -> Laid:
        """Return them, laid where `strip` says."""
        rise, tread = 1e-3 * self.rise_mm, 1e-3 * self.tread_mm
        treads: list[Shape] = [
            Slab(strip.span(tread, step * tread), strip.height + (step + 1) * rise, self.friction)
            for step in range(self.steps)]
        climb = self.steps * rise
        return Laid(treads, self.steps * tread, climb, strip.height + min(climb, 0.0))


class BlockField(Element):
    """Square blocks side by side, each of its own height: independent, evenly distributed over the range."""

    element: Literal["blocks"]
    length_mm: Length
    block_mm: Length  # edge of a block; length and width of the course are whole multiples of it
    heights_mm: Heights  # above where the element begins
    friction: Friction | None = None

    def flaw(self, width: float) -> tuple[str, str] | None:
        """Return a key and what is wrong with it on a course of that width, m; None if nothing is."""
        return _grid_flaw("block_mm", self.block_mm, self.length_mm, width)

    def lay(self, strip: Strip, chance: Random) -> Laid:
        """Return them, laid where `strip` says."""
        length = 1e-3 * self.length_mm
        rows, columns = round(self.length_mm / self.block_mm), round(1e3 * strip.width / self.block_mm)
        heights = [[strip.height + 1e-3 * chance.uniform(*self.heights_mm) for _ in range(columns)]
                   for _ in range(rows)]
        blocks = Blocks(strip.span(length), heights, self.friction)
        return Laid([blocks], length, 0.0, strip.height + 1e-3 * min(self.heights_mm[0], 0.0))


class Rough(Element):
    """A height field: independent heights at the points of a square grid, evenly distributed over the range.

    Two plane triangles lie between each four neighbours. Its first and last rows of points are level with the rest.
    """

    element: Literal["rough"]
    length_mm: Length
    cell_mm: Length  # of the grid; length and width of the course are whole multiples of it
    heights_mm: Heights  # above where the element begins
    friction: Friction | None = None

    def flaw(self, width: float) -> tuple[str, str] | None:
        """Return a key and what is wrong with it on a course of that width, m; None if nothing is."""
        return _grid_flaw("cell_mm", self.cell_mm, self.length_mm, width)

    def lay(self, strip: Strip, chance: Random) -> Laid:
        """Return it, laid where `strip` says."""
        length = 1e-3 * self.length_mm
        rows, columns = round(self.length_mm / self.cell_mm) + 1, round(1e3 * strip.width / self.cell_mm) + 1
        level = [strip.height] * columns
        between = [[strip.height + 1e-3 * chance.uniform(*self.heights_mm) for _ in range(columns)]
                   for _ in range(rows - 2)]
        field = HeightField(strip.span(length), [level, *between, level], self.friction)
        return Laid([field], length, 0.0, strip.height + 1e-3 * min(self.heights_mm[0], 0.0))


class Gap(Element):
    """A ditch across the course."""

    element: Literal["gap"]
    length_mm: Length  # along the course
    depth_mm: Annotated[float, Field(gt=0, le=2000)]

    def lay(self, strip: Strip, chance: Random) -> Laid:
        """Return it, laid where `strip` says."""
        length, bottom = 1e-3 * self.length_mm, strip.height - 1e-3 * self.depth_mm
        return Laid([Slab(strip.span(length), bottom)], length, 0.0, bottom)


class Drop(Element):
    """An edge: the course goes on below it."""

    element: Literal["drop"]
    depth_mm: Annotated[float, Field(gt=0, le=2000)]

    def lay(self, strip: Strip, chance: Random) -> Laid:
        """Return it, laid where `strip` says."""
        depth = 1e-3 * self.depth_mm
        return Laid([], 0.0, -depth, strip.height - depth)


class Loose(Element):
    """Bricks that lie around on level ground, each somewhere in a field of its own, turned anyhow.

    Edges and masses are independent, evenly distributed over their ranges.
    """

    element: Literal["loose"]
    length_mm: Length
    lane_mm: Length  # breadth of the ground on which they lie, in the middle of the course
    field_mm: Length  # edge of each body's square field; length and lane are whole multiples of it
    edges_mm: Sizes
    mass_g: Sizes
    friction: Friction | None = None  # of the ground

    def flaw(self, width: float) -> tuple[str, str] | None:
        """Return a key and what is wrong with it on a course of that width, m; None if nothing is."""
        if self.lane_mm > 1e3 * width:
            return "lane_mm", f"is broader than the course, which has {1e3 * width:g} mm"
        if self.field_mm < 1.5 * self.edges_mm[1]:
            return "field_mm", "should be at least 1.5 times the longest edge, or bodies would overlap"
        return _grid_flaw("field_mm", self.field_mm, self.length_mm, 1e-3 * self.lane_mm)

    def lay(self, strip: Strip, chance: Random) -> Laid:
        """Return it, laid where `strip` says."""
        length, field = 1e-3 * self.length_mm, 1e-3 * self.field_mm
        right = -0.5e-3 * self.lane_mm
        bodies = [
            self._body(strip.x + row * field, right + column * field, strip.height, chance)
            for row in range(round(self.length_mm / self.field_mm))
            for column in range(round(self.lane_mm / self.field_mm))]
        slab = Slab(strip.span(length), strip.height, self.friction)
        return Laid([slab], length, 0.0, strip.height, bodies)

    def _body(self, x: float, y: float, height: float, chance: Random) -> LooseBody:
        """Return a body on its largest face, somewhere in the field whose corner is at x, y."""
        edges = sorted((1e-3 * chance.uniform(*self.edges_mm) for _ in range(3)), reverse=True)
        size = Vec3(*edges)
        margin = 0.5 * math.hypot(size.x, size.y)
        free = max(1e-3 * self.field_mm - 2.0 * margin, 0.0)
        centre = Vec3(
            x + margin + free * chance.random(), y + margin + free * chance.random(), height + 0.5 * size.z)
        return LooseBody(centre, chance.uniform(-math.pi, math.pi), size, 1e-3 * chance.uniform(*self.mass_g))


ELEMENTS: Mapping[str, type[Element]] = {
    element.kind(): element for element in (Level, Ramp, Stairs, BlockField, Rough, Gap, Drop, Loose)}


def _grid_flaw(key: str, cell_mm: float, length_mm: float, width: float) -> tuple[str, str] | None:
    """Return what is wrong with the cells of a grid, if anything is."""
    cells = length_mm / cell_mm, 1e3 * width / cell_mm
    if any(count < 0.5 or abs(count - round(count)) > 1e-6 for count in cells):
        return key, f"should divide the length of {length_mm:g} mm and the width of {1e3 * width:g} mm"
    if cells[0] * cells[1] > _MOST_CELLS:
        return key, f"makes {cells[0] * cells[1]:.0f} cells; at most {_MOST_CELLS}"
    return None
