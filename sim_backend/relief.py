"""How a ground that is not flat looks: its faces from far to near, as shades laid over the floor's colour."""

from collections.abc import Iterator
from typing import NamedTuple, Protocol

import numpy as np
from PIL import Image, ImageDraw

from sim_backend.solids import LIGHT, Array, unit
from sim_backend.terrain.course import Ground
from sim_backend.terrain.shapes import Blocks, HeightField, Incline, Shape, Slab, Span

TILE_M = 0.1

# Darkness, of 255.
_SIDES = {"x": 46, "y": 66}  # of the faces across x and across y
_EDGE = 58
_TILE = 14
_SLOPE = 260.0  # per cosine to the light that a face lacks beside a level one
_TINTED = 70

_TILED_M = 0.15  # the narrowest face with tiles on it
_AROUND_M = 2.0  # tiles end so far from the course
_SEEN = 2.5  # of the camera's distance: what lies farther from its target is left out


class Projection(Protocol):
    """What a relief needs of a camera."""

    eye: Array

    def fill(self, draw: ImageDraw.ImageDraw, polygon: Array, colour: int, outline: int | None = None) -> None:
        """Draw a polygon (n, 3)."""
        ...


class _Face(NamedTuple):
    corners: Array  # (n, 3), m
    normal: Array
    darkness: int
    outline: int | None = None


class _Piece(NamedTuple):
    """Faces that stand on one rectangle; those of two pieces never hide each other both ways."""

    span: Span
    faces: list[_Face]
    tinted: bool


class Relief:
    """The faces of a ground, made once, painted in every frame."""

    def __init__(self, ground: Ground) -> None:
        self._pieces = [piece for shape in ground.shapes for piece in _pieces(shape, ground.floor)]
        self._spans = np.array([piece.span for piece in self._pieces]).reshape(-1, 4)
        self._tinted = any(piece.tinted for piece in self._pieces)

    def paint(self, camera: Projection, target: Array, distance: float, shade: Image.Image) -> Image.Image | None:
        """Paint the shades onto a mask, over what is on it; return a mask of what is slippery, if anything is."""
        tint = Image.new("L", shade.size) if self._tinted else None
        draws = [ImageDraw.Draw(mask) for mask in (shade, tint) if mask is not None]
        for number in self._far_to_near(camera.eye, target, _SEEN * distance):
            piece = self._pieces[number]
            for face in piece.faces:
                if float((camera.eye - face.corners[0]) @ face.normal) > 0.0:
                    camera.fill(draws[0], face.corners, face.darkness, face.outline)
                    for draw in draws[1:]:
                        camera.fill(draw, face.corners, _TINTED if piece.tinted else 0)
        return tint

    def _far_to_near(self, eye: Array, target: Array, reach: float) -> list[int]:
        """Return the numbers of the pieces near the target in the order of painting."""
        x0, x1, y0, y1 = self._spans.T
        dx, dy = (
            np.maximum(np.maximum(low - point, point - high), 0.0)
            for low, high, point in ((x0, x1, eye[0]), (y0, y1, eye[1])))
        away = np.hypot(
            np.maximum(np.maximum(x0 - target[0], target[0] - x1), 0.0),
            np.maximum(np.maximum(y0 - target[1], target[1] - y1), 0.0))
        order = np.lexsort((-dy, -dx))
        return [int(number) for number in order[away[order] < reach]]


def _pieces(shape: Shape, floor: float) -> Iterator[_Piece]:
    """Yield a shape's pieces."""
    match shape:
        case Slab(span, height, friction):
            yield _prism(span, height, height, floor, friction is not None)
        case Incline(span, start, end, friction):
            yield _prism(span, start, end, floor, friction is not None)
        case Blocks():
            for block in shape.each():
                yield _prism(block.span, block.height, block.height, floor, shape.friction is not None)
        case HeightField():
            yield from _cells(shape, floor)


def _prism(span: Span, start: float, end: float, floor: float, tinted: bool) -> _Piece:
    """Return what rises from the floor to `start` at the rectangle's x0 and to `end` at its x1."""
    x0, x1, y0, y1 = span
    top = np.array([[x0, y0, start], [x1, y0, end], [x1, y1, end], [x0, y1, start]])
    faces = list(_sides(top, floor))
    faces.append(_upper(top, _EDGE))
    if min(x1 - x0, y1 - y0) >= _TILED_M:
        faces += [_upper(tile, None, _TILE) for tile in _tiles(span, start, end)]
    return _Piece(span, faces, tinted)


def _upper(corners: Array, outline: int | None, more: int = 0) -> _Face:
    """Return a face of the surface; the less light falls on it beside a level one, the darker."""
    normal = unit(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
    lack = float(LIGHT[2] - normal @ LIGHT)
    return _Face(corners, normal, max(0, min(90, round(_SLOPE * lack))) + more, outline)


def _sides(top: Array, floor: float) -> Iterator[_Face]:
    """Yield the four walls below a quadrangle."""
    for number in range(4):
        first, second = top[number], top[(number + 1) % 4]
        down = np.array([0.0, 0.0, 1.0])
        along = second - first
        normal = np.array([along[1], -along[0], 0.0])
        wall = np.stack([first, second, second - (second[2] - floor) * down, first - (first[2] - floor) * down])
        darkness = _SIDES["x" if abs(normal[0]) > abs(normal[1]) else "y"]
        yield _Face(wall, normal, darkness)


def _tiles(span: Span, start: float, end: float) -> Iterator[Array]:
    """Yield every other tile of a surface, cut off at its edges, near enough to the course."""
    x0, x1 = max(span.x0, min(span.x1, 0.0) - _AROUND_M), min(span.x1, max(span.x0, 0.0) + 3.0 + _AROUND_M)
    y0, y1 = max(span.y0, -_AROUND_M), min(span.y1, _AROUND_M)
    slope = (end - start) / (span.x1 - span.x0)
    for column in range(int(np.floor(x0 / TILE_M)), int(np.ceil(x1 / TILE_M))):
        for row in range(int(np.floor(y0 / TILE_M)), int(np.ceil(y1 / TILE_M))):
            if (column + row) % 2:
                continue
            left, right = max(column * TILE_M, x0), min((column + 1) * TILE_M, x1)
            low, high = max(row * TILE_M, y0), min((row + 1) * TILE_M, y1)
            if right - left > 1e-6 and high - low > 1e-6:
                z0, z1 = start + slope * (left - span.x0), start + slope * (right - span.x0)
                yield np.array([[left, low, z0], [right, low, z1], [right, high, z1], [left, high, z0]])


def _cells(field: HeightField, floor: float) -> Iterator[_Piece]:
    """Yield the cells of a height field, with walls where it ends."""
    rows, columns = len(field.heights) - 1, len(field.heights[0]) - 1
    xs = np.linspace(field.span.x0, field.span.x1, rows + 1)
    ys = np.linspace(field.span.y0, field.span.y1, columns + 1)
    for row in range(rows):
        for column in range(columns):
            corners = np.array([
                [xs[row + ahead], ys[column + aside], field.heights[row + ahead][column + aside]]
                for ahead, aside in ((0, 0), (1, 0), (1, 1), (0, 1))])
            ends = (column == 0, row == rows - 1, column == columns - 1, row == 0)
            walls = [wall for wall, there in zip(_sides(corners, floor), ends, strict=True) if there]
            faces = [*walls, _upper(corners[[0, 1, 2]], None), _upper(corners[[0, 2, 3]], None)]
            span = Span(float(xs[row]), float(xs[row + 1]), float(ys[column]), float(ys[column + 1]))
            yield _Piece(span, faces, field.friction is not None)
