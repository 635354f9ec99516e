"""A flat figure of a few shapes, kept as data and written as SVG, or as PNG through Pillow."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple
from xml.sax.saxutils import escape

from robotwalk.errors import UsageError

_SCALE = 2  # pixels per unit of the picture
_SMOOTH = 2  # the picture is drawn this much larger, then shrunk

Point = tuple[float, float]


class Line(NamedTuple):
    """Straight pieces from point to point."""

    points: tuple[Point, ...]
    colour: str
    width: float = 1.0


class Area(NamedTuple):
    """A filled polygon."""

    points: tuple[Point, ...]
    colour: str


class Disc(NamedTuple):
    """A filled circle."""

    centre: Point
    radius: float
    colour: str


class Text(NamedTuple):
    """A line of text; `anchor` is where of it the place is."""

    place: Point
    text: str
    anchor: str = "start"  # or "middle", "end"
    size: float = 12.0
    colour: str = "#222222"


class Figure:
    """Shapes, drawn in order; x to the right, y down."""

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = width, height
        self.shapes: list[Line | Area | Disc | Text] = []

    def line(self, points: Sequence[Point], colour: str, width: float = 1.0) -> None:
        """Add a line."""
        self.shapes.append(Line(tuple(points), colour, width))

    def area(self, points: Sequence[Point], colour: str) -> None:
        """Add a filled polygon."""
        self.shapes.append(Area(tuple(points), colour))

    def box(self, x: float, y: float, width: float, height: float, colour: str) -> None:
        """Add a filled rectangle."""
        self.area(((x, y), (x + width, y), (x + width, y + height), (x, y + height)), colour)

    def disc(self, centre: Point, radius: float, colour: str) -> None:
        """Add a filled circle."""
        self.shapes.append(Disc(centre, radius, colour))

    def wedge(self, centre: Point, radius: float, start: float, length: float, colour: str) -> None:
        """Add a sector of a circle, in turns clockwise from the top."""
        steps = max(round(48 * length), 2)
        rim = [on_circle(centre, radius, start + length * step / steps) for step in range(steps + 1)]
        self.area([centre, *rim], colour)

    def text(
        self, place: Point, text: str, anchor: str = "start", size: float = 12.0, colour: str = "#222222"
    ) -> None:
        """Add a line of text."""
        self.shapes.append(Text(place, text, anchor, size, colour))

    def svg(self) -> str:
        """Return it as SVG."""
        width, height = f"{self.width:g}", f"{self.height:g}"
        rows = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
            f'viewBox="0 0 {width} {height}" font-family="sans-serif">',
            f'<rect width="{width}" height="{height}" fill="#ffffff"/>']
        for shape in self.shapes:
            if isinstance(shape, Text):
                rows.append(
                    f'<text x="{shape.place[0]:.1f}" y="{shape.place[1]:.1f}" font-size="{shape.size:g}" '
                    f'text-anchor="{shape.anchor}" fill="{shape.colour}">{escape(shape.text)}</text>')
            elif isinstance(shape, Disc):
                (x, y), radius, colour = shape
                rows.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}" fill="{colour}"/>')
            else:
                points = " ".join(f"{x:.1f},{y:.1f}" for x, y in shape.points)
                paint = (
                    f'fill="{shape.colour}"' if isinstance(shape, Area)
                    else f'fill="none" stroke="{shape.colour}" stroke-width="{shape.width:g}"')
                rows.append(f'<{"polygon" if isinstance(shape, Area) else "polyline"} points="{points}" {paint}/>')
        return "\n".join([*rows, "</svg>", ""])

    def save(self, path: Path) -> None:
        """Write it as the file's name says.

        Raises:
            UsageError: the name ends neither in .svg nor in .png, or the file cannot be written.
        """
        try:
            if path.suffix == ".svg":
                path.write_text(self.svg())
            elif path.suffix == ".png":
                self._paint(path)
            else:
                raise UsageError(f"{path} should end in .svg or .png")
        except OSError as error:
            raise UsageError(f"{path} cannot be written: {error.strerror or error}") from error

    def _paint(self, path: Path) -> None:
        from PIL import Image, ImageDraw, ImageFont

        zoom = _SCALE * _SMOOTH
        image = Image.new("RGB", (round(self.width * zoom), round(self.height * zoom)), "#ffffff")
        draw = ImageDraw.Draw(image)
        for shape in self.shapes:
            if isinstance(shape, Text):
                font = ImageFont.load_default(shape.size * zoom)
                anchor = {"start": "ls", "middle": "ms", "end": "rs"}[shape.anchor]
                draw.text(_zoomed(shape.place, zoom), shape.text, shape.colour, font, anchor)
            elif isinstance(shape, Disc):
                (x, y), radius = shape.centre, shape.radius
                draw.ellipse((*_zoomed((x - radius, y - radius), zoom), *_zoomed((x + radius, y + radius), zoom)),
                             shape.colour)
            elif isinstance(shape, Area):
                draw.polygon([_zoomed(point, zoom) for point in shape.points], shape.colour)
            else:
                draw.line(
                    [_zoomed(point, zoom) for point in shape.points], shape.colour, round(shape.width * zoom), "curve")
        size = (image.width // _SMOOTH, image.height // _SMOOTH)
        image.resize(size, Image.Resampling.LANCZOS).save(path)


def on_circle(centre: Point, radius: float, turns: float) -> Point:
    """Return a point on a circle, `turns` clockwise from the top."""
    return centre[0] + radius * math.sin(math.tau * turns), centre[1] - radius * math.cos(math.tau * turns)


def _zoomed(point: Point, zoom: float) -> Point:
    return point[0] * zoom, point[1] * zoom
