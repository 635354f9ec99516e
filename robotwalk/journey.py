"""What a walk came to: distance, drift, tilt, falls. Fed with poses, of the truth or of odometry."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.track import Track
from robotwalk.types import Pose

_FALLEN_TILT = math.radians(45.0)


class Summary(NamedTuple):
    """A finished journey, in SI units and radians."""

    distance: float  # along the direction of travel, which turns with the body, or along the line
    displacement: Pose  # end minus start, in the frame of the start; yaw accumulated
    max_tilt: float
    min_height: float  # of the base above the ground under it
    fell: bool


class Journey:
    """Adds up a body's poses, one a tick."""

    def __init__(
        self, start: Pose, ground: float = 0.0, *, direction: float, along: Sequence[tuple[float, float]] = (),
        nominal_height: float,
    ) -> None:
        """Begin at `start`, above ground so high.

        Args:
            start, ground: m.
            direction: of travel, relative to the body, rad, 0 ahead.
            along: a line to travel by instead, points from the start on, in its frame, m.
            nominal_height: m above the ground.
        """
        self._track = Track(along) if along else None
        self._start = self._last = start
        self._direction = direction
        self._nominal = nominal_height
        self._yaw = 0.0
        self._distance = 0.0
        self._max_tilt = 0.0
        self._min_height = start.z - ground

    def add(self, pose: Pose, ground: float = 0.0) -> None:
        """Take the next pose, and the height of the ground under the body."""
        turn = math.remainder(pose.yaw - self._last.yaw, math.tau)
        course = self._last.yaw + 0.5 * turn + self._direction
        self._distance += (pose.x - self._last.x) * math.cos(course) + (pose.y - self._last.y) * math.sin(course)
        self._yaw += turn
        # The angle between the body's z axis and the vertical.
        tilt = math.acos(min(math.cos(pose.roll) * math.cos(pose.pitch), 1.0))
        self._max_tilt = max(self._max_tilt, tilt)
        self._min_height = min(self._min_height, pose.z - ground)
        self._last = pose
        if self._track is not None:
            self._distance = self._track.advance(*self.displacement[:2])

    @property
    def displacement(self) -> Pose:
        """The last pose minus the first, in the frame of the first; yaw accumulated."""
        dx, dy = self._last.x - self._start.x, self._last.y - self._start.y
        c, s = math.cos(self._start.yaw), math.sin(self._start.yaw)
        return Pose(
            c * dx + s * dy, c * dy - s * dx, self._last.z - self._start.z,
            self._last.roll - self._start.roll, self._last.pitch - self._start.pitch, self._yaw)

    def summary(self) -> Summary:
        """Return what it came to so far."""
        fell = self._max_tilt > _FALLEN_TILT or self._min_height < 0.5 * self._nominal
        return Summary(self._distance, self.displacement, self._max_tilt, self._min_height, fell)
