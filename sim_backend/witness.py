"""What became of the body: followed step by step, since a fall lasts less than a tick."""

import math
from typing import Any

from sim_backend.world import World

_FALLEN_TILT_COS = math.cos(math.radians(45.0))
_HARD = 0.3  # m/s; sitting down is slower


class Witness:
    """Follows a world. Call `watch` after every physics step.

    Attributes:
        distance: m, the base's velocity along its own x axis, integrated.
        fell: whether the base was ever tilted by more than 45 degrees, or struck the ground faster than 0.3 m/s.
    """

    def __init__(self, world: World) -> None:
        self.distance = 0.0
        self.fell = False
        self._data = world.data
        self._body = world.model.geom("body")
        self._radius = math.hypot(*self._body.size)
        self._remember()

    def watch(self) -> None:
        """Take note of the step just made."""
        x, y = self._x, self._y
        heading = self._heading
        falling = self._may_strike() and self._strike_speed() > _HARD
        self._remember()
        course = heading + 0.5 * math.remainder(self._heading - heading, math.tau)
        self.distance += (self._x - x) * math.cos(course) + (self._y - y) * math.sin(course)
        self.fell = self.fell or falling or self._upright < _FALLEN_TILT_COS

    def _remember(self) -> None:
        self._x, self._y, _, qw, qx, qy, qz = self._data.qpos[:7].tolist()
        self._heading = math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz))
        self._upright = 1.0 - 2.0 * (qx * qx + qy * qy)  # cosine of the tilt
        self._velocity = self._data.qvel[:6].tolist()

    def _may_strike(self) -> bool:
        """Whether any point of the base moves fast enough; this spares looking at contacts."""
        vx, vy, vz, wx, wy, wz = self._velocity
        return math.hypot(vx, vy, vz) + math.hypot(wx, wy, wz) * self._radius > _HARD

    def _strike_speed(self) -> float:
        """Return how fast the base came down where it touches the ground, m/s.

        After a step, contacts and poses are those of its beginning; so is the velocity remembered, which the
        ground had not yet slowed.
        """
        contact = self._data.contact
        touching = (contact.geom == self._body.id).any(axis=1)
        if not touching.any():
            return 0.0
        centre, axes = self._data.geom_xpos[self._body.id], self._data.geom_xmat[self._body.id].reshape(3, 3)
        wx, wy, _ = axes @ self._velocity[3:]
        arm = contact.pos[touching] - centre
        down: Any = -(self._velocity[2] + wx * arm[:, 1] - wy * arm[:, 0])
        return float(down.max())
