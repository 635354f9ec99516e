"""Joints that hold, or come back from silence, go on without a jump.

Whatever a joint is sent to is its target: its goal in the gait or, while it holds, the goal that was sent when it was
last heard. Where the target leaps, what it leaps by is added to it, and dies out with least jerk. A joint that is
back starts from where it was found, not from where it was sent in vain.
"""

from collections.abc import Collection, Sequence

from robotwalk.swing import way_made
from robotwalk.types import JointState

_SILENCE = 0.1  # s; after a shorter one a joint is about where its goal is
_FASTEST = 2.0  # rad/s on the way back
_PEAK = 1.875  # the largest speed of a least-jerk motion over its mean
_SHORTEST = 0.1  # s
_BEHIND = 0.1  # rad off its target


class _Blend:
    """What a joint is still off its target, and how it dies out."""

    __slots__ = ("_elapsed", "_off", "_seconds", "left")

    def __init__(self, off: float) -> None:
        self._off = self.left = off  # rad
        self._elapsed = 0.0
        self._seconds = max(_PEAK * abs(off) / _FASTEST, _SHORTEST)

    @property
    def done(self) -> bool:
        return self._elapsed >= self._seconds

    def step(self, dt: float) -> float:
        self.left = self._off * (1.0 - way_made(self._elapsed / self._seconds))
        self._elapsed += dt
        return self.left


class Reentry:
    """Between the goals of the gait and the gate."""

    def __init__(self) -> None:
        self.reset(())

    @property
    def behind(self) -> tuple[int, ...]:
        """The joints that are on their way, and far from their targets."""
        return tuple([index for index, blend in self._blends.items() if abs(blend.left) > _BEHIND])

    def reset(self, positions: Sequence[float]) -> None:
        """Start from joints that hold their places."""
        self._last: Sequence[float] = positions  # goals that are being written
        self._heard: Sequence[float] = positions  # those that were written when each joint was last heard
        self._silent: set[int] = set()
        self._held: dict[int, float] = {}
        self._blends: dict[int, _Blend] = {}

    def step(
        self, goals: Sequence[float], angles: Sequence[float], joints: JointState, holding: Collection[int],
        reseeded: Collection[int], dt: float,
    ) -> Sequence[float]:
        """Return the goals to go on with, in joint order, rad.

        Args:
            goals: of the gait, with what makes servos arrive where they should.
            angles: that the gait wants.
            joints: as measured.
            holding: joints that are to hold.
            reseeded: joints that were just sent to where they are.
            dt: s since the last step.
        """
        if all(joints.valid):
            self._heard = self._last
            if not (self._silent or self._held or self._blends or holding or reseeded):
                self._last = goals
                return goals
        else:
            self._heard = [
                last if valid else heard
                for last, heard, valid in zip(self._last, self._heard, joints.valid, strict=True)]
        self._silent |= {index for index, age in enumerate(joints.age) if age > _SILENCE}
        back = {index for index in self._silent if joints.valid[index]}
        self._silent -= back
        after = list(goals)
        for index in self._held.keys() | holding:
            self._hold(index, index in holding, goals)
            after[index] = self._held.get(index, goals[index])
        for index in back.union(reseeded):
            self._blends[index] = _Blend(joints.position[index] - angles[index])
        for index, blend in list(self._blends.items()):
            after[index] += blend.step(dt)
            if blend.done:
                del self._blends[index]
        self._last = after
        return after

    def _hold(self, index: int, holds: bool, goals: Sequence[float]) -> None:
        """Begin to hold a joint's goal, or let it go."""
        if holds and index not in self._held:
            self._held[index] = self._heard[index]
            self._blends[index] = _Blend(self._last[index] - self._held[index])
        elif not holds:
            del self._held[index]
            self._blends[index] = _Blend(self._last[index] - goals[index])
