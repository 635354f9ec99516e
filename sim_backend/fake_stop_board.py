"""A fake board with a stop button: what a person does to it, a fault of the script does.

Its encoder is written from docs/foot-switches.md, as the fake foot switches' is. Not modelled: bounce.
"""

from typing import NamedTuple

from sim_backend.talker import Talker

_RATE_HZ = 100.0


class SimulatedStopBoard(NamedTuple):
    """The board to be made."""

    baud: int
    place: int  # the input that the button is on
    normally_closed: bool


class FakeStopBoard(Talker):
    """What hangs on the far end of its line.

    Attributes:
        pressed: whether somebody presses the button.
    """

    def __init__(self, kind: SimulatedStopBoard) -> None:
        super().__init__(_RATE_HZ)
        self._kind = kind
        self.pressed = False

    def report(self) -> bytes:
        """Return which inputs are closed: no other than the button's."""
        word = 2 ** self._kind.place if self.pressed is not self._kind.normally_closed else 0
        said = bytes([0x46, 0x53, word % 256, word // 256])
        return said + bytes([sum(said) % 256])
