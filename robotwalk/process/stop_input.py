"""A stop button, between the process that reads it and those that heed it.

It is read in a process of its own. The reading is a system call that may wait: an FTDI adapter is asked over USB, for
up to 5 s if it is stuck (Linux, drivers/usb/serial/ftdi_sio.c: ftdi_get_modem_status). The loop cannot wait for that,
and the command may be stopped or dead while the loop still moves the robot. That process outlives both, and ends when
both have; who heeds it takes its silence for a stop.
"""

import select
import struct
import time
from typing import NamedTuple

from robotwalk.agreement import Agreement
from robotwalk.ports import Clock, StopInput
from robotwalk.process.mailbox import Slot
from robotwalk.process.shared import Stop

LOOK = 0.005  # s between readings
_SILENT = 300_000_000  # ns without a reading
_TIME = struct.Struct("<Q")
_ROOM = 400  # bytes of a reason


class Settled:
    """A reading that bounces, until it has been the same for some time, in two readings or more."""

    def __init__(self, source: StopInput, settle: int) -> None:
        """Believe what `source` says for `settle` (ns); at first that nobody says stop."""
        self._source, self._settle = source, settle
        self._believed: str | None = None
        self._since: int | None = None  # when the source began to say otherwise

    def read(self, now: int) -> str | None:
        """Return why the robot is to stop, in words; None: it may move."""
        reading = self._source.read()
        if (reading is None) is (self._believed is None):
            self._since = None
        elif self._since is None:
            self._since = now
        elif now - self._since >= self._settle:
            self._since, self._believed = None, reading
        return self._believed


def serve(source: Settled, slot: Slot, clock: Clock, lease: int) -> None:
    """Show what a stop input says, until nobody holds the other end of the pipe `lease` any more."""
    while not select.select([lease], [], [], LOOK)[0]:
        reason = source.read(clock.now())
        slot.write(_TIME.pack(clock.now()) + (reason or "").encode()[:_ROOM])


class Heeded(NamedTuple):
    """What a stop input has the robot do."""

    stop: Stop
    reason: str  # in words, such as "told to stop by the stop input (its line DSR is off)"


class StopWatch:
    """Heeds a stop input that another process reads."""

    def __init__(self, slot: Slot, stop: Stop | None) -> None:
        """Take what it writes to; `stop` is what it is to do, None: there is none."""
        self._slot, self._stop = slot, stop
        self._silent = Agreement()  # after a stall of the whole computer the loop is often first to run

    def look(self) -> Heeded | None:
        """Return what it says now, if it says stop; look once a tick."""
        if self._stop is None:
            return None
        message = self._slot.read()
        at, reason = 0, ""
        if message is not None:
            (at,), reason = _TIME.unpack_from(message.data), message.data[_TIME.size:].decode(errors="replace")
        if self._silent.step(time.monotonic_ns() - at > _SILENT):
            reason = "nothing is heard of it"
        return Heeded(self._stop, f"told to stop by the stop input ({reason})") if reason else None
