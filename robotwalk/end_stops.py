"""Joints that are driven towards the ends of their ranges by what no goal foresaw are held back by what is measured.

Goals stay off a joint's limits by more than a servo overshoots (see `robotwalk.reach`). But a position servo is a soft
spring: that of a leg stretched out, which the body drags or pushes farther, gives by what it bears over its stiffness,
and nobody knows beforehand what that will be. So from where goals end a servo is made stiffer, by what is measured: a
wall, and a damper before it. Both push inwards only.
"""

import math
from collections.abc import Collection, Sequence

from robotwalk.reach import spare
from robotwalk.types import DriveResponse, JointState

_STIFFEST = 3.0  # rad that a goal yields per rad that the joint is past its wall, or soon will be
_PACE = 0.5  # rad a tick, at which a joint at its wall may swing: faster, what was measured acts too late
_DELAY = 1.5  # ticks, from what is measured to when it acts
_DAMPED = 0.015  # s of the way ahead, past that
_MOST = math.radians(20.0)  # that a goal yields; by then most servos give all they have


class EndStops:
    """Between what joints are sent to and the gate."""

    def __init__(self, limits: Sequence[tuple[float, float]], drives: Sequence[DriveResponse], dt: float) -> None:
        """Take each joint's lower and upper limit, rad, and its drive; goals are sent every `dt` s."""
        self._ahead = _DELAY * dt + _DAMPED
        fastest = _PACE / dt  # rad/s; a drive that is stiffer by a gain k swings at sqrt((1 + k) / inertia)
        self._gains = tuple([min(max(fastest * fastest * drive.inertia - 1.0, 0.0), _STIFFEST) for drive in drives])
        self._places = tuple([(low + spare(low, high), high - spare(low, high)) for low, high in limits])
        self._walls = list(self._places)
        self._moved: set[int] = set()  # joints whose walls are farther out

    def reset(self, positions: Sequence[float]) -> None:
        """Take over joints that hold their places, rad."""
        self._walls = list(self._places)
        self._moved.clear()
        self._find(range(len(positions)), positions)

    def _find(self, found: Collection[int], positions: Sequence[float]) -> None:
        """Move the walls of joints out to where the joints were found: none is to leap as its torque comes on."""
        for index in found:
            (low, high), here = self._places[index], positions[index]
            if not low <= here <= high:
                self._walls[index] = min(low, here), max(high, here)
                self._moved.add(index)

    def _follow(self, positions: Sequence[float]) -> None:
        """Let these walls follow the joints as they come in, to where they belong."""
        for index in tuple(self._moved):
            (low, high), (lowest, highest), here = self._places[index], self._walls[index], positions[index]
            self._walls[index] = min(max(lowest, here), low), max(min(highest, here), high)
            if self._walls[index] == (low, high):
                self._moved.discard(index)

    def step(self, goals: Sequence[float], joints: JointState, reseeded: Collection[int]) -> Sequence[float]:
        """Return the goals, rad: farther inwards where a joint is driven to the end of its range.

        Args:
            goals: rad, in joint order.
            joints: as measured.
            reseeded: joints that were just sent to where they are.
        """
        if reseeded:
            self._find(reseeded, joints.position)
        if self._moved:
            self._follow(joints.position)
        after: list[float] | None = None
        ahead = self._ahead
        for index, (here, speed, (low, high)) in enumerate(zip(
            joints.position, joints.velocity, self._walls, strict=True,
        )):
            soon = here + ahead * speed
            if low <= here <= high and low <= soon <= high:
                continue
            # Out there, what swings back is not slowed down.
            past = min(here, soon) - low if min(here, soon) < low else max(here, soon) - high
            if joints.valid[index]:
                if after is None:
                    after = list(goals)
                after[index] -= min(max(self._gains[index] * past, -_MOST), _MOST)
        return goals if after is None else after
