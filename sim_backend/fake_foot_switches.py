"""A fake board of foot switches: it talks on a line of its own about the forces of MuJoCo's contacts.

Its encoder is written from docs/foot-switches.md and shares nothing with the decoder in `hal`. A switch closes at a
force and opens at half of it. Not modelled: bounce, dirt, a foot that presses its switch from the side only, and what
the board takes to debounce.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from sim_backend.talker import Talker

_OPENS = 0.5  # of the force at which it closes; assumed, as snap-action switches have a difference of about that


class SimulatedFootSwitches(NamedTuple):
    """The board to be made."""

    baud: int
    rate_hz: float
    inputs: tuple[int | None, ...]  # of the board, by leg; None: no switch
    closes_at: float  # N


class FakeFootSwitches(Talker):
    """What hangs on the far end of its line."""

    def __init__(self, kind: SimulatedFootSwitches, forces: Callable[[], Sequence[float]]) -> None:
        """Make it; `forces` tells how hard each foot is pressed now, N, by leg."""
        super().__init__(kind.rate_hz)
        self._kind = kind
        self._forces = forces
        self._closed = [False] * len(kind.inputs)

    def report(self) -> bytes:
        """Return which inputs are closed."""
        kind, word = self._kind, 0
        for leg, (force, place) in enumerate(zip(self._forces(), kind.inputs, strict=True)):
            self._closed[leg] = force > kind.closes_at * (_OPENS if self._closed[leg] else 1.0)
            if place is not None and self._closed[leg]:
                word += 2 ** place
        said = bytes([0x46, 0x53, word % 256, word // 256])
        return said + bytes([sum(said) % 256])
