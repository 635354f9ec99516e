"""Where the feet are: planted in the world until the needle lifts them, then on their way to a footprint.

A planted foot stands still in odom while the body moves over it. A footprint is the foot's rest position
under the body as it will be at the middle of the coming stance (PPS section 3, figure 3), found anew in each
tick until late in the swing.
"""

import math
from collections.abc import Iterable, Sequence
from random import Random
from typing import NamedTuple

from robotwalk.barriers import GivingUp
from robotwalk.body import advanced, placed
from robotwalk.carriage import MOST_ROOM, USUAL_ROOM
from robotwalk.contact import Sense
from robotwalk.foot import Foot
from robotwalk.free_stepping import FreeStepping, passing
from robotwalk.gait import Gait, GaitClock, Sector
from robotwalk.load_sharing import LoadSharing
from robotwalk.model import ContactSettings, Leg, RobotModel
from robotwalk.orientation import GroundPlane
from robotwalk.plumb import Turn
from robotwalk.search import Phase, Search
from robotwalk.statics import GRAVITY
from robotwalk.swing import Swing
from robotwalk.types import STILL, UP, Pose, Twist, Vec3

_LATEST_LIFTOFF = 0.6  # of a sector; a foot held back for longer sits this swing out
_LATEST_RETARGET = 0.5  # of a swing
_NEARLY_OVER = 0.97  # of a sector, at which the needle waits for a swing that goes on
_COMING_DOWN = 0.5  # of a swing, from where on a load is a touchdown
_AS_EXPECTED = 8e-3  # m; a foot struck this near the ground that was expected goes on to it
_AS_FELT = 3e-3  # m; ground this near to where it was expected is there
_PRESS = 2e-3  # m below it that a foot is sent, to feel it
_BUMP_UNTIL = 0.85  # of a swing; later it is the ground
_BUMP = 0.1  # of the weight, that pushes a foot back on its way: it is struck
_STEEP = 0.7  # of a load; pushed back by more than this, a foot would slip off what it struck
_LOST = 0.12  # of the weight, that a foot should bear of which nothing is felt: it has lost its ground
_LOST_FOR = 0.12  # s of that; loads pass from foot to foot in less
_SEARCH = 0.2  # s that a search takes, about
_HINDERING = 0.05  # of the twist; a foot that bears less until its turn holds the body fast, and steps out of it
_PROVEN = 0.1  # s that a foot must have been felt to stand; others lift off before only as long as it does
_STRUCK_FOR = 0.025  # s; gears with backlash jolt, too, but not for long
_BUMPS = 3  # in one swing, after which the foot stands where it is
_HIGHER = 0.02  # m that each of them adds to the lift
_CALMING = 0.9  # of that stays after each step without a surprise
_BACK = 0.03  # m that a foot draws back when it is struck; more than it lags behind as it sets off again
_LEAST_WAY = 0.01  # m; a shorter step has no way along which a foot could be held back
_DRAWN_BACK = 0.25  # of a swing, in which it rises more than it goes ahead; by then it has drawn back


class Footfalls(NamedTuple):
    """All feet at one moment, in the order of the robot's legs."""

    centres: tuple[Vec3, ...]  # in odom, m
    planted: tuple[bool, ...]
    footprints: tuple[tuple[float, float], ...]  # in odom, m: where each foot stands, or will be set down
    stood: tuple[Vec3, ...]  # in odom, m: where each foot stands, or stood last
    late: bool  # some foot's swing goes on past its turn, or its lift-off waits: the needle has to wait, too
    searching: bool  # a foot found none below it, and looks around or goes back
    giving_up: GivingUp | None  # a foot that found no ground at all, or is held back


FLAT = GroundPlane()


class Stepping:
    """Steps the feet under a moving body, by the needle of a gait clock."""

    def __init__(self, model: RobotModel, course: Pose) -> None:
        self._ground = model.foot_radius
        self._min_swing = model.motion.min_swing
        self._contact = model.contact
        self._weight = model.mass * GRAVITY
        self._caution = 0.0  # m added to the lift of every foot where the ground has surprised
        self._random = Random(0)
        self._phase = 0.0  # of the needle
        shares = model.contact is not None and model.contact.share_load
        self._sharing = LoadSharing(self._weight, len(model.legs)) if shares else None
        self._senses: Sequence[Sense | None] = (None,) * len(model.legs)
        self._plane = GroundPlane()
        self.room = MOST_ROOM  # share of its largest stride that a foot may be from rest, as the body is carried
        self._feet = [Foot(leg) for leg in model.legs]
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
                    (dx, dy), (ux, uy) = foot.offset(course), passing(foot.leg, twist)
                    stretch = max(stretch, math.hypot(dx - ux * wait, dy - uy * wait))
            return stretch

        phase = min(candidates, key=longest_stretch)
        share = self._bearable(gait, self._waits(gait, phase, clock.period, course, twist), course, twist)
        if share >= 1.0:
            clock.change(gait, phase)
        return share

    def bearable(self, clock: GaitClock, course: Pose, twist: Twist) -> float:
        """Return the share of a twist, 0 to 1, at which no standing foot is over-stretched before its turn.

        In a steady gait that is 1. It is less while a foot waits longer than its stride allows: after a change
        of gait, or when the body turns back on its way.
        """
        return self._bearable(
            clock.gait, self._waits(clock.gait, clock.phase, clock.period, course, twist), course, twist)

    def _waits(self, gait: Gait, phase: float, period: float, course: Pose, twist: Twist) -> list[float]:
        """Return how long each foot would have to wait for its lift-off, s."""
        if gait.free is not None:
            return gait.free.waits(self._feet, course, twist, self._swing_time(gait, period))
        late = max(self._lateness(foot, phase, period) for foot in self._feet)
        return [
            0.0 if self._due(foot, index, gait, phase) is not None
            else gait.until_lift_off(index, phase) * period + late for index, foot in enumerate(self._feet)]

    def _lateness(self, foot: Foot, phase: float, period: float) -> float:
        """Return for how long the needle will have to wait for a foot in the air, s, as far as that is known."""
        if foot.sector is None or not foot.overdue:
            return 0.0
        if foot.search is not None or foot.swing is None:
            return _SEARCH
        seconds = max(foot.share * period, foot.slowest(self._min_swing))
        turns = (foot.sector.start + foot.sector.length - phase) % 1.0
        return max((1.0 - foot.swing.progress) * seconds - turns * period, 0.0)

    def _swing_time(self, gait: Gait, period: float) -> float:
        return max(gait.feet[0][0].length * period, self._min_swing)

    def _bearable(self, gait: Gait, waits: Sequence[float], course: Pose, twist: Twist) -> float:
        share = 1.0
        # A body that shifts chases its aim while the course goes on: the less feet may stretch, the sooner it is there.
        strict = gait.free is not None or gait.balance is not None
        for foot, wait, sense in zip(self._feet, waits, self._senses, strict=True):
            foot.hindering = False
            if foot.sector is not None:
                continue
            (dx, dy), (ux, uy) = foot.offset(course), passing(foot.leg, twist)
            # Farther where it may stand where it found ground, or wait for others that look for it.
            usual = USUAL_ROOM if sense is None or strict else MOST_ROOM
            limit = min(usual, self.room) * foot.leg.max_stride
            wx, wy = ux * wait, uy * wait
            if (dx - wx) ** 2 + (dy - wy) ** 2 > limit * limit:
                # The share s at which |d - s w| meets the limit; going back towards rest is always allowed.
                along = dx * wx + dy * wy
                way = wx * wx + wy * wy
                inside = along * along - way * (dx * dx + dy * dy - limit * limit)
                bears = max((along + math.sqrt(inside)) / way, 0.0) if inside > 0.0 else 0.0
                foot.hindering = sense is not None and way > 0.0 and bears < _HINDERING
                share = min(share, bears)
        return share

    def within(self, room: float, course: Pose) -> bool:
        """Tell whether all standing feet are so near to rest, in shares of their largest strides."""
        return room >= MOST_ROOM or all(
            foot.sector is not None or foot.displacement(course) <= room * foot.leg.max_stride for foot in self._feet)

    def fall_behind(self, feet: Iterable[int], course: Pose, twist: Twist) -> bool:
        """Tell whether a body that moves with `twist` leaves one of these feet, by their numbers, farther behind."""
        for index in feet:
            (dx, dy), (ux, uy) = self._feet[index].offset(course), passing(self._feet[index].leg, twist)
            if dx * ux + dy * uy < 0.0:
                return True
        return False

    def until_lift_off(self, clock: GaitClock) -> float:
        """Return the time until a foot's turn to lift off, s; 0 if one is due."""
        turns = 1.0
        for index, foot in enumerate(self._feet):
            if foot.sector is None:
                if self._due(foot, index, clock.gait, clock.phase) is not None:
                    return 0.0
                turns = min(turns, clock.gait.until_lift_off(index, clock.phase))
        return turns * clock.period

    def settled(self, course: Pose, *, anywhere: bool = False) -> bool:
        """Tell whether all feet stand at rest below the body, or `anywhere`."""
        return all(foot.sector is None and (anywhere or foot.at_rest(course)) for foot in self._feet)

    def step(
        self, clock: GaitClock, course: Pose, twist: Twist, dt: float, *, hold: bool = False, up: Vec3 = UP,
        senses: Sequence[Sense | None] | None = None, plane: GroundPlane = FLAT, loads: Sequence[float] = (),
    ) -> Footfalls:
        """Advance all feet by `dt` s, the body being at `course` and moving with `twist`; on `hold` none lifts off.

        Swings are in the plane of their direction and `up`, the body's up axis in odom. They end on the `plane`, or
        where `senses` tell of ground. A standing foot should bear its part of `loads`, N.
        """
        self._plane = plane
        self._phase = clock.phase
        self._senses = senses if senses is not None else (None,) * len(self._feet)
        loads = loads or (0.0,) * len(self._feet)
        for index, foot in enumerate(self._feet):
            sector = foot.sector
            if sector is not None:
                swung = foot.swing is not None
                self._move(index, foot, sector, clock, course, twist, dt, up)
                if foot.sector is None and swung:
                    foot.spent = clock.gait.sector_at(index, clock.phase)
            else:
                foot.settle(dt)
                self._keep_ground(foot, self._senses[index], clock.gait.feet[index][0], loads[index], dt)
        unsure = any(foot.lost_for > 0.0 and foot.borne_for < _PROVEN for foot in self._feet if foot.sector is None)
        hold = hold or unsure
        if self._sharing is not None:
            self._sharing.step(self._feet, self._senses, loads, dt)
        if clock.gait.free is not None:
            self._step_freely(clock.gait.free, clock, course, twist, dt, hold, up)
            return self.footfalls()
        # Landings come first: a foot that waited for one lifts off in the same tick.
        in_air = {index for index, foot in enumerate(self._feet) if foot.sector is not None}
        for index, foot in enumerate(self._feet):
            if foot.sector is not None:
                continue
            if foot.spent is not clock.gait.sector_at(index, clock.phase):
                foot.spent = None
            sector = self._due(foot, index, clock.gait, clock.phase)
            idle = twist == STILL and foot.at_rest(course)
            if sector is None or idle or hold or not clock.gait.lifts_together(in_air | {index}):
                continue
            if self._sharing is not None and not self._sharing.lets_go(foot, self._feet, self._senses, loads, dt):
                continue
            in_air.add(index)
            share = (1.0 - sector.progress(clock.phase)) * sector.length
            foot.lift_off(sector, share, clock.gait.swing_path, foot.leg.lift + self._caution)
            self._move(index, foot, sector, clock, course, twist, dt, up)
        # A body that shifts is above its feet for the one whose turn it is, and for no other.
        if not hold and clock.gait.balance is None:
            self._relieve(clock, in_air)
        return self.footfalls()

    def _relieve(self, clock: GaitClock, in_air: set[int]) -> None:
        """Lift the feet off, out of their turn, that would be over-stretched until it comes; the needle waits."""
        for index, foot in enumerate(self._feet):
            if foot.sector is None and foot.hindering and clock.gait.lifts_together(in_air | {index}):
                in_air.add(index)
                sector = clock.gait.feet[index][0]
                foot.lift_off(sector, sector.length, clock.gait.swing_path, foot.leg.lift + self._caution)
                foot.overdue = True

    def _step_freely(
        self, free: FreeStepping, clock: GaitClock, course: Pose, twist: Twist, dt: float, hold: bool, up: Vec3
    ) -> None:
        """Lift the feet off that cannot stay where they are."""
        if hold:
            return
        for index in free.due(self._feet, course, twist, self._swing_time(clock.gait, clock.period)):
            foot, sector = self._feet[index], clock.gait.feet[index][0]
            foot.lift_off(sector, sector.length, clock.gait.swing_path, foot.leg.lift + self._caution)
            self._move(index, foot, sector, clock, course, twist, dt, up)

    def turn(self, turn: Turn) -> None:
        """Have all feet turned with odom."""
        for foot in self._feet:
            foot.turn(turn)

    def footfalls(self) -> Footfalls:
        """Return the feet as they are."""
        feet = self._feet
        searching = [foot.search for foot in feet if foot.search is not None]
        return Footfalls(
            tuple([foot.place for foot in feet]),
            tuple([foot.sector is None for foot in feet]),
            tuple([foot.target[:2] for foot in feet]),
            tuple([foot.stood for foot in feet]),
            any(self._is_late(foot) for foot in feet) or (self._sharing is not None and self._sharing.waiting),
            any(search.phase is not Phase.DOWN for search in searching),
            self._giving_up() if searching else None,
        )

    def _giving_up(self) -> GivingUp | None:
        for foot in self._feet:
            if foot.search is not None and (foot.bumps > _BUMPS or (foot.search.gave_up and foot.bumps == 0)):
                way = math.atan2(foot.target.y - foot.stood.y, foot.target.x - foot.stood.x)
                return GivingUp("obstacle" if foot.bumps else "edge", way)
        return None

    def _is_late(self, foot: Foot) -> bool:
        """Tell whether the needle has to wait for a foot: it looks for ground, or its swing outlasts its sector."""
        if foot.search is not None:
            return True
        return foot.overdue and foot.sector is not None and foot.sector.progress(self._phase) >= _NEARLY_OVER

    def _due(self, foot: Foot, index: int, gait: Gait, phase: float) -> Sector | None:
        """Return the sector in which a standing foot may lift off at a phase, if it is in one not yet used."""
        sector = gait.sector_at(index, phase)
        if sector is None or sector is foot.spent or sector.progress(phase) > _LATEST_LIFTOFF:
            return None
        return sector

    def _move(
        self, index: int, foot: Foot, sector: Sector, clock: GaitClock, course: Pose, twist: Twist, dt: float, up: Vec3
    ) -> None:
        """Carry a foot on by a tick."""
        sense = self._senses[index]
        contact = self._contact if sense is not None else None
        if foot.search is not None:
            self._go_on_searching(foot, foot.search, sense, dt)
            return
        swing = foot.swing
        assert swing is not None
        seconds = max(foot.share * clock.period, foot.slowest(self._min_swing))
        if contact is not None and seconds > foot.share * clock.period:
            foot.overdue = True
        if swing.progress <= _LATEST_RETARGET:
            remaining = (1.0 - swing.progress) * seconds - dt
            if clock.gait.free is not None:
                x, y = clock.gait.free.footprint(index, foot.leg, course, twist, remaining)
            else:
                x, y = footprint(foot.leg, course, twist, remaining + 0.5 * sector.stance * clock.period)
            foot.target = Vec3(x, y, self._ground + self._plane.at(course, x, y))
            swing.retarget(foot.target if contact is None else Vec3(x, y, foot.target.z - _PRESS))
        foot.move(swing.step(dt, seconds, up), dt)
        if contact is not None and sense is not None:
            self._feel(foot, swing, sector, sense, contact, dt)
        elif swing.progress >= 1.0:
            foot.plant(foot.target)

    def _feel(
        self, foot: Foot, swing: Swing, sector: Sector, sense: Sense, contact: ContactSettings, dt: float
    ) -> None:
        """React to what a swinging foot feels."""
        if swing.progress >= 1.0:
            if sense.touching or contact.reach_down == 0.0:
                foot.anchor(foot.target)
                self._caution *= _CALMING
            else:
                foot.overdue = True
                foot.search = Search(contact, foot.path, foot.leg.lift, foot.stood, foot.place, self._random)
            return
        if not foot.free:  # from what it stood on, or from what it was struck by: it lags behind as it draws back
            drawn_back = foot.bumps == 0 or swing.progress >= _DRAWN_BACK or not self._struck(foot, sense)
            foot.free = drawn_back and not sense.touching
            return
        above = sense.place.z - foot.target.z
        struck = (swing.progress <= _BUMP_UNTIL or above > _AS_EXPECTED) and self._struck(foot, sense)
        foot.struck_for = foot.struck_for + dt if struck else 0.0
        if contact.step_over and foot.struck_for > _STRUCK_FOR:
            self._step_over(foot, sector, sense, contact)
        elif (
            contact.early_touchdown and swing.progress >= _COMING_DOWN and sense.sure
            and above > _AS_EXPECTED
        ):
            self._be_surprised(above)
            foot.anchor(sense.place)

    def _keep_ground(self, foot: Foot, sense: Sense | None, sector: Sector, load: float, dt: float) -> None:
        """Have a standing foot feel for the ground again that it has lost."""
        contact = self._contact
        if sense is not None and sense.touching:
            foot.borne_for += dt
        if contact is None or sense is None or not contact.slip or sense.touching or load < _LOST * self._weight:
            foot.lost_for = 0.0
            return
        foot.lost_for += dt
        if foot.lost_for >= _LOST_FOR:
            foot.sector, foot.overdue = sector, True
            foot.search = Search(contact, foot.path, foot.leg.lift, foot.stood, foot.place, self._random)

    def _step_over(self, foot: Foot, sector: Sector, sense: Sense, contact: ContactSettings) -> None:
        """Draw a foot back from what it struck and carry it on higher; at last stand in front of it."""
        foot.bumps += 1
        foot.overdue = True
        self._be_surprised(contact.caution)
        if foot.bumps > _BUMPS:
            foot.draw_to(sense.place)
            foot.search = Search(contact, foot.path, foot.leg.lift, foot.stood, sense.place, self._random)
            return
        dx, dy = foot.target.x - foot.stood.x, foot.target.y - foot.stood.y
        back = _BACK / (math.hypot(dx, dy) or 1.0)
        foot.share = sector.length
        x, y, z = sense.place
        foot.rise(Vec3(x - back * dx, y - back * dy, z), foot.leg.lift + foot.bumps * _HIGHER)

    def _struck(self, foot: Foot, sense: Sense) -> bool:
        """Tell whether something holds a foot back on its way."""
        dx, dy = foot.target.x - foot.stood.x, foot.target.y - foot.stood.y
        way = math.hypot(dx, dy)
        back = -(sense.push.x * dx + sense.push.y * dy) / way if way > _LEAST_WAY else 0.0
        return back > max(_BUMP * self._weight, _STEEP * sense.push.z)

    def _go_on_searching(self, foot: Foot, search: Search, sense: Sense | None, dt: float) -> None:
        touching = sense is not None and search.feels and (sense.sure or (search.waits and sense.touching))
        foot.touched_for = foot.touched_for + dt if touching else 0.0
        if touching and foot.touched_for < search.sure_after:
            return  # keep still: ground stays, a jolt does not
        if sense is not None and touching:
            self._be_surprised(abs(foot.target.z - sense.place.z) - _AS_FELT)
            # A foot that feels straight down is where it is told to be; one that swings lags behind.
            if foot.swing is None:  # it stood, and stands again a little lower
                foot.anchor(search.place)
                return
            (x, y, _), (_, _, z) = search.place, foot.target
            off = sense.place.z - z
            foot.anchor(Vec3(x, y, z if abs(off) <= _AS_FELT else z + off))
            return
        foot.move(search.step(dt), dt)
        if search.done:
            foot.plant(foot.stood)
        elif foot.swing is None and search.phase is not Phase.DOWN:
            # It stood here, and here is nothing any more: it steps anew.
            assert foot.sector is not None
            foot.search, foot.share = None, foot.sector.length
            foot.rise(foot.place, foot.leg.lift + self._caution)

    def _be_surprised(self, by: float) -> None:
        most = self._contact.caution if self._contact is not None else 0.0
        self._caution = max(self._caution, min(by, most))


def footprint(leg: Leg, course: Pose, twist: Twist, seconds: float) -> tuple[float, float]:
    """Return where a foot belongs whose coming stance has its middle in `seconds`, in odom, m."""
    return placed(advanced(course, twist, seconds), leg.rest_foot)
