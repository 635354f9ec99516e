"""Which way is down, without an IMU: by how the robot's weight lies on its feet.

The loads of the standing feet have a middle, the centre of pressure. A body that is not accelerated stands with its
centre of mass straight above it; so the line between the two, both known in the base frame, is the plumb line. A
walking body is accelerated now this way, now that, and as much in all within a turn of its gait. So the body's tilt
is taken to be the one that it was told, which is known at once, and a difference, which is slow: the slope of the
ground, and what odom's own tilt is off.
"""

import math
from collections.abc import Sequence

from robotwalk.contact import Felt
from robotwalk.model import RobotModel
from robotwalk.statics import GRAVITY
from robotwalk.types import Pose, Tilt, Vec3

_SLOW = 1.0  # s in which the difference is followed; half a turn of a crawl
_LEAST = 0.5  # of the weight, that the feet must feel: in a jolt they do not


class TiltByLoad:
    """The plumb line of one robot."""

    def __init__(self, model: RobotModel) -> None:
        self._foot_radius = model.foot_radius  # below its centre a foot touches, as if the ground lay as the body does
        self._weight = model.mass * GRAVITY
        self._roll = self._pitch = 0.0  # rad, that the body is tilted more than it was told

    def step(
        self, felt: Sequence[Felt | None], feet: Sequence[Vec3 | None], centre: Vec3, told: Pose, dt: float
    ) -> Tilt:
        """Advance by `dt` s; return the body's tilt against gravity.

        Args:
            felt: by each foot; None where it does not tell.
            feet: their centres in the base frame, m.
            centre: of mass, in the base frame, m.
            told: pose of the body.
            dt: s; 0 while the robot stands still, for then the friction in its joints hides how its weight shifts.
        """
        load = x = y = z = 0.0
        for feeling, foot in zip(felt, feet, strict=False):
            if feeling is None or foot is None:
                load = 0.0  # the others do not bear all
                break
            share = max(feeling.load, 0.0)
            load += share
            x, y, z = x + share * foot.x, y + share * foot.y, z + share * foot.z
        if load > _LEAST * self._weight:
            dx, dy, dz = centre.x - x / load, centre.y - y / load, centre.z - z / load + self._foot_radius
            share = min(dt / _SLOW, 1.0)
            self._pitch += share * (math.atan2(-dx, dz) - told.pitch - self._pitch)
            self._roll += share * (math.atan2(dy, math.hypot(dx, dz)) - told.roll - self._roll)
        return Tilt(told.roll + self._roll, told.pitch + self._pitch)
