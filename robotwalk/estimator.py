"""Where the body is, as far as joints tell: leg odometry.

Feet that stand do not move; so however the standing feet move in the base frame, the body moves the other
way. Between two ticks that is the planar rigid motion that fits their displacements best (least squares).
What it cannot see is a foot that slips.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.barriers import Barrier
from robotwalk.body import advanced
from robotwalk.contact import Felt
from robotwalk.model import RobotModel
from robotwalk.types import LEVEL, FootSwitch, ImuState, JointState, Pose, Tilt, Twist, Vec3

_SETTLING = 0.06  # s after a footprint is reached before its foot counts: the servo follows its goal later


class Estimate(NamedTuple):
    """The body's state by odometry, and by an IMU if there is one; what the feet feel."""

    pose: Pose  # of the base in odom; yaw is not wrapped; roll and pitch are 0 where `tilt` is not known
    standing_feet: int  # that the last step relied on
    tilt: Tilt | None = None  # of the base against gravity, by the IMU
    imu: ImuState | None = None  # None: there is none, or it has not been heard yet
    feet: tuple[Vec3 | None, ...] = ()  # in the base frame, m; None where a joint did not answer
    felt: tuple[Felt | None, ...] = ()  # by each foot; empty where nothing can be felt
    switches: tuple[FootSwitch, ...] = ()  # of each foot; empty: the robot has none
    barriers: tuple[Barrier, ...] = ()  # that its feet have found where it is


class Odometry:
    """Integrates the motion of the standing feet."""

    def __init__(self, model: RobotModel) -> None:
        self._spans = tuple(leg.span for leg in model.legs)
        self._foot_radius = model.foot_radius
        self._planted_for = [0.0] * len(model.legs)
        self._none = (False,) * len(model.legs)
        self._feet: tuple[Vec3 | None, ...] = (None,) * len(model.legs)
        self._pose = LEVEL._replace(z=model.heights.sit)

    def go_on(self, pose: Pose) -> None:
        """Go on from a pose of the base in odom."""
        self._pose = pose

    def step(
        self, state: JointState, feet: Sequence[Vec3], planted: Sequence[bool], commanded: Twist, dt: float
    ) -> Estimate:
        """Take one measurement.

        Args:
            state: the joints.
            feet: where that has their centres, in the base frame, m.
            planted: which feet stand; empty where none is known to.
            commanded: the twist to go by where too few feet stand.
            dt: s since the last measurement.
        """
        pairs: list[tuple[Vec3, Vec3]] = []
        all_heard = all(state.valid)
        planted = planted or self._none
        self._planted_for = [
            since + dt if stands else 0.0 for since, stands in zip(self._planted_for, planted, strict=True)]
        heard: list[Vec3 | None] = []
        for span, now, before, since in zip(self._spans, feet, self._feet, self._planted_for, strict=True):
            if all_heard or all(state.valid[span]):
                heard.append(now)
                if before is not None and since >= _SETTLING:
                    pairs.append((before, now))
            else:
                heard.append(None)
        self._feet = tuple(heard)
        if len(pairs) >= 2:
            dx, dy, turn = _rigid_motion(pairs)
            c, s = math.cos(self._pose.yaw), math.sin(self._pose.yaw)
            height = self._foot_radius - sum(now.z for _, now in pairs) / len(pairs)
            x, y, _, roll, pitch, yaw = self._pose
            self._pose = Pose(x + c * dx - s * dy, y + s * dx + c * dy, height, roll, pitch, yaw + turn)
        else:
            self._pose = advanced(self._pose, commanded, dt)
        return Estimate(self._pose, len(pairs), feet=self._feet)


def tilted(pose: Pose, tilt: Tilt | None) -> Pose:
    """Return a pose with a tilt against gravity; as it is where that is not known."""
    return pose if tilt is None else Pose(pose.x, pose.y, pose.z, tilt.roll, tilt.pitch, pose.yaw)


def _rigid_motion(pairs: Sequence[tuple[Vec3, Vec3]]) -> tuple[float, float, float]:
    """Return the body's (dx, dy, turn) in its old frame that explains its feet's (before, now) best."""
    n = len(pairs)
    ax = ay = bx = by = 0.0
    for (ux, uy, _), (vx, vy, _) in pairs:
        ax, ay, bx, by = ax + ux, ay + uy, bx + vx, by + vy
    ax, ay, bx, by = ax / n, ay / n, bx / n, by / n
    dot = cross = 0.0
    for (ux, uy, _), (vx, vy, _) in pairs:
        ux, uy, vx, vy = ux - ax, uy - ay, vx - bx, vy - by
        dot += ux * vx + uy * vy
        cross += vx * uy - vy * ux
    turn = math.atan2(cross, dot)
    c, s = math.cos(turn), math.sin(turn)
    return ax - (c * bx - s * by), ay - (s * bx + c * by), turn
