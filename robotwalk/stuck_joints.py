"""Joints that do not go where they are sent, though their servos answer and pull: something holds them fast.

Looked at over whole windows: a joint whose goals went to and fro, and which itself hardly moved. One joint is sampled
in each tick, in turn.
"""

import math
from collections.abc import Sequence

_WINDOW = 0.8  # s
_SENT = 0.2  # rad that its goals must have covered for that to tell anything
_SHARE = 0.2  # of that; a joint that covered less is stuck
_AGREEING = 2  # windows in a row


class StuckJoints:
    """Looks at goals and positions of one robot's joints."""

    def __init__(self, count: int, dt: float) -> None:
        """Look at `count` joints, one every `dt` s."""
        self._count = count
        self._samples = max(round(_WINDOW / (count * dt)), 4)  # in a window
        self._next = 0
        self._taken = 0
        self._windows = [0] * count  # in a row, in which it was stuck
        self._begin()

    def _begin(self) -> None:
        self._lowest = [(math.inf, math.inf)] * self._count  # goal and position
        self._highest = [(-math.inf, -math.inf)] * self._count

    def step(self, goals: Sequence[float], positions: Sequence[float], valid: Sequence[bool]) -> tuple[int, ...]:
        """Look at the next joint; return those that are stuck, at the end of a window that shows it."""
        index = self._next
        if valid[index]:
            goal, here = goals[index], positions[index]
            (low_goal, low), (high_goal, high) = self._lowest[index], self._highest[index]
            self._lowest[index] = min(goal, low_goal), min(here, low)
            self._highest[index] = max(goal, high_goal), max(here, high)
        self._next = (index + 1) % self._count
        if self._next:
            return ()
        self._taken += 1
        if self._taken < self._samples:
            return ()
        self._taken = 0
        for slot, ((low_goal, low), (high_goal, high)) in enumerate(zip(self._lowest, self._highest, strict=True)):
            sent, went = high_goal - low_goal, high - low
            self._windows[slot] = self._windows[slot] + 1 if sent > _SENT and went < _SHARE * sent else 0
        self._begin()
        return tuple([slot for slot, windows in enumerate(self._windows) if windows >= _AGREEING])
