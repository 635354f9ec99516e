"""Joints that do not go where they are sent, though their servos answer and pull: something holds them fast.

A joint that moves is not stuck, however far it is behind. One that does not is stuck only if a slow joint, sent the
same way, had gone to and fro meanwhile. Goals themselves do not tell that: they lead by far more than a joint can
follow (see `robotwalk.feedforward`), and by what it bears while it stands still.
"""

import math
from collections.abc import Sequence

from robotwalk.types import DriveResponse, JointState

_MOVED = 0.05  # rad, more than what holds a joint fast gives
_SENT = 0.2  # rad that a slow joint must have gone, to count as sent
_TRIPS = 2  # there and back
_STILL = 0.3  # s that it does not move after that either
_PACE = 0.5  # of its speed without load that a slow joint reaches
_UNSEEN = 0.1  # s without an answer after which a joint may have been anywhere


class StuckJoints:
    """Looks at goals and positions of one robot's joints, all of them in every tick: in between they go to and fro."""

    def __init__(self, drives: Sequence[DriveResponse], dt: float, *, load: bool = True) -> None:
        """Look at joints that follow like these `drives`, every `dt` s; `load`: their goals lead by what they bear."""
        self._count = len(drives)
        self._slowness = tuple([  # share of its way that a slow joint goes in a tick, and the most, rad; its stiffness
            (dt / (dt + drive.damping + math.sqrt(drive.inertia)), _PACE * drive.max_speed * dt,
             drive.stiffness if load else math.inf) for drive in drives])
        self._still = round(_STILL / dt)
        self._began = False

    def reset(self) -> None:
        """Begin anew: what follows has nothing to do with what was."""
        self._began = False

    def _begin(self, positions: Sequence[float]) -> None:
        self._began = True
        self._anchor = list(positions)  # where each was when it last moved
        self._slow = list(positions)  # where a slow joint would be
        self._low, self._high = list(positions), list(positions)  # it was at, since the joint moved and it turned
        self._way = [0] * self._count  # that it goes, 1 or -1; 0: it has not gone far since the joint moved
        self._trips = [0] * self._count  # of the slow one since then, there or back
        self._rested = [0] * self._count  # ticks since it was back

    def step(self, goals: Sequence[float], torques: Sequence[float], joints: JointState) -> tuple[int, ...]:
        """Look at all joints; return those that are stuck.

        Args:
            goals: that were sent last, rad.
            torques: that they lead for, N m.
            joints: as measured.
        """
        if not self._began:
            self._begin(joints.position)
        anchor, slow, low, high = self._anchor, self._slow, self._low, self._high
        way, trips, rested = self._way, self._trips, self._rested
        stuck: list[int] = []
        rows = zip(
            goals, torques, joints.position, joints.age, self._slowness, anchor, slow, low, high, way, strict=True)
        for slot, (goal, torque, here, age, slowness, there, last, lowest, highest, goes) in enumerate(rows):
            share, most, stiffness = slowness
            ahead = share * (goal - torque / stiffness - last)
            now = slow[slot] = last + (most if ahead > most else -most if ahead < -most else ahead)
            if age > _UNSEEN or not -_MOVED < here - there < _MOVED:
                anchor[slot], low[slot], high[slot], way[slot], trips[slot], rested[slot] = here, now, now, 0, 0, 0
                continue
            if now > highest:
                high[slot] = highest = now
            elif now < lowest:
                low[slot] = lowest = now
            if goes <= 0 and now - lowest > _SENT:
                way[slot], high[slot] = 1, now
                trips[slot] += 1
            elif goes >= 0 and highest - now > _SENT:
                way[slot], low[slot] = -1, now
                trips[slot] += 1
            if trips[slot] >= _TRIPS:
                rested[slot] += 1
                if rested[slot] > self._still:
                    stuck.append(slot)
        return tuple(stuck)
