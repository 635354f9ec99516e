"""The usual reply, known at one look: all answer in one piece, in order, and nobody reports anything.

Then the data of each servo lie where they always lie, and can be decoded all at once. Any other reply is taken apart
frame by frame.
"""

from collections.abc import Callable
from typing import NamedTuple

from hal.protocol import GroupReply, Status


class Outline(NamedTuple):
    """Where the data lie in a reply of blocks of one size."""

    lead: int  # bytes before the first block
    before: int  # bytes of a block before its data
    after: int  # and behind them


class WholeReply:
    """A `GroupReply` that leaves all but the usual to another.

    Attributes:
        outline: where the data lie in `whole`.
        whole: the reply, if it was the usual one.
    """

    def __init__(self, careful: GroupReply, outline: Outline, is_usual: Callable[[bytes], bool]) -> None:
        """Take what knows any reply, and what tells of bytes, as many as are expected, whether they are the usual."""
        self.outline = outline
        self.size, self.waits = careful.size, careful.waits
        self.whole: bytes | None = None
        self._careful, self._is_usual = careful, is_usual
        self._begun = False  # whether the other one has seen bytes

    @property
    def bad_frames(self) -> int:
        """How many frames, or answers in a joint frame, came garbled."""
        return self._careful.bad_frames

    def reset(self) -> None:
        """Forget what has come."""
        self.whole = None
        if self._begun:
            self._careful.reset()
            self._begun = False

    def feed(self, data: bytes) -> None:
        """Take the next bytes."""
        if not self._begun and self.whole is None and len(data) == self.size and self._is_usual(data):
            self.whole = data
        elif data:
            self._take_apart()
            self.whole = None
            self._careful.feed(data)

    @property
    def results(self) -> dict[int, Status | None]:
        """The statuses by id, in the order asked for; None until a good answer has come."""
        self._take_apart()
        return self._careful.results

    @property
    def complete(self) -> bool:
        """Whether nothing more will come."""
        return self.whole is not None or self._careful.complete

    def _take_apart(self) -> None:
        if not self._begun:
            self._begun = True
            if self.whole is not None:
                self._careful.feed(self.whole)
