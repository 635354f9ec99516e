"""Static stability as it is now: how far the centre of mass lies inside the feet that stand (ARTH's stance, live).

From the joints as measured, the masses of the robot's file, the feet that are known to stand and the body's tilt as
estimated. It tells how near the robot is to tipping over if it stopped dead; a trot has no such margin and needs none.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.support import support_margin
from robotwalk.types import Pose, Vec3


class Stability(NamedTuple):
    """The static stability of one moment, from the base's origin in level axes of the body's heading."""

    centre: Vec3  # of mass, m
    standing: tuple[Vec3, ...]  # centres of the feet that stand, m
    margin: float | None  # m to the edge of the feet's polygon, negative outside; None: they span none


def stability(centre: Vec3, feet: Sequence[Vec3], planted: Sequence[bool], pose: Pose) -> Stability:
    """Return the static stability.

    Args:
        centre: of mass, in the base frame, m.
        feet: all feet's centres in the base frame, m.
        planted: which feet stand; empty where none is known to.
        pose: of the base; only its roll and pitch matter.
    """
    standing = [foot for foot, stands in zip(feet, planted, strict=False) if stands]
    if pose.roll != 0.0 or pose.pitch != 0.0:
        centre, *standing = _levelled(pose, [centre, *standing])
    margin = support_margin(standing, centre) if len(standing) >= 3 else None
    return Stability(centre, tuple(standing), margin)


def _levelled(pose: Pose, points: Sequence[Vec3]) -> list[Vec3]:
    """Return points of the base frame in level axes of the same heading."""
    cr, sr = math.cos(pose.roll), math.sin(pose.roll)
    cp, sp = math.cos(pose.pitch), math.sin(pose.pitch)
    levelled = []
    for x, y, z in points:
        across, up = cr * y - sr * z, sr * y + cr * z
        levelled.append(Vec3(cp * x + sp * up, across, cp * up - sp * x))
    return levelled
