"""Capsules and boxes as a painter sees them: outlines, and areas lit enough for each tone."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LIGHT = np.array([-0.25, -0.42, 0.87]) / np.linalg.norm([-0.25, -0.42, 0.87])  # towards the light

_LEVELS = (0.18, 0.58, 0.90)  # cosines of the angle to the light, where the next tone begins
_TONES = (-0.34, -0.14, 0.0, 0.22)  # towards black (-1) or white (1), from shade to highlight
_ARC = 20  # corners of a rounded outline


class Capsule:
    """A cylinder with round ends; a sphere, if it has no length."""

    def __init__(self, centre: Array, half_axis: Array, radius: float) -> None:
        self.centre = centre
        self._half_axis = half_axis
        self._radius = radius

    def outside(self, box: "Box") -> "Capsule":
        """Return the capsule without the end that is in the box, if one is."""
        first, last = box.inside(self.centre, self._half_axis)
        start, end = (last if first <= -1.0 < last else -1.0), (first if first < 1.0 <= last else 1.0)
        if end <= start:
            return self
        middle = self.centre + 0.5 * (start + end) * self._half_axis
        return Capsule(middle, 0.5 * (end - start) * self._half_axis, self._radius)

    def silhouette(self, towards: Array, margin: float) -> Iterator[Array]:
        """Yield polygons (n, 3) that together cover it, grown by `margin`, as seen from `towards`."""
        along = self._half_axis - (self._half_axis @ towards) * towards
        if not along.any():
            along = _across(towards)
        along = unit(along)
        angle = np.linspace(-0.5 * math.pi, 0.5 * math.pi, _ARC)
        end = (self._radius + margin) * _arc(angle, along, np.cross(towards, along))
        yield self.centre + np.concatenate([end + self._half_axis, -end - self._half_axis])

    def areas(self, towards: Array) -> Iterator[tuple[float, Array]]:
        """Yield what is seen from `towards`, as tones and polygons (n, 3), in the order of painting."""
        ends = (self._half_axis, -self._half_axis) if self._half_axis.any() else (self._half_axis,)
        for end in sorted(ends, key=lambda end: float(end @ towards)):
            for tone, directions in zip(_TONES, _lit_caps(towards), strict=True):
                yield tone, self.centre + end + self._radius * directions
        if self._half_axis.any():
            for tone, directions in self._lit_bands(towards):
                rim = self._radius * directions
                yield tone, self.centre + np.concatenate([rim + self._half_axis, rim[::-1] - self._half_axis])

    def _lit_bands(self, towards: Array) -> Iterator[tuple[float, Array]]:
        """Yield arcs of normals (n, 3) across the cylinder that are lit enough for each tone."""
        axis = unit(self._half_axis)
        facing = towards - (towards @ axis) * axis
        facing = unit(facing) if facing.any() else _across(axis)
        sideways = np.cross(axis, facing)
        light = (float(LIGHT @ facing), float(LIGHT @ sideways))
        brightest, strength = math.atan2(light[1], light[0]), math.hypot(*light)
        quarter = 0.5 * math.pi
        yield _TONES[0], _arc(np.linspace(-quarter, quarter, _ARC), facing, sideways)
        for level, tone in zip(_LEVELS, _TONES[1:], strict=True):
            half = math.acos(min(1.0, level / max(strength, 1e-9)))
            first, last = max(-quarter, brightest - half), min(quarter, brightest + half)
            if first < last:
                yield tone, _arc(np.linspace(first, last, _ARC), facing, sideways)


class Box:
    """A box; `half_axes` (3, 3) has one half edge per row."""

    def __init__(self, centre: Array, half_axes: Array) -> None:
        self.centre = centre
        self._half_axes = half_axes

    def inside(self, centre: Array, half_axis: Array) -> tuple[float, float]:
        """Return the range of t in which `centre` + t `half_axis` is in the box; (1, -1) if nowhere."""
        squares = np.sum(self._half_axes**2, axis=1)
        middle = self._half_axes @ (self.centre - centre) / squares
        slope = self._half_axes @ half_axis / squares
        slope = np.where(np.abs(slope) < 1e-9, 1e-9, slope)
        bounds = np.sort(np.stack([(middle - 1.0) / slope, (middle + 1.0) / slope]), axis=0)
        first, last = float(bounds[0].max()), float(bounds[1].min())
        return (first, last) if first < last else (1.0, -1.0)

    def silhouette(self, towards: Array, margin: float) -> Iterator[Array]:
        """Yield polygons (n, 3) that together cover it, grown by `margin`, as seen from `towards`."""
        lengths = np.linalg.norm(self._half_axes, axis=1, keepdims=True)
        for _, face in _faces(self._half_axes * (1.0 + margin / lengths)):
            yield self.centre + face

    def areas(self, towards: Array) -> Iterator[tuple[float, Array]]:
        """Yield what is seen from `towards`, as tones and polygons (n, 3), in the order of painting."""
        for normal, face in _faces(self._half_axes):
            if normal @ towards > 0.0:
                level = int(np.searchsorted(_LEVELS, normal @ LIGHT))
                yield _TONES[level], self.centre + face


Solid = Capsule | Box


def unit(vector: Array) -> Array:
    """Return a vector's direction."""
    result: Array = vector / math.sqrt(float(vector @ vector))
    return result


def _across(vector: Array) -> Array:
    """Return some unit vector at a right angle to `vector`."""
    least = np.zeros(3)
    least[int(np.argmin(np.abs(vector)))] = 1.0
    return unit(np.cross(vector, least))


def _arc(angles: Array, start: Array, sideways: Array) -> Array:
    """Return the directions (n, 3) at `angles` from `start` towards `sideways`."""
    directions: Array = np.outer(np.cos(angles), start) + np.outer(np.sin(angles), sideways)
    return directions


def _circle(axis: Array) -> Array:
    """Return the directions (n, 3) at a right angle to `axis`."""
    side = _across(axis)
    return _arc(np.linspace(0.0, 2.0 * math.pi, 2 * _ARC), side, np.cross(axis, side))


def _light_circles() -> Array:
    """Return the directions (levels, n, 3) at each level's angle around the light."""
    around = _circle(LIGHT)
    return np.stack([level * LIGHT + math.sqrt(1.0 - level**2) * around for level in _LEVELS])


_LIGHT_CIRCLES = _light_circles()


def _lit_caps(towards: Array) -> Iterator[Array]:
    """Yield the areas of a unit sphere (n, 3) that have each tone, as seen from `towards`."""
    yield _circle(towards)
    for circle in _LIGHT_CIRCLES:
        hidden = np.minimum(circle @ towards, 0.0)  # what lies behind the rim moves onto it
        rim = circle - hidden[:, None] * towards
        yield rim / np.linalg.norm(rim, axis=1, keepdims=True)


def _faces(half_axes: Array) -> Iterator[tuple[Array, Array]]:
    """Yield the outer normal and the corners (4, 3) of a box's faces, around its centre."""
    for axis in range(3):
        out, up, side = half_axes[axis], half_axes[axis - 1], half_axes[axis - 2]
        for sign in (-1.0, 1.0):
            yield sign * unit(out), sign * out + np.stack([up + side, up - side, -up - side, side - up])
