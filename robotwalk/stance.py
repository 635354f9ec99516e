"""The feet that stand: how long each can wait for its turn, and what that allows the body to do.

A standing foot falls behind its rest position as the body goes on. What may stretch it too far before it lifts off
slows the body down; with that, a change of gait, a turn back or a foot that is late never over-stretches a leg.
"""

import math
from collections.abc import Iterable, Sequence

from robotwalk.carriage import MOST_ROOM, USUAL_ROOM
from robotwalk.foot import Foot
from robotwalk.free_stepping import passing
from robotwalk.gait import Gait, GaitClock, Sector
from robotwalk.types import Pose, Twist

_LATEST_LIFTOFF = 0.6  # of a sector; a foot held back for longer sits this swing out
_SEARCH = 0.2  # s that a search takes, about
_HINDERING = 0.05  # of the twist; a foot that bears less until its turn holds the body fast, and steps out of it


class Stance:
    """Of one robot's feet.

    Attributes:
        room: share of its largest stride that a foot may be from rest, as the body is carried.
    """

    def __init__(self, feet: Sequence[Foot], min_swing: float) -> None:
        """Look at feet that a swing of `min_swing` s or more carries over."""
        self._feet = feet
        self._min_swing = min_swing
        self.room = MOST_ROOM

    def entry(self, clock: GaitClock, gait: Gait, course: Pose, twist: Twist) -> tuple[float, float]:
        """Return at which share of the twist, 0 to 1, the standing feet could wait for their turns in another gait.

        Second comes the phase from which to go on in it.
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
        return self._bearable(gait, self._waits(gait, phase, clock.period, course, twist), course, twist), phase

    def bearable(self, clock: GaitClock, course: Pose, twist: Twist) -> float:
        """Return the share of a twist, 0 to 1, at which no standing foot is over-stretched before its turn.

        In a steady gait that is 1. It is less while a foot waits longer than its stride allows: after a change
        of gait, or when the body turns back on its way.
        """
        return self._bearable(
            clock.gait, self._waits(clock.gait, clock.phase, clock.period, course, twist), course, twist)

    def _waits(self, gait: Gait, phase: float, period: float, course: Pose, twist: Twist) -> list[float]:
        """Return how long each foot would have to wait for its lift-off, or one that searches for ground, s."""
        if gait.free is not None:
            return gait.free.waits(self._feet, course, twist, self.swing_time(gait, period))
        late = max([self._lateness(foot, phase, period) for foot in self._feet if foot.overdue], default=0.0)
        in_air = {index for index, foot in enumerate(self._feet) if foot.sector is not None} if late > 0.0 else set()
        waits: list[float] = []
        for index, foot in enumerate(self._feet):
            if foot.sector is not None:
                waits.append(_SEARCH if foot.search is not None else 0.0)
            elif due(foot, gait.sector_at(index, phase), phase) is None:
                waits.append(gait.until_lift_off(index, phase) * period + late)
            else:  # which is no use while those are late with whom it cannot be in the air
                waits.append(late if late > 0.0 and not gait.lifts_together(in_air | {index}) else 0.0)
        return waits

    def _lateness(self, foot: Foot, phase: float, period: float) -> float:
        """Return for how long the needle will have to wait for a foot that is overdue, s, as far as that is known."""
        if foot.sector is None:
            return 0.0
        if foot.search is not None or foot.swing is None:
            return _SEARCH
        seconds = max(foot.share * period, foot.slowest(self._min_swing))
        turns = (foot.sector.start + foot.sector.length - phase) % 1.0
        return max((1.0 - foot.swing.progress) * seconds - turns * period, 0.0)

    def swing_time(self, gait: Gait, period: float) -> float:
        """Return how long a swing of a gait takes, s."""
        return max(gait.feet[0][0].length * period, self._min_swing)

    def _bearable(self, gait: Gait, waits: Sequence[float], course: Pose, twist: Twist) -> float:
        share = 1.0
        # A body that shifts chases its aim while the course goes on: the less feet may stretch, the sooner it is there.
        strict = gait.free is not None or gait.balance is not None
        for foot, wait in zip(self._feet, waits, strict=True):
            foot.hindering = False
            if foot.sector is not None and foot.search is None:
                continue
            (dx, dy), (ux, uy) = foot.offset(course), passing(foot.leg, twist)
            # Farther where it may stand where it found ground, or wait for others that look for it.
            usual = USUAL_ROOM if foot.sense is None or strict else MOST_ROOM
            limit = min(usual, self.room) * foot.leg.max_stride
            wx, wy = ux * wait, uy * wait
            if (dx - wx) ** 2 + (dy - wy) ** 2 > limit * limit:
                # The share s at which |d - s w| meets the limit; going back towards rest is always allowed.
                along = dx * wx + dy * wy
                way = wx * wx + wy * wy
                inside = along * along - way * (dx * dx + dy * dy - limit * limit)
                bears = max((along + math.sqrt(inside)) / way, 0.0) if inside > 0.0 else 0.0
                foot.hindering = foot.sense is not None and way > 0.0 and bears < _HINDERING
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
                if due(foot, clock.gait.sector_at(index, clock.phase), clock.phase) is not None:
                    return 0.0
                turns = min(turns, clock.gait.until_lift_off(index, clock.phase))
        return turns * clock.period

    def settled(self, course: Pose, *, anywhere: bool = False) -> bool:
        """Tell whether all feet stand at rest below the body, or `anywhere`."""
        return all(foot.sector is None and (anywhere or foot.at_rest(course)) for foot in self._feet)


def due(foot: Foot, sector: Sector | None, phase: float) -> Sector | None:
    """Return the sector in which the needle is on a standing foot's circle, if it may lift off: it was not yet used."""
    if sector is None or sector is foot.spent or sector.progress(phase) > _LATEST_LIFTOFF:
        return None
    return sector
