"""The file through which a loop is told what to do and heard, and where to find those of the loops that run.

It lies in memory: in $XDG_RUNTIME_DIR/robotwalk, or where there is none in /dev/shm, and belongs to one user. Both
processes hold a lock on it, so whose lock is gone is dead. Light to import: `robotwalk stop` must not wait.
"""

import fcntl
import mmap
import os
import struct
import tempfile
from collections.abc import Iterator
from enum import IntEnum
from pathlib import Path
from typing import NamedTuple

from robotwalk.errors import UsageError
from robotwalk.process.mailbox import Ring, Slot, Track

_SUFFIX = ".loop"
_TICKS = 128  # that a reader may fall behind
_HISTOGRAM = 8 * 821  # bytes; `robotwalk.timing.HISTOGRAM_SIZE`
# Bytes of each part. The log's pages are only used where a run is recorded.
_LAYOUT = {
    "about": 512, "stop": 64, "heed": 512, "command": 2048, "call": 1024, "driver": 64, "guardian": 64, "pulse": 64,
    "stop_input": 512, "answer": 65536, "status": 65536, "telemetry": _TICKS * 16384, "histograms": 3 * _HISTOGRAM,
    "log": 1 << 23}
_PULSE = struct.Struct("<QB")
_STOP = struct.Struct("<B")


class Stop(IntEnum):
    """What anybody may have a loop do."""

    HOLD = 1  # freeze at the measured positions, and stay so
    SIT = 2  # sit down, torque off
    LIMP = 3  # torque off now
    CLEAR = 4  # be held no more


class Pulse(NamedTuple):
    """The sign of a loop that it goes round."""

    time: int  # ns, monotonic
    armed: bool  # torque is on, or coming


class Mailbox:
    """All that is shared with one loop."""

    def __init__(self, descriptor: int) -> None:
        """Map an open file of the right size."""
        self._memory = memoryview(mmap.mmap(descriptor, sum(_LAYOUT.values())))
        places, begin = {}, 0
        for name, size in _LAYOUT.items():
            places[name] = self._memory[begin:begin + size]
            begin += size
        self.about = Slot(places["about"])
        self.stop = Slot(places["stop"])
        self.heed = Slot(places["heed"])  # the newest stop's number once the loop has heeded it, and what it did
        self.command = Slot(places["command"])
        self.call = Slot(places["call"])
        self.driver = Slot(places["driver"])  # its beat
        self.guardian = Slot(places["guardian"])
        self.stop_input = Slot(places["stop_input"])  # its newest reading
        self.answer = Slot(places["answer"])
        self.status = Slot(places["status"])
        self.telemetry = Track(places["telemetry"], _TICKS)
        self.histograms = tuple(places["histograms"][_HISTOGRAM * i:_HISTOGRAM * (i + 1)] for i in range(3))
        self.log = Ring(places["log"])
        self._pulse = Slot(places["pulse"])

    def beat(self, pulse: Pulse) -> None:
        """Show that the loop goes round."""
        self._pulse.write(_PULSE.pack(*pulse))

    @property
    def pulse(self) -> Pulse:
        """When the loop was last seen to go round."""
        message = self._pulse.read()
        if message is None:
            return Pulse(0, armed=False)
        time, armed = _PULSE.unpack(message.data)
        return Pulse(time, bool(armed))

    def post_stop(self, stop: Stop) -> int:
        """Have the loop stop; return the stop's number. Anybody may."""
        return self.stop.write(_STOP.pack(stop))

    def stop_after(self, number: int) -> tuple[int, Stop] | None:
        """Return the newest stop, if it came after the one of that number."""
        if self.stop.number == number:
            return None
        message = self.stop.read()
        return None if message is None else (message.number, Stop(*_STOP.unpack(message.data)))


def folder() -> Path:
    """Return the folder of the loops' files, made if it is not there.

    Raises:
        UsageError: it belongs to somebody else, or cannot be made.
    """
    own, memory = os.environ.get("XDG_RUNTIME_DIR"), Path("/dev/shm")
    if own and Path(own).is_dir():
        place = Path(own) / "robotwalk"
    else:
        place = (memory if memory.is_dir() else Path(tempfile.gettempdir())) / f"robotwalk-{os.getuid()}"
    try:
        place.mkdir(mode=0o700, exist_ok=True)
        about = place.stat()
    except OSError as error:
        raise UsageError(f"cannot make {place}: {error.strerror}") from error
    if about.st_uid != os.getuid() or about.st_mode & 0o077:
        raise UsageError(f"{place} should belong to you alone (mode 700)")
    return place


def create(robot: str) -> tuple[int, Path]:
    """Make the file of a new loop and lock it; return its descriptor and where it is.

    Raises:
        UsageError: it cannot be made.
    """
    place = folder()
    path = place / f"{robot}-{os.getpid()}{_SUFFIX}"
    try:
        descriptor, temporary = tempfile.mkstemp(dir=place, prefix=".")  # mode 600
        os.ftruncate(descriptor, sum(_LAYOUT.values()))
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        os.rename(temporary, path)
    except OSError as error:
        raise UsageError(f"cannot make {path}: {error.strerror}") from error
    return descriptor, path


def running() -> Iterator[tuple[str, Mailbox]]:
    """Yield the loops that run, each with its name; clear away the files of those that do not."""
    for path in sorted(folder().glob(f"*{_SUFFIX}")):
        descriptor = os.open(path, os.O_RDWR | os.O_CLOEXEC)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
            path.unlink(missing_ok=True)
        except BlockingIOError:
            yield path.name.removesuffix(_SUFFIX), Mailbox(descriptor)
        finally:
            os.close(descriptor)
