"""How far apart capsules are: links with a radius, as line segments; and a segment from a box."""

import math

from robotwalk.types import Vec3

_SHRINKING = 12  # steps of a search, each leaving 0.62 of the segment: to 0.3 % of its length
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_POINT = 1e-12  # m^2; a shorter segment is a point


def between_segments(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> float:
    """Return the distance of the segments a-b and c-d, m.

    Source: Ericson, Real-Time Collision Detection (2005), section 5.1.9.
    """
    ux, uy, uz = b.x - a.x, b.y - a.y, b.z - a.z
    vx, vy, vz = d.x - c.x, d.y - c.y, d.z - c.z
    rx, ry, rz = a.x - c.x, a.y - c.y, a.z - c.z
    uu, vv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
    ur, vr = ux * rx + uy * ry + uz * rz, vx * rx + vy * ry + vz * rz
    uv = ux * vx + uy * vy + uz * vz
    if uu <= _POINT:
        s, t = 0.0, 0.0 if vv <= _POINT else min(max(vr / vv, 0.0), 1.0)
    elif vv <= _POINT:
        s, t = min(max(-ur / uu, 0.0), 1.0), 0.0
    else:
        parallel = uu * vv - uv * uv
        s = min(max((uv * vr - ur * vv) / parallel, 0.0), 1.0) if parallel > _POINT * uu else 0.0
        t = (uv * s + vr) / vv
        if t < 0.0:
            s, t = min(max(-ur / uu, 0.0), 1.0), 0.0
        elif t > 1.0:
            s, t = min(max((uv - ur) / uu, 0.0), 1.0), 1.0
    return math.hypot(rx + s * ux - t * vx, ry + s * uy - t * vy, rz + s * uz - t * vz)


def to_box(a: Vec3, b: Vec3, half: Vec3) -> float:
    """Return the distance of the segment a-b from a box about the origin, of these half lengths, m; 0 inside.

    To 0.3 % of the segment's length.

    Along a segment the distance from a convex body has one valley: it is searched by golden section.
    """
    ux, uy, uz = b.x - a.x, b.y - a.y, b.z - a.z

    def distance(s: float) -> float:
        return math.hypot(
            max(abs(a.x + s * ux) - half.x, 0.0), max(abs(a.y + s * uy) - half.y, 0.0),
            max(abs(a.z + s * uz) - half.z, 0.0))

    low, high = 0.0, 1.0
    near, far = 1.0 - _GOLDEN, _GOLDEN
    at_near, at_far = distance(near), distance(far)
    for _ in range(_SHRINKING):
        if at_near <= at_far:
            high, far, at_far = far, near, at_near
            near = high - _GOLDEN * (high - low)
            at_near = distance(near)
        else:
            low, near, at_near = near, far, at_far
            far = low + _GOLDEN * (high - low)
            at_far = distance(far)
    return min(at_near, at_far, distance(0.0), distance(1.0))
