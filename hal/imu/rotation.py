"""Rotations as unit quaternions, Hamilton's convention: `product(a, b)` turns by b first, about a's axes."""

import math
from typing import NamedTuple

from robotwalk.types import Vec3


class Quaternion(NamedTuple):
    """A rotation; of an attitude, it turns what is seen in the body's frame into the world's."""

    w: float
    x: float
    y: float
    z: float


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation b, followed by a."""
    return Quaternion(
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w)


def inverse(q: Quaternion) -> Quaternion:
    """Return the rotation back."""
    return Quaternion(q.w, -q.x, -q.y, -q.z)


def about_x(angle: float) -> Quaternion:
    """Return a turn about x by an angle, rad."""
    return Quaternion(math.cos(0.5 * angle), math.sin(0.5 * angle), 0.0, 0.0)


def about_y(angle: float) -> Quaternion:
    """Return a turn about y by an angle, rad."""
    return Quaternion(math.cos(0.5 * angle), 0.0, math.sin(0.5 * angle), 0.0)


def about_z(angle: float) -> Quaternion:
    """Return a turn about z by an angle, rad."""
    return Quaternion(math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle))


def of_euler(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the attitude of intrinsic yaw, pitch, roll (rad): about z, the new y, the new x."""
    return product(about_z(yaw), product(about_y(pitch), about_x(roll)))


def to_euler(q: Quaternion) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of an attitude, rad: -pi to pi, pitch -pi/2 to pi/2."""
    w, x, y, z = q
    return (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0)),
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def turned(q: Quaternion, vector: Vec3) -> Vec3:
    """Return a vector turned by `q`."""
    _, x, y, z = product(product(q, Quaternion(0.0, *vector)), inverse(q))
    return Vec3(x, y, z)
