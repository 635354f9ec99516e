"""From joint angles to the foot: forward kinematics of any serial chain, in the base frame."""

import math
from collections.abc import Sequence

from robotwalk.model import Axis, Leg
from robotwalk.types import Vec3

_PITCH, _YAW = Axis.PITCH, Axis.YAW


def foot_position(leg: Leg, angles: Sequence[float]) -> Vec3:
    """Return the foot's centre in the base frame, m, for joint angles in rad."""
    return chain_points(leg, angles)[-1]


def chain_points(leg: Leg, angles: Sequence[float]) -> list[Vec3]:
    """Return each joint's origin and at last the foot's centre, in the base frame, m."""
    points = [leg.mount]
    # The axes of the current link's frame in the base frame.
    x, y, z = leg.mount
    xx, xy, xz = math.cos(leg.yaw), math.sin(leg.yaw), 0.0
    yx, yy, yz = -xy, xx, 0.0
    zx, zy, zz = 0.0, 0.0, 1.0
    for joint, angle in zip(leg.joints, angles, strict=True):
        c, s = math.cos(angle), math.sin(angle)
        if joint.axis is _YAW:
            xx, yx = c * xx + s * yx, c * yx - s * xx
            xy, yy = c * xy + s * yy, c * yy - s * xy
            xz, yz = c * xz + s * yz, c * yz - s * xz
        elif joint.axis is _PITCH:
            zx, xx = c * zx + s * xx, c * xx - s * zx
            zy, xy = c * zy + s * xy, c * xy - s * zy
            zz, xz = c * zz + s * xz, c * xz - s * zz
        else:
            yx, zx = c * yx + s * zx, c * zx - s * yx
            yy, zy = c * yy + s * zy, c * zy - s * yy
            yz, zz = c * yz + s * zz, c * zz - s * yz
        lx, ly, lz = joint.link
        x += xx * lx + yx * ly + zx * lz
        y += xy * lx + yy * ly + zy * lz
        z += xz * lx + yz * ly + zz * lz
        points.append(Vec3(x, y, z))
    return points
