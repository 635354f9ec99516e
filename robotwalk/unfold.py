"""From wherever the joints were found to the seated posture, joint by joint, before any foot bears load."""

from collections.abc import Sequence

from robotwalk.swing import way_made

_SPEED = 0.8  # rad/s on average, of the joint with the longest way
_SHORTEST = 0.3  # s


class Unfold:
    """A minimum-jerk blend of all joints, arriving together."""

    def __init__(self, start: Sequence[float], end: Sequence[float]) -> None:
        self._start = tuple(start)
        self._end = tuple(end)
        longest = max(abs(b - a) for a, b in zip(start, end, strict=True))
        self._seconds = max(longest / _SPEED, _SHORTEST)
        self._elapsed = 0.0

    @property
    def done(self) -> bool:
        """Tell whether the joints have arrived."""
        return self._elapsed >= self._seconds

    def step(self, dt: float) -> list[float]:
        """Advance by `dt` s; return the joints' angles, rad."""
        self._elapsed += dt
        way = way_made(self._elapsed / self._seconds)
        return [a + way * (b - a) for a, b in zip(self._start, self._end, strict=True)]
