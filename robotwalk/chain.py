"""From joint angles to the foot: forward kinematics of any serial chain, in the base frame."""

import math
from collections.abc import Sequence

from robotwalk.model import Axis, Leg
from robotwalk.types import Vec3


def foot_position(leg: Leg, angles: Sequence[float]) -> Vec3:
    """Return the foot's centre in the base frame, m, for joint angles in rad."""
    return chain_points(leg, angles)[-1]


def chain_points(leg: Leg, angles: Sequence[float]) -> list[Vec3]:
    """Return each joint's origin and at last the foot's centre, in the base frame, m."""
    points = [leg.mount]
    # Columns of the rotation from the current link to the base.
    c, s = math.cos(leg.yaw), math.sin(leg.yaw)
    x, y, z = leg.mount
    ax, ay, az = (c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)
    for joint, angle in zip(leg.joints, angles, strict=True):
        c, s = math.cos(angle), math.sin(angle)
        if joint.axis is Axis.YAW:
            ax, ay = _turn(ax, ay, c, s)
        elif joint.axis is Axis.PITCH:
            az, ax = _turn(az, ax, c, s)
        else:
            ay, az = _turn(ay, az, c, s)
        lx, ly, lz = joint.link
        x += ax[0] * lx + ay[0] * ly + az[0] * lz
        y += ax[1] * lx + ay[1] * ly + az[1] * lz
        z += ax[2] * lx + ay[2] * ly + az[2] * lz
        points.append(Vec3(x, y, z))
    return points


_Column = tuple[float, float, float]


def _turn(first: _Column, second: _Column, c: float, s: float) -> tuple[_Column, _Column]:
    """Rotate two axes by an angle from the first towards the second."""
    return (
        (c * first[0] + s * second[0], c * first[1] + s * second[1], c * first[2] + s * second[2]),
        (c * second[0] - s * first[0], c * second[1] - s * first[1], c * second[2] - s * first[2]),
    )
