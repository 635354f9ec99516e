"""One file of `configs/terrains`: a course of elements ahead of the robot, read and laid out.

The ground is level where the robot sits and goes on level behind the course. Units are part of the keys.
"""

import math
from collections.abc import Sequence
from difflib import get_close_matches
from random import Random
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field

from robotwalk.config.document import Document
from robotwalk.config.schema import Positive, Section
from sim_backend.terrain.elements import ELEMENTS, Element, Strip
from sim_backend.terrain.shapes import LooseBody, Shape, Slab, Span

_LAWN = 20.0  # m; how far the ground extends where a floor further down would end it
_SAME = 1e-9  # m
_DEEPER = 0.1  # m; how far down the floor is where it would else touch what has a friction of its own


class TerrainConfig(Section):
    """One file of `configs/terrains`."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    name: str
    description: str
    lead_mm: Annotated[float, Field(ge=0, le=10_000)] = 300.0  # from the front of the body to where the course begins
    width_mm: Positive = 2000.0
    course: list[dict[str, Any]]  # elements, each with its own keys


class Ground(NamedTuple):
    """A ground, m, in the world's frame: x ahead of the robot, which begins at 0, 0; y to its left."""

    floor: float  # height of the plane under all
    shapes: Sequence[Shape] = ()
    bodies: Sequence[LooseBody] = ()

    def height(self, x: float, y: float) -> float:
        """Return how high the ground is there; bodies that lie around are not counted."""
        return max([self.floor, *(shape.top(x, y) for shape in self.shapes)])


FLAT = Ground(0.0)


class Terrain(NamedTuple):
    """A file of a terrain, read."""

    config: TerrainConfig
    elements: Sequence[Element]
    document: Document

    def lay_out(self, front: float, seed: int) -> Ground:
        """Return the ground for a robot whose body's front is at x = `front`, m."""
        begin = x = front + 1e-3 * self.config.lead_mm
        width = 1e-3 * self.config.width_mm
        height = lowest = 0.0
        shapes: list[Shape] = []
        bodies: list[LooseBody] = []
        for index, element in enumerate(self.elements):
            laid = element.lay(Strip(x, height, width), Random(f"{seed} {index} {element.kind()}"))
            shapes += laid.shapes
            bodies += laid.bodies
            lowest = min(lowest, laid.lowest)
            x, height = x + laid.length, height + laid.rise
        if any(shape.friction is not None and _is_at(shape, lowest) for shape in shapes):
            lowest -= _DEEPER
        shapes.insert(0, Slab(Span(begin - _LAWN, begin, -_LAWN, _LAWN), 0.0))
        shapes.append(Slab(Span(x, x + _LAWN, -0.5 * width, 0.5 * width), height))
        # What is level with the floor is the floor.
        standing = [shape for shape in shapes if not _is_at(shape, lowest)]
        return Ground(lowest, standing, bodies)

    @property
    def length(self) -> float:
        """How long the course is, m."""
        strip = Strip(0.0, 0.0, 1e-3 * self.config.width_mm)
        return math.fsum(element.lay(strip, Random(0)).length for element in self.elements)


def _is_at(shape: Shape, height: float) -> bool:
    """Return whether a shape is level and at that height."""
    return isinstance(shape, Slab) and abs(shape.height - height) < _SAME


def read_terrain(document: Document) -> Terrain:
    """Read the file of a terrain.

    Raises:
        ConfigError: it is wrong; says where.
    """
    config = document.validate(TerrainConfig)
    return Terrain(config, [_read_element(document, config, index) for index in range(len(config.course))], document)


def _read_element(document: Document, config: TerrainConfig, index: int) -> Element:
    path = ("course", index)
    name = document.value((*path, "element"))
    if not isinstance(name, str) or name not in ELEMENTS:
        near = get_close_matches(str(name), ELEMENTS, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(ELEMENTS)}"
        raise document.error((*path, "element"), f"no such element; {hint}", name)
    element = document.validate(ELEMENTS[name], at=path)
    flaw = element.flaw(1e-3 * config.width_mm)
    if flaw is not None:
        key, problem = flaw
        raise document.error((*path, key), problem, document.value((*path, key)))
    return element
