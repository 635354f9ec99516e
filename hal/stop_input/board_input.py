"""A stop button on an input of a board that talks unasked, in the frames of a foot-switch board: `StopInput`."""

from hal.foot_switches.frame import FRAMING, decode
from hal.unasked_line import UnaskedLine
from robotwalk.ports import BytePort, Clock

_NS = 1_000_000_000


class BoardInput:
    """One input of the board; what is on the others does not matter."""

    def __init__(
        self, port: BytePort, clock: Clock, place: int, *, normally_closed: bool, stale_after: float
    ) -> None:
        """Listen on an opened port; the board has `stale_after` (s) from now on to be heard."""
        self._line = UnaskedLine(port, clock, FRAMING)
        self._clock = clock
        self._place, self._runs_closed = place, normally_closed
        self._patience = round(stale_after * _NS)
        self._heard_at = clock.now()
        self._closed = normally_closed

    def read(self) -> str | None:
        """Take what has come. A board that is silent, or whose port is gone, says stop."""
        frames = self._line.take()
        self._line.heard(len(frames))
        now = self._clock.now()
        if frames:
            self._heard_at, self._closed = now, bool(decode(frames[-1]) >> self._place & 1)
        if now - self._heard_at > self._patience:
            return self._line.statistics().failure or "its board is silent"
        if self._closed is self._runs_closed:
            return None
        return f"its input {self._place} is {'closed' if self._closed else 'open'}"

    def close(self) -> None:
        """Give the port back. Never raises."""
        self._line.close()
