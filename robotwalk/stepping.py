"""Where the feet are: planted in the world until the needle lifts them, then on their way to a footprint.

A planted foot stands still in odom while the body moves over it. A footprint is the foot's rest position
under the body as it will be at the middle of the coming stance (PPS section 3, figure 3), found anew in each
tick until late in the swing.
"""

import math
from typing import NamedTuple

from robotwalk.body import advanced, placed
from robotwalk.gait import Gait, GaitClock, Sector
from robotwalk.model import Leg, RobotModel
from robotwalk.swing import SWING_PATHS, Motion, least_jerk, way_made
from robotwalk.types import STILL, Pose, Twist, Vec3

_AT_REST = 1.5e-3  # m; a foot this near its rest position need not step
_LATEST_LIFTOFF = 0.6  # of a sector; a foot held back for longer sits this swing out
_LATEST_RETARGET = 0.8  # of a swing
_STRETCH = 0.6  # of its largest stride that a foot may be from rest; half in a steady gait


class Footfalls(NamedTuple):
    """All feet at one moment, in the order of the robot's legs."""

    centres: tuple[Vec3, ...]  # in odom, m
    planted: tuple[bool, ...]


class _Foot:
    """One foot's place and, in the air, its way."""

    def __init__(self, leg: Leg) -> None:
        self.leg = leg
        self.x = self.y = Motion(0.0, 0.0, 0.0)
        self.target = (0.0, 0.0)
        self.lift = 0.0
        self.sector: Sector | None = None  # of the swing under way
        self.share = 0.0  # turns that this swing takes
        self.progress = 0.0
        self.spent: Sector | None = None  # the sector already used in this turn of the needle

    def plant(self, x: float, y: float) -> None:
        self.x, self.y = Motion(x, 0.0, 0.0), Motion(y, 0.0, 0.0)
        self.lift = 0.0
        self.sector = None

    def offset(self, course: Pose) -> tuple[float, float]:
        """Return where the foot is from its rest position, in the body's axes, m."""
        x, y = placed(course, self.leg.rest_foot)
        dx, dy = self.x.position - x, self.y.position - y
        c, s = math.cos(course.yaw), math.sin(course.yaw)
        return c * dx + s * dy, c * dy - s * dx

    def displacement(self, course: Pose) -> float:
        """Return how far the foot is from its rest position, m."""
        return math.hypot(*self.offset(course))

    def lift_off(self, sector: Sector, share: float) -> None:
        self.sector = sector
        self.share = share
        self.progress = 0.0


class Stepping:
    """Steps the feet under a moving body, by the needle of a gait clock."""

    def __init__(self, model: RobotModel, course: Pose) -> None:
        self._path = SWING_PATHS[model.swing_path]
        self._ground = model.foot_radius
        self._min_swing = model.motion.min_swing
        self._feet = [_Foot(leg) for leg in model.legs]
        for foot in self._feet:
            foot.plant(*placed(course, foot.leg.rest_foot))

    def change_gait(self, clock: GaitClock, gait: Gait, course: Pose, twist: Twist) -> None:
        """Go on with another gait, from the phase at which the standing feet can wait best for their turns."""
        candidates = sorted({*gait.starts, *(index / 12.0 for index in range(12))})

        def longest_stretch(phase: float) -> float:
            stretch = 0.0
            for index, foot in enumerate(self._feet):
                if foot.sector is None:
                    wait = gait.until_lift_off(index, phase) * clock.period
                    (dx, dy), (ux, uy) = foot.offset(course), _passing(foot.leg, twist)
                    stretch = max(stretch, math.hypot(dx - ux * wait, dy - uy * wait))
            return stretch

        clock.change(gait, min(candidates, key=longest_stretch))
        for index, foot in enumerate(self._feet):
            if foot.sector is not None:
                foot.sector = gait.feet[index][0]

    def bearable(self, clock: GaitClock, course: Pose, twist: Twist) -> float:
        """Return the share of a twist, 0 to 1, at which no standing foot is over-stretched before its turn.

        In a steady gait that is 1. It is less while a foot waits longer than its stride allows: after a change
        of gait, or when the body turns back on its way.
        """
        share = 1.0
        for index, foot in enumerate(self._feet):
            if foot.sector is not None:
                continue
            wait = clock.gait.until_lift_off(index, clock.phase) * clock.period
            (dx, dy), (ux, uy) = foot.offset(course), _passing(foot.leg, twist)
            limit = _STRETCH * foot.leg.max_stride
            wx, wy = ux * wait, uy * wait
            if (dx - wx) ** 2 + (dy - wy) ** 2 > limit * limit:
                # The share s at which |d - s w| meets the limit; going back towards rest is always allowed.
                along = dx * wx + dy * wy
                way = wx * wx + wy * wy
                inside = along * along - way * (dx * dx + dy * dy - limit * limit)
                share = min(share, max((along + math.sqrt(inside)) / way, 0.0) if inside > 0.0 else 0.0)
        return share

    def settled(self, course: Pose) -> bool:
        """Tell whether all feet stand at rest below the body."""
        return all(foot.sector is None and foot.displacement(course) <= _AT_REST for foot in self._feet)

    def step(self, clock: GaitClock, course: Pose, twist: Twist, dt: float) -> Footfalls:
        """Advance all feet by `dt` s, the body being at `course` and moving with `twist`."""
        in_air = sum(foot.sector is not None for foot in self._feet)
        for index, foot in enumerate(self._feet):
            if foot.sector is None:
                in_air += self._maybe_lift_off(foot, index, clock, course, twist, in_air)
            if foot.sector is not None:
                self._swing(foot, foot.sector, clock.period, course, twist, dt)
                if foot.sector is None:
                    foot.spent = clock.gait.sector_at(index, clock.phase)
        return self.footfalls()

    def footfalls(self) -> Footfalls:
        """Return the feet as they are."""
        ground = self._ground
        return Footfalls(
            tuple(Vec3(foot.x.position, foot.y.position, ground + foot.lift) for foot in self._feet),
            tuple(foot.sector is None for foot in self._feet),
        )

    def _maybe_lift_off(
        self, foot: _Foot, index: int, clock: GaitClock, course: Pose, twist: Twist, in_air: int
    ) -> bool:
        sector = clock.gait.sector_at(index, clock.phase)
        if sector is not foot.spent:
            foot.spent = None
        if sector is None or foot.spent is not None or in_air >= clock.gait.most_swinging:
            return False
        if twist == STILL and foot.displacement(course) <= _AT_REST:
            return False
        progress = sector.progress(clock.phase)
        if progress > _LATEST_LIFTOFF:
            return False
        foot.lift_off(sector, max((1.0 - progress) * sector.length, self._min_swing / clock.period))
        return True

    def _swing(
        self, foot: _Foot, sector: Sector, period: float, course: Pose, twist: Twist, dt: float
    ) -> None:
        remaining = (1.0 - foot.progress) * foot.share * period
        if foot.progress <= _LATEST_RETARGET:
            ahead = advanced(course, twist, remaining + 0.5 * sector.stance * period)
            foot.target = placed(ahead, foot.leg.rest_foot)
        x, y = foot.target
        foot.x = least_jerk(foot.x, x, remaining, dt)
        foot.y = least_jerk(foot.y, y, remaining, dt)
        foot.progress += dt / (foot.share * period)
        if foot.progress >= 1.0:
            foot.plant(x, y)
        else:
            foot.lift = foot.leg.lift * self._path(way_made(foot.progress))


def _passing(leg: Leg, twist: Twist) -> tuple[float, float]:
    """Return the velocity at which the body passes over a leg's rest position, in the body's axes, m/s."""
    return twist.vx - twist.wz * leg.rest_foot.y, twist.vy + twist.wz * leg.rest_foot.x
