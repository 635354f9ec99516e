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
from robotwalk.swing import Swing
from robotwalk.swing_paths import SwingPath
from robotwalk.types import STILL, UP, Pose, Twist, Vec3

_AT_REST = 1.5e-3  # m; a foot this near its rest position need not step
_LATEST_LIFTOFF = 0.6  # of a sector; a foot held back for longer sits this swing out
_LATEST_RETARGET = 0.5  # of a swing
_STRETCH = 0.55  # of its largest stride that a foot may be from rest; half in a steady gait


class Footfalls(NamedTuple):
    """All feet at one moment, in the order of the robot's legs."""

    centres: tuple[Vec3, ...]  # in odom, m
    planted: tuple[bool, ...]
    footprints: tuple[tuple[float, float], ...]  # in odom, m: where each foot stands, or will be set down


class _Foot:
    """One foot's place and, in the air, its way."""

    def __init__(self, leg: Leg) -> None:
        self.leg = leg
        self.place = self.target = Vec3(0.0, 0.0, 0.0)  # of its centre; where it stands, or is being carried to
        self.swing: Swing | None = None  # under way
        self.sector: Sector | None = None  # of that swing
        self.share = 0.0  # turns that it takes
        self.spent: Sector | None = None  # the sector already used in this turn of the needle

    def plant(self, place: Vec3) -> None:
        self.place = self.target = place
        self.swing = self.sector = None

    def offset(self, course: Pose) -> tuple[float, float]:
        """Return where the foot is from its rest position, in the body's axes, m."""
        x, y = placed(course, self.leg.rest_foot)
        dx, dy = self.place.x - x, self.place.y - y
        c, s = math.cos(course.yaw), math.sin(course.yaw)
        return c * dx + s * dy, c * dy - s * dx

    def displacement(self, course: Pose) -> float:
        """Return how far the foot is from its rest position, m."""
        return math.hypot(*self.offset(course))

    def lift_off(self, sector: Sector, share: float, path: SwingPath | None) -> Swing:
        self.sector = sector
        self.share = share
        self.swing = Swing(path or self.leg.swing_path, self.leg.lift, self.place)
        return self.swing


class Stepping:
    """Steps the feet under a moving body, by the needle of a gait clock."""

    def __init__(self, model: RobotModel, course: Pose) -> None:
        self._ground = model.foot_radius
        self._min_swing = model.motion.min_swing
        self._feet = [_Foot(leg) for leg in model.legs]
        for foot in self._feet:
            foot.plant(Vec3(*placed(course, foot.leg.rest_foot), self._ground))

    def change_gait(self, clock: GaitClock, gait: Gait, course: Pose, twist: Twist) -> float:
        """Go on with another gait as soon as the standing feet can wait for their turns in it.

        Returns:
            The share of the twist, 0 to 1, at which they could; at 1 the change is made.
        """
        candidates = sorted({*gait.starts, *(index / 12.0 for index in range(12))})

        def longest_stretch(phase: float) -> float:
            stretch = 0.0
            for index, foot in enumerate(self._feet):
                if foot.sector is None:
                    wait = gait.until_lift_off(index, phase) * clock.period
                    (dx, dy), (ux, uy) = foot.offset(course), _passing(foot.leg, twist)
                    stretch = max(stretch, math.hypot(dx - ux * wait, dy - uy * wait))
            return stretch

        phase = min(candidates, key=longest_stretch)
        share = self._bearable(gait, phase, clock.period, course, twist)
        if share >= 1.0:
            clock.change(gait, phase)
        return share

    def bearable(self, clock: GaitClock, course: Pose, twist: Twist) -> float:
        """Return the share of a twist, 0 to 1, at which no standing foot is over-stretched before its turn.

        In a steady gait that is 1. It is less while a foot waits longer than its stride allows: after a change
        of gait, or when the body turns back on its way.
        """
        return self._bearable(clock.gait, clock.phase, clock.period, course, twist)

    def _bearable(self, gait: Gait, phase: float, period: float, course: Pose, twist: Twist) -> float:
        share = 1.0
        for index, foot in enumerate(self._feet):
            if foot.sector is not None:
                continue
            due = self._due(foot, index, gait, phase) is not None
            wait = 0.0 if due else gait.until_lift_off(index, phase) * period
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

    def until_lift_off(self, clock: GaitClock) -> float:
        """Return the time until a foot's turn to lift off, s; 0 if one is due."""
        turns = 1.0
        for index, foot in enumerate(self._feet):
            if foot.sector is None:
                if self._due(foot, index, clock.gait, clock.phase) is not None:
                    return 0.0
                turns = min(turns, clock.gait.until_lift_off(index, clock.phase))
        return turns * clock.period

    def settled(self, course: Pose) -> bool:
        """Tell whether all feet stand at rest below the body."""
        return all(foot.sector is None and foot.displacement(course) <= _AT_REST for foot in self._feet)

    def step(
        self, clock: GaitClock, course: Pose, twist: Twist, dt: float, *, hold: bool = False, up: Vec3 = UP
    ) -> Footfalls:
        """Advance all feet by `dt` s, the body being at `course` and moving with `twist`; on `hold` none lifts off.

        Swings are in the plane of their direction and `up`, the body's up axis in odom.
        """
        for index, foot in enumerate(self._feet):
            if foot.swing is not None and foot.sector is not None:
                self._swing(foot, foot.swing, foot.sector, clock.period, course, twist, dt, up)
                if foot.sector is None:
                    foot.spent = clock.gait.sector_at(index, clock.phase)
        # Landings come first: a foot that waited for one lifts off in the same tick.
        in_air = {index for index, foot in enumerate(self._feet) if foot.sector is not None}
        for index, foot in enumerate(self._feet):
            if foot.sector is not None:
                continue
            if foot.spent is not clock.gait.sector_at(index, clock.phase):
                foot.spent = None
            sector = self._due(foot, index, clock.gait, clock.phase)
            idle = twist == STILL and foot.displacement(course) <= _AT_REST
            if sector is None or idle or hold or not clock.gait.lifts_together(in_air | {index}):
                continue
            in_air.add(index)
            swing = foot.lift_off(sector, (1.0 - sector.progress(clock.phase)) * sector.length, clock.gait.swing_path)
            self._swing(foot, swing, sector, clock.period, course, twist, dt, up)
        return self.footfalls()

    def footfalls(self) -> Footfalls:
        """Return the feet as they are."""
        return Footfalls(
            tuple(foot.place for foot in self._feet),
            tuple(foot.sector is None for foot in self._feet),
            tuple((foot.target.x, foot.target.y) for foot in self._feet),
        )

    def _due(self, foot: _Foot, index: int, gait: Gait, phase: float) -> Sector | None:
        """Return the sector in which a standing foot may lift off at a phase, if it is in one not yet used."""
        sector = gait.sector_at(index, phase)
        if sector is None or sector is foot.spent or sector.progress(phase) > _LATEST_LIFTOFF:
            return None
        return sector

    def _swing(
        self, foot: _Foot, swing: Swing, sector: Sector, period: float, course: Pose, twist: Twist, dt: float, up: Vec3
    ) -> None:
        seconds = max(foot.share * period, self._min_swing)
        if swing.progress <= _LATEST_RETARGET:
            remaining = (1.0 - swing.progress) * seconds
            x, y = footprint(foot.leg, course, twist, remaining - dt + 0.5 * sector.stance * period)
            swing.retarget(Vec3(x, y, self._ground))
            foot.target = swing.target
        foot.place = swing.step(dt, seconds, up)
        if swing.progress >= 1.0:
            foot.plant(foot.target)


def footprint(leg: Leg, course: Pose, twist: Twist, seconds: float) -> tuple[float, float]:
    """Return where a foot belongs whose coming stance has its middle in `seconds`, in odom, m."""
    return placed(advanced(course, twist, seconds), leg.rest_foot)


def _passing(leg: Leg, twist: Twist) -> tuple[float, float]:
    """Return the velocity at which the body passes over a leg's rest position, in the body's axes, m/s."""
    return twist.vx - twist.wz * leg.rest_foot.y, twist.vy + twist.wz * leg.rest_foot.x
