"""Who is asked for feedback, and in what order: a silent servo must not cost the others their samples.

In one reply of many, a silent servo may silence all behind it, and costs the wait for what does not come. So those
that fell silent are asked last and less and less often: after 1, 1, 2, 4, 8, 16, then every 20 ticks. Only the first
that is missing can be blamed. Those behind it may not have had their turn, and are asked first in the next tick.
"""

from collections.abc import Collection, Sequence

_LONGEST_WAIT = 20  # ticks


class RollCall:
    """Keeps the order for one group of servos."""

    def __init__(self, ids: Sequence[int]) -> None:
        self._ids = tuple(ids)
        self._tick = self._question = 0
        self._asked = dict.fromkeys(ids, 0)  # in which tick
        self._turn = dict.fromkeys(ids, 0)  # by which question
        self._misses = dict.fromkeys(ids, 0)  # in a row, of those that can be blamed for them
        self._unheard: set[int] = set()  # behind somebody silent
        self._steady = True  # all were asked at once, and all answered

    def next(self) -> Sequence[int]:
        """Begin a tick; return who is to be asked in it, in that order. It is never nobody."""
        self._tick += 1
        if self._steady:
            return self._ids
        speaking = [servo_id for servo_id in self._ids if not self._misses[servo_id]]
        speaking.sort(key=lambda servo_id: (servo_id not in self._unheard, self._turn[servo_id]))
        silent = [servo_id for servo_id in self._ids if self._misses[servo_id] and self._due(servo_id) <= self._tick]
        return speaking + silent or [min(self._ids, key=self._due)]

    def is_silent(self, servo_id: int) -> bool:
        """Tell whether a servo owes an answer: one wait is all that a tick can spare for such."""
        return self._misses[servo_id] > 0

    def note(self, asked: Sequence[int], heard: Collection[int]) -> None:
        """Take note of who answered of those who were asked at once."""
        if self._steady and len(asked) == len(heard) == len(self._ids):
            return
        self._steady = False
        blamed = False
        self._question += 1
        for servo_id in asked:
            self._asked[servo_id], self._turn[servo_id] = self._tick, self._question
            self._unheard.discard(servo_id)
            if servo_id in heard:
                self._misses[servo_id] = 0
            elif not blamed:
                blamed = True
                self._misses[servo_id] += 1
            elif not self._misses[servo_id]:
                self._unheard.add(servo_id)

        if not self._unheard and len(asked) == len(heard) == len(self._ids):
            self._steady = True

    def _due(self, servo_id: int) -> int:
        """Return the tick from which on a silent servo is asked again."""
        misses = min(self._misses[servo_id], 8)
        return self._asked[servo_id] + min(1 << max(misses - 2, 0), _LONGEST_WAIT)
