"""Balance, seen from above: the centre of mass, and the polygon of the feet that stand."""

import itertools
import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from robotwalk.model import RobotModel
from robotwalk.statics import LegMasses
from robotwalk.types import Vec3

_ROUNDING = 1e-9  # m


class HalfPlane(NamedTuple):
    """The points (x, y) with nx x + ny y >= bound; the normal is a unit vector."""

    nx: float
    ny: float
    bound: float  # m


def centre_of_mass(model: RobotModel, angles: Sequence[float]) -> Vec3:
    """Return the centre of mass in the base frame, m."""
    return Masses(model).centre_and_feet(angles)[0]


class Masses:
    """Where a robot's masses are: its legs', and the body's at its origin."""

    def __init__(self, model: RobotModel) -> None:
        self._mass = model.mass
        self._legs = tuple((leg.span, LegMasses(leg, model.foot_mass)) for leg in model.legs)

    def centre_and_feet(self, angles: Sequence[float]) -> tuple[Vec3, list[Vec3]]:
        """Return the centre of mass and all feet in the base frame, m, for all joints' angles, rad."""
        x = y = z = 0.0
        feet: list[Vec3] = []
        for span, leg in self._legs:
            foot, (mx, my, mz) = leg.foot_and_moment(angles[span])
            feet.append(Vec3(*foot))
            x, y, z = x + mx, y + my, z + mz
        whole = self._mass
        return Vec3(x / whole, y / whole, z / whole), feet


def support_polygon(feet: Iterable[Vec3]) -> list[HalfPlane]:
    """Return the sides of the feet's convex hull, the inside of each; none if the feet are in a line."""
    hull = _convex_hull([(foot.x, foot.y) for foot in feet])
    if len(hull) < 3:
        return []
    sides = []
    for (ax, ay), (bx, by) in zip(hull, [*hull[1:], hull[0]], strict=True):
        length = math.hypot(bx - ax, by - ay)
        nx, ny = (ay - by) / length, (bx - ax) / length
        sides.append(HalfPlane(nx, ny, nx * ax + ny * ay))
    return sides


def support_margin(feet: Sequence[Vec3], point: Vec3) -> float:
    """Return how far a point lies inside the convex hull of the feet, seen from above, m; negative outside."""
    hull = _convex_hull([(foot.x, foot.y) for foot in feet])
    if len(hull) < 3:
        return -math.inf
    margin, (x, y, _) = math.inf, point
    ax, ay = hull[-1]
    for bx, by in hull:
        dx, dy = bx - ax, by - ay
        margin = min(margin, (dx * (y - ay) - dy * (x - ax)) / math.hypot(dx, dy))
        ax, ay = bx, by
    return margin


def beyond_edge(feet: Sequence[Vec3], point: Vec3) -> float:
    """Return how far a point is outside the convex hull of the feet, seen from above, m; negative inside.

    Two feet have a line for a hull, one a point.
    """
    margin = support_margin(feet, point)
    if margin >= 0.0:
        return -margin
    distance = min(math.dist(foot[:2], point[:2]) for foot in feet)
    for (ax, ay, _), (bx, by, _) in itertools.combinations(feet, 2):
        dx, dy = bx - ax, by - ay
        along = (dx * (point.x - ax) + dy * (point.y - ay)) / (dx * dx + dy * dy)
        if 0.0 < along < 1.0:
            distance = min(distance, math.hypot(ax + along * dx - point.x, ay + along * dy - point.y))
    return distance


def nearest_inside(x: float, y: float, planes: Sequence[HalfPlane]) -> tuple[float, float] | None:
    """Return the point nearest to (x, y) that is in all half-planes; None if they have none in common.

    Planes are added one by one. Where the nearest point so far is outside a new one, the nearest point now lies
    on its edge (Seidel 1991).
    """
    px, py = x, y
    for index, (nx, ny, bound) in enumerate(planes):
        if nx * px + ny * py >= bound - _ROUNDING:
            continue
        # Along the edge from the foot of the perpendicular: p = foot + t (-ny, nx).
        short = bound - nx * x - ny * y
        fx, fy = x + nx * short, y + ny * short
        low, high = -math.inf, math.inf
        for mx, my, other in planes[:index]:
            slope = my * nx - mx * ny
            room = mx * fx + my * fy - other
            if slope > _ROUNDING:
                low = max(low, -room / slope)
            elif slope < -_ROUNDING:
                high = min(high, -room / slope)
            elif room < -_ROUNDING:
                return None
        if low > high:
            return None
        t = min(max(0.0, low), high)
        px, py = fx - ny * t, fy + nx * t
    return px, py


def _convex_hull(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the hull counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(set(points))
    if len(ordered) == 3:
        a, b, c = ordered
        turn = _turn(a, b, c)
        return [a, b, c] if turn > 0.0 else [a, c, b] if turn < 0.0 else [a, c]

    def chain(sequence: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        hull: list[tuple[float, float]] = []
        for p in sequence:
            while len(hull) >= 2 and _turn(hull[-2], hull[-1], p) <= 0.0:
                hull.pop()
            hull.append(p)
        return hull[:-1]

    return chain(ordered) + chain(ordered[::-1]) if len(ordered) > 2 else ordered


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Return twice the area of a triangle, m^2; positive counter-clockwise."""
    (ax, ay), (bx, by), (cx, cy) = a, b, c
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
