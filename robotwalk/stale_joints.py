"""Joints that do not answer: each coasts on its goals, then holds, then the robot sits.

    coast   a lost reply is no lost goal: the goals go on
    hold    it may be deaf: its goal is the one that was sent when it was last heard, and the robot comes to a stand
    sit     nobody knows where it is

Where no joint at all answers, none hears either: a wire is cut. Then the gait waits at once, or it would be strides
ahead of the legs by the time that they hear again.

Times are those of the robot's file (`safety: stale`). How a joint goes on afterwards: `robotwalk.reentry`.
"""

from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.agreement import Agreement
from robotwalk.config.safety import StaleConfig


class Staleness(NamedTuple):
    """What is to be done about it."""

    holding: tuple[int, ...]  # joints whose goals are to be held
    silent: tuple[int, ...]  # joints for which the robot should sit
    deaf: bool = False  # no joint hears what is wanted of it


_DEAF_AFTER = 0.045  # s without any answer: the fifth tick of a hundred a second; lost replies seldom are so many
NOBODY = Staleness((), ())
ALL_DEAF = Staleness((), (), deaf=True)


class StaleJoints:
    """Looks at the age of every joint's last answer."""

    def __init__(self, config: StaleConfig) -> None:
        self._hold_after, self._sit_after = config.hold_after_s, config.sit_after_s
        self._too_old = Agreement()

    def step(self, ages: Sequence[float]) -> Staleness:
        """Look at them, s, once a tick."""
        oldest = max(ages)
        # A computer that stalled for a second finds all of them too old, once.
        too_old = self._too_old.step(oldest > self._sit_after)
        deaf = oldest > _DEAF_AFTER and min(ages) > _DEAF_AFTER
        if oldest <= self._hold_after:
            return ALL_DEAF if deaf else NOBODY
        silent = tuple([index for index, age in enumerate(ages) if age > self._sit_after]) if too_old else ()
        held = [index for index, age in enumerate(ages) if age > self._hold_after and index not in silent]
        return Staleness(tuple(held), silent, deaf)
