"""What a loop in a process of its own records: into the mailbox, whence the driver's process writes it to a file.

Where that does not come after, what finds no room is counted, told at the end, and gone; the loop never waits.
"""

from collections.abc import Callable

from robotwalk.process.mailbox import Ring, packed, unpacked
from robotwalk.recorder import Recorder, Row
from robotwalk.tape import Concluded, Tape


class LogFeed:
    """Takes what `robotwalk.recorder.Recorder` would.

    Attributes:
        tape: what is put onto it is recorded.
    """

    def __init__(self, ring: Ring) -> None:
        self._ring = ring
        self.tape = Tape(self._put)

    def put(self, row: Row) -> None:
        """Take a tick's row."""
        self._put(row)
        self.tape.add(Concluded(row.joints))

    def _put(self, item: object) -> None:
        self._ring.put(packed(item))


def emptier(ring: Ring, recorder: Recorder | None) -> Callable[[], None]:
    """Return what takes all that is in the ring, for the recorder."""

    def empty() -> None:
        while (data := ring.take()) is not None:
            if recorder is not None:
                recorder.take(unpacked(data))
        if recorder is not None:
            recorder.dropped = ring.dropped

    return empty
