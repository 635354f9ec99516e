"""Aligns the body with the ground that its feet stand on, odom with gravity, and the body with that where it is level.

The feet's course is the body's, brought down the body's own axis to the ground: legs fit it however far odom is out of
plumb (ARTH section 5.3).
"""

import math

from robotwalk.body import placed
from robotwalk.estimator import Estimate
from robotwalk.levelling import Levelling
from robotwalk.model import RobotModel
from robotwalk.orientation import GroundPlane, Orientation
from robotwalk.plumb import Plumb, Turn
from robotwalk.stepping import FLAT, Footfalls
from robotwalk.types import Pose, Tilt


class Alignment:
    """Of one robot's body.

    Attributes:
        foot_course: the feet's course.
    """

    def __init__(self, model: RobotModel, course: Pose) -> None:
        """Begin upright and level, the body at `course`."""
        self._height = model.heights.stand
        settings = model.orientation
        self._orientation = Orientation(model, settings) if settings is not None else None
        self._plumb = Plumb(model.mass) if settings is not None and settings.plumb else None
        self._in_swing = settings is not None and settings.in_swing
        self._levelling = Levelling(model.levelling) if model.levelling is not None else None
        self.foot_course = course

    @property
    def at_rest(self) -> bool:
        """Whether nothing is levelled: the body lies as its feet do."""
        return self._levelling is None or self._levelling.at_rest

    def plumb(
        self, told: Pose, estimate: Estimate, footfalls: Footfalls, dt: float, period: float, *, felt: bool
    ) -> Turn | None:
        """Find out of plumb odom, and turn the ground with it; return by how much to turn the feet, if at all.

        Args:
            told: the body's pose in the last tick.
            estimate: of the same moment.
            footfalls: the feet then.
            dt: s since.
            period: of the gait, s.
            felt: whether the feet feel the ground.
        """
        if self._orientation is None or self._plumb is None:
            return None
        if not felt:
            self._plumb.pause()
            return None
        turn = self._plumb.step(told, estimate.felt, footfalls.planted, estimate.imu, dt, period)
        if turn is not None:
            self._orientation.turn(turn)
        return turn

    def over_feet(self, pose: Pose, course: Pose, footfalls: Footfalls, dt: float) -> Pose:
        """Advance by `dt` s; return a body's pose, at `course` and leaning from there, laid over its feet."""
        if self._orientation is None:
            self.foot_course = course
            return pose
        change = self._orientation.step(footfalls.centres if self._in_swing else footfalls.stood, course, dt)
        # Feet rest below the body along its own axis.
        height = self._height
        x, y = placed(course, (-height * math.sin(change.pitch), height * math.sin(change.roll), 0.0))
        self.foot_course = Pose(x, y, course.z, course.roll, course.pitch, course.yaw)
        return Pose(pose.x, pose.y, pose.z + change.z, pose.roll + change.roll, pose.pitch + change.pitch, pose.yaw)

    def levelled(self, pose: Pose, told: Pose, tilt: Tilt | None, dt: float) -> Pose:
        """Advance by `dt` s; return a body's pose, level as far as it is to be. See `Levelling.step`."""
        return pose if self._levelling is None else self._levelling.step(pose, told, tilt, dt)

    def ground(self, course: Pose) -> GroundPlane:
        """Return the ground as the feet know it, for their course; the body is at `course`."""
        if self._orientation is None:
            return FLAT
        return self._orientation.plane.seen_at(course, self.foot_course.x, self.foot_course.y)
