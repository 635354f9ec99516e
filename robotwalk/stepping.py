"""Where the feet are: planted in the world until the needle lifts them, then on their way to a footprint.

A planted foot stands still in odom while the body moves over it. A footprint is the foot's rest position
under the body as it will be at the middle of the coming stance (PPS section 3, figure 3), found anew in each
tick until late in the swing.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.barriers import GivingUp
from robotwalk.body import advanced, placed
from robotwalk.foot import Foot
from robotwalk.free_stepping import FreeStepping
from robotwalk.gait import GaitClock, Sector
from robotwalk.load_sharing import LoadSharing
from robotwalk.model import Leg, RobotModel
from robotwalk.orientation import GroundPlane
from robotwalk.plumb import Turn
from robotwalk.proof import BRINK, NEW_GROUND, Doubt
from robotwalk.reflexes import Reflexes, giving_up
from robotwalk.search import Phase
from robotwalk.senses import Sense
from robotwalk.stance import Stance, due
from robotwalk.statics import GRAVITY
from robotwalk.types import STILL, UP, Pose, Twist, Vec3

_LATEST_RETARGET = 0.5  # of a swing
_NEARLY_OVER = 0.97  # of a sector, at which the needle waits for a swing that goes on
_PRESS = 2e-3  # m below it that a foot is sent, to feel it; one that goes by a load's average feels it without
_PROVEN = 0.1  # s that a foot must have been felt to stand; others lift off before only as long as it does


class Footfalls(NamedTuple):
    """All feet at one moment, in the order of the robot's legs."""

    centres: tuple[Vec3, ...]  # in odom, m
    planted: tuple[bool, ...]
    footprints: tuple[tuple[float, float], ...]  # in odom, m: where each foot stands, or will be set down
    stood: tuple[Vec3, ...]  # in odom, m: where each foot stands, or stood last
    late: bool  # some foot's swing goes on past its turn, or its lift-off waits: the needle has to wait, too
    deep: bool  # a foot found none where it was expected, and looks far below: the body waits
    void: tuple[float, float] | None  # in odom, m: nor there, and looks around or goes back: the body draws back
    giving_up: GivingUp | None  # a foot that found no ground at all, or is held back


FLAT = GroundPlane()


class _Moment(NamedTuple):
    """What all feet go by in a tick."""

    clock: GaitClock
    course: Pose
    twist: Twist
    dt: float
    up: Vec3
    plane: GroundPlane
    wary: float | None


class Stepping:
    """Steps the feet under a moving body, by the needle of a gait clock.

    Attributes:
        stance: what the standing feet can bear.
    """

    def __init__(self, model: RobotModel, course: Pose) -> None:
        self._ground = model.foot_radius
        self._min_swing = model.motion.min_swing
        contact, weight = model.contact, model.mass * GRAVITY
        self._reflexes = Reflexes(contact, weight) if contact is not None else None
        shares = contact is not None and contact.share_load
        self._waits_for_footing = contact is not None and contact.wait_for_footing
        self._careful = contact is not None and contact.sure_after > 0.0
        self._out_of_turn = contact is not None and contact.out_of_turn
        self._sharing = LoadSharing(weight, len(model.legs)) if shares else None
        self._feet = [Foot(leg) for leg in model.legs]
        for foot in self._feet:
            foot.plant(Vec3(*placed(course, foot.leg.rest_foot), self._ground))
        self.stance = Stance(self._feet, self._min_swing)
        self._phase = 0.0  # of the needle

    @property
    def searches(self) -> bool:
        """Whether some foot looks for ground."""
        return any(foot.search is not None for foot in self._feet)

    def step(
        self, clock: GaitClock, course: Pose, twist: Twist, dt: float, *, hold: bool = False, up: Vec3 = UP,
        senses: Sequence[Sense | None] | None = None, plane: GroundPlane = FLAT, loads: Sequence[float] = (),
        wary: float | None = None,
    ) -> Footfalls:
        """Advance all feet by `dt` s, the body being at `course` and moving with `twist`; on `hold` none lifts off.

        Swings are in the plane of their direction and `up`, the body's up axis in odom. They end on the `plane`, or
        where `senses` tell of ground. A standing foot should bear its part of `loads`, N. A foot found none in
        the `wary` way, rad in odom.
        """
        now = _Moment(clock, course, twist, dt, up, plane, wary)
        self._phase = clock.phase
        if senses is None:
            senses = (None,) * len(self._feet)
            self._stop_searching()
        loads = loads or (0.0,) * len(self._feet)
        for index, (foot, sense) in enumerate(zip(self._feet, senses, strict=True)):
            foot.sense = sense
            sector = foot.sector
            if sector is not None:
                swung = foot.swing is not None
                self._move(index, foot, sector, now)
                if foot.sector is None and swung:
                    foot.spent = clock.gait.sector_at(index, clock.phase)
            else:
                foot.settle(dt)
                if self._reflexes is not None:
                    self._reflexes.keep_ground(foot, clock.gait.feet[index][0], loads[index], dt)
        hold = hold or (self._waits_for_footing and self._unsure())
        if self._sharing is not None:
            self._sharing.step(self._feet, senses, loads, dt)
        if clock.gait.free is not None:
            if not hold:
                self._step_freely(clock.gait.free, now)
            return self.footfalls()
        # Landings come first: a foot that waited for one lifts off in the same tick.
        in_air = {index for index, foot in enumerate(self._feet) if foot.sector is not None}
        for index, foot in enumerate(self._feet):
            if foot.sector is not None:
                continue
            turn = clock.gait.sector_at(index, clock.phase)
            if foot.spent is not turn:
                foot.spent = None
            sector = None if hold else due(foot, turn, clock.phase)
            if sector is None or (twist == STILL and foot.at_rest(course)):
                continue
            if not clock.gait.lifts_together(in_air | {index}):
                continue
            if self._sharing is not None and not self._sharing.lets_go(foot, self._feet, senses, loads, dt):
                continue
            in_air.add(index)
            share = (1.0 - sector.progress(clock.phase)) * sector.length
            self._lift_off(foot, sector, share, clock)
            self._move(index, foot, sector, now)
        # A body that shifts is above its feet for the one whose turn it is, and for no other.
        if self._out_of_turn and not hold and clock.gait.balance is None:
            self._relieve(clock, in_air)
        return self.footfalls()

    def _unsure(self) -> bool:
        """Tell whether a foot that was just set down bears nothing."""
        return any(foot.lost_for > 0.0 and foot.borne_for < _PROVEN for foot in self._feet if foot.sector is None)

    def _relieve(self, clock: GaitClock, in_air: set[int]) -> None:
        """Lift the feet off, out of their turn, that would be over-stretched until it comes; the needle waits."""
        for index, foot in enumerate(self._feet):
            if foot.sector is None and foot.hindering and clock.gait.lifts_together(in_air | {index}):
                in_air.add(index)
                sector = clock.gait.feet[index][0]
                self._lift_off(foot, sector, sector.length, clock)
                foot.overdue = True

    def _step_freely(self, free: FreeStepping, now: _Moment) -> None:
        """Lift the feet off that cannot stay where they are."""
        clock = now.clock
        for index in free.due(self._feet, now.course, now.twist, self.stance.swing_time(clock.gait, clock.period)):
            foot, sector = self._feet[index], clock.gait.feet[index][0]
            self._lift_off(foot, sector, sector.length, clock)
            self._move(index, foot, sector, now)

    def _lift_off(self, foot: Foot, sector: Sector, share: float, clock: GaitClock) -> None:
        caution = self._reflexes.caution if self._reflexes is not None else 0.0
        foot.lift_off(sector, share, clock.gait.swing_path, foot.leg.lift + caution)

    def _stop_searching(self) -> None:
        """Have feet that cannot feel what they look for stand where ground was expected: they would lift the body."""
        for foot in self._feet:
            if foot.search is not None:
                foot.anchor(foot.target)

    @property
    def recalled(self) -> int | None:
        """The foot that is to step back to rest, or does, by its number."""
        return next((index for index, foot in enumerate(self._feet) if foot.recalled), None)

    def recall(self, index: int | None) -> None:
        """Have a foot step back to rest, or none."""
        for other, foot in enumerate(self._feet):
            foot.recalled = other == index

    def turn(self, turn: Turn) -> None:
        """Have all feet turned with odom."""
        for foot in self._feet:
            foot.turn(turn)

    def footfalls(self) -> Footfalls:
        """Return the feet as they are."""
        feet = self._feet
        late = self._sharing is not None and self._sharing.waiting
        deep = False
        void: tuple[float, float] | None = None
        gives_up: GivingUp | None = None
        for foot in feet:
            late = late or (foot.overdue and self._outlasts(foot))
            if foot.search is not None and foot.landing_for <= 0.0:
                late, deep = True, deep or foot.search.deep
                if foot.search.phase is not Phase.DOWN:
                    void = foot.target[:2]
                gives_up = gives_up or giving_up(foot)
        return Footfalls(
            tuple([foot.place for foot in feet]),
            tuple([foot.sector is None or foot.landing_for > 0.0 for foot in feet]),
            tuple([foot.target[:2] for foot in feet]),
            tuple([foot.stood for foot in feet]),
            late, deep, void, gives_up)

    def _outlasts(self, foot: Foot) -> bool:
        """Tell whether the swing of a foot that is overdue outlasts its sector: the needle has to wait for it."""
        return foot.sector is not None and foot.sector.progress(self._phase) >= _NEARLY_OVER

    def _move(self, index: int, foot: Foot, sector: Sector, now: _Moment) -> None:
        """Carry a foot on by a tick."""
        clock, course, twist, dt, up, plane, wary = now
        if foot.search is not None and self._reflexes is not None:
            self._reflexes.go_on_searching(foot, foot.search, dt)
            return
        swing = foot.swing
        assert swing is not None
        due = foot.share * clock.period
        seconds = max(due, foot.slowest(self._min_swing))
        feels = foot.sense is not None
        if seconds > due:
            foot.overdue = True
        if swing.progress <= _LATEST_RETARGET:
            remaining = (1.0 - swing.progress) * seconds - dt
            if clock.gait.free is not None:
                x, y = clock.gait.free.footprint(index, foot.leg, course, twist, remaining)
            else:
                x, y = footprint(foot.leg, course, twist, remaining + 0.5 * sector.stance * clock.period)
            foot.target = Vec3(x, y, self._ground + plane.at(course, x, y))
            swing.retarget(Vec3(x, y, foot.target.z - _PRESS) if feels and not self._careful else foot.target)
            foot.doubt = self._doubt(foot, course, wary) if feels else None
        foot.move(swing.step(dt, seconds, up), dt)
        if foot.sense is not None and self._reflexes is not None:
            self._reflexes.feel(foot, swing, sector, foot.sense, dt)
        elif swing.progress >= 1.0:
            foot.plant(foot.target)

    def _doubt(self, foot: Foot, course: Pose, wary: float | None) -> Doubt | None:
        """Return what the ground has to prove to which a foot is carried; on its way back it has stood there."""
        if wary is not None and foot.leg.leads(wary - course.yaw) and math.cos(foot.way - wary) > 0.0:
            return BRINK
        return NEW_GROUND if self._leads(foot) else None

    def _leads(self, foot: Foot) -> bool:
        """Tell whether a foot is carried farther than all others stand, or are being carried: to new ground."""
        (x, y, _), stood = foot.target, foot.stood
        dx, dy = x - stood.x, y - stood.y
        along = x * dx + y * dy
        for other in self._feet:
            x, y, _ = other.target
            if x * dx + y * dy >= along and other is not foot:
                return False
        return True


def footprint(leg: Leg, course: Pose, twist: Twist, seconds: float) -> tuple[float, float]:
    """Return where a foot belongs whose coming stance has its middle in `seconds`, in odom, m."""
    return placed(advanced(course, twist, seconds), leg.rest_foot)
