"""Wall time. Simulated time lives where it is made, in `sim_backend.simulated_clock`."""

import select
import time
from collections.abc import Sequence

from robotwalk.ports import BytePort

_NS = 1_000_000_000


class WallClock:
    """The monotonic clock, which no time server and nobody's hand can set back."""

    def now(self) -> int:
        """Return the monotonic time, ns."""
        return time.monotonic_ns()

    def wait(self, ports: Sequence[BytePort], deadline: int) -> None:
        """Return once a port has bytes to read or `deadline` has come; sleep meanwhile."""
        left = deadline - self.now()
        if left <= 0:
            return
        if ports:
            # select() counts in microseconds; poll() would round up to whole milliseconds.
            select.select([port.fileno() for port in ports], [], [], left / _NS)
        else:
            time.sleep(left / _NS)


class Grid:
    """Absolute deadlines on whole multiples of the period: a late tick delays none of those after it.

    A tick that overran skips the grid points that it missed, and they are counted; ticks never bunch up.
    """

    def __init__(self, rate_hz: int, after: int) -> None:
        """Begin with the first grid point later than `after` (ns)."""
        self._rate = rate_hz
        self._index = after * rate_hz // _NS + 1
        self.missed = 0

    @property
    def deadline(self) -> int:
        """The time of the next tick, ns. Rounded from the exact grid, so that errors do not add up."""
        return self._index * _NS // self._rate

    def resume(self, now: int) -> None:
        """Go on behind `now`, after a time in which no tick was due: nothing was missed."""
        self._index = now * self._rate // _NS + 1

    def advance(self, now: int) -> None:
        """Go on to the next grid point that is not yet past."""
        self._index += 1
        while self.deadline < now:
            self._index += 1
            self.missed += 1
