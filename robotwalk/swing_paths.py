"""The shapes of a foot's way through the air, as a robot's file has them (PPS section 3; ARTH figure 3, section 5.2).

A path is a closed curve in the plane of the step's direction and the body's up axis. Its first half leads from
lift-off to the nominal touchdown; the second, where it has one, leads down and back to where the foot came from, if
nothing was struck. Points are shares: `way` of the step's length, `height` of the leg's lift.
"""

import itertools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from robotwalk.config.schema import BezierConfig, BezierPiece, SwingPathConfig

_ROUNDING = 0.15
_SAMPLES = 200  # of a piece, in search of its highest point


class Motion(NamedTuple):
    """Position, velocity and acceleration along one axis; over time, or over whatever else moves on."""

    position: float
    velocity: float
    acceleration: float


class PathPoint(NamedTuple):
    """Where a path is, with its first and second derivative."""

    way: Motion  # 0 at lift-off, 1 at nominal touchdown
    height: Motion  # 1 is the leg's lift


# One half of a path, over a parameter of 0 to 1.
Curve = Callable[[float], PathPoint]


class SwingPath:
    """A path over the progress of a swing: 1 is the nominal touchdown, 2 back where it began.

    Within each half the parameter starts and ends with neither speed nor acceleration, so the foot leaves the ground,
    meets it and begins to retract without a jump in either. A path without a second half ends at its touchdown.
    """

    def __init__(self, forth: Curve, back: Curve | None = None) -> None:
        self._forth = forth
        self._back = back
        self._end = _still(forth(1.0))
        self._origin = None if back is None else _still(back(1.0))

    @property
    def retracts(self) -> bool:
        """Tell whether it has a second half."""
        return self._back is not None

    def place(self, progress: float) -> tuple[float, float]:
        """Return the way and the height for a progress."""
        way, height = self._on_curve(progress)[1]
        return way[0], height[0]

    def at(self, progress: float) -> PathPoint:
        """Return the point for a progress, with its derivatives by progress."""
        u, point = self._on_curve(progress)
        if u is None:
            return point
        way, height = point
        left = 1.0 - u
        rate = 30.0 * (u * left) ** 2  # of the curve's parameter, by progress
        change, square = 60.0 * u * left * (left - u), rate * rate
        return PathPoint(
            Motion(way[0], way[1] * rate, way[2] * square + way[1] * change),
            Motion(height[0], height[1] * rate, height[2] * square + height[1] * change))


    def _on_curve(self, progress: float) -> tuple[float | None, PathPoint]:
        """Return the share of its half's time for a progress, None where it is at rest, and the point of the curve."""
        if progress < 1.0:
            u, curve = max(progress, 0.0), self._forth
        elif self._back is None or progress == 1.0:
            return None, self._end
        elif progress < 2.0:
            u, curve = progress - 1.0, self._back
        else:
            return None, self._origin or self._end
        return u, curve(u * u * u * (10.0 + u * (-15.0 + 6.0 * u)))


def _still(point: PathPoint) -> PathPoint:
    return PathPoint(Motion(point.way.position, 0.0, 0.0), Motion(point.height.position, 0.0, 0.0))


def parabola(s: float) -> PathPoint:
    """PPS section 3: evenly over the ground, highest half way."""
    return PathPoint(Motion(s, 1.0, 0.0), Motion(4.0 * s * (1.0 - s), 4.0 * (1.0 - 2.0 * s), -8.0))


def upper_half(s: float) -> PathPoint:
    """ARTH figure 3 from 0 to 50 %.

    A true ellipse starts upright, which no servo follows; its ends are rounded by `_ROUNDING` of its height.
    """
    root = math.sqrt(4.0 * s * (1.0 - s) + _ROUNDING**2)
    slope = 2.0 * (1.0 - 2.0 * s) / root
    return PathPoint(
        Motion(s, 1.0, 0.0),
        Motion((root - _ROUNDING) / _APEX, slope / _APEX, -(4.0 + slope * slope) / (root * _APEX)))


_APEX = math.sqrt(1.0 + _ROUNDING**2) - _ROUNDING


def lower_half(s: float) -> PathPoint:
    """ARTH figure 3 from 50 to 100 %: as deep below the ground as the upper half is high above it."""
    (way, _, _), (height, slope, curvature) = upper_half(s)
    return PathPoint(Motion(1.0 - way, -1.0, 0.0), Motion(-height, -slope, -curvature))


class Spline:
    """Cubic Bezier pieces, one behind the other, as smooth where they meet as their control points let them be.

    The pieces share the parameter such that the velocity does not change where one ends and the next begins: where the
    handles on both sides of a joint lie in one line, the curve is C1.
    """

    def __init__(self, pieces: Sequence[BezierPiece], *, scale: float = 1.0) -> None:
        shares = [1.0]
        for (_, _, c, d), (_, after, _, _) in itertools.pairwise(pieces):
            shares.append(shares[-1] * math.dist(d, after) / math.dist(c, d))
        whole, start = sum(shares), 0.0
        self._pieces = []
        for piece, share in zip(pieces, shares, strict=True):
            length = share / whole
            (x, y) = ([point[axis] for point in piece] for axis in (0, 1))
            self._pieces.append((start, length, _power_basis(x, 1.0), _power_basis(y, scale)))
            start += length

    def __call__(self, s: float) -> PathPoint:
        """Return the point at a parameter of 0 to 1."""
        start, length, way, height = self._pieces[0]
        for piece in self._pieces[1:]:
            if s < piece[0]:
                break
            start, length, way, height = piece
        t = (s - start) / length
        return PathPoint(_cubic(way, t, length), _cubic(height, t, length))

    def highest(self) -> float:
        """Return the height of its highest point, to a thousandth."""
        return max(self(index / _SAMPLES).height.position for index in range(_SAMPLES + 1))


_Cubic = tuple[float, float, float, float]


def _power_basis(points: Sequence[float], scale: float) -> _Cubic:
    a, b, c, d = (scale * point for point in points)
    return a, 3.0 * (b - a), 3.0 * (a - 2.0 * b + c), d - a + 3.0 * (b - c)


def _cubic(terms: _Cubic, t: float, length: float) -> Motion:
    a, b, c, d = terms
    return Motion(
        a + t * (b + t * (c + t * d)), (b + t * (2.0 * c + 3.0 * t * d)) / length,
        (2.0 * c + 6.0 * t * d) / (length * length))


_NAMED = {
    "parabola": SwingPath(parabola),
    "half_ellipse": SwingPath(upper_half),
    "ellipse": SwingPath(upper_half, lower_half),
}


def swing_path(config: SwingPathConfig) -> SwingPath:
    """Return the path of a file; one of Bezier pieces is scaled so that its highest point is the leg's lift."""
    if not isinstance(config, BezierConfig):
        return _NAMED[config]
    scale = 1.0 / Spline(config.bezier).highest()
    back = Spline(config.retraction, scale=scale) if config.retraction else None
    return SwingPath(Spline(config.bezier, scale=scale), back)
