"""What sits between a wire and the host: when bytes that came over the wire reach the program that reads.

    none         an ideal converter: every reply is handed over as soon as it is whole
    ftdi16       FTDI's latency timer at its default: 62 bytes, or what has come 16 ms after the first of them
    ftdi1        the same at 1 ms
    cdc          full-speed USB: what has come by the next 1 ms frame
    uart-echo    a UART whose receiver is not gated: the host first reads back what it sent

Sources: FTDI AN232B-04 (packets of 64 bytes, two of them status; 16 ms); USB 2.0, 5.3.3 (frames).
"""

from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from typing import Literal, NamedTuple

AdapterName = Literal["none", "ftdi16", "ftdi1", "cdc", "uart-echo"]

_PACKET = 62  # bytes
_FRAME = 1_000_000  # ns
_BITS_PER_BYTE = 10  # 8N1
_NS = 1_000_000_000


class Burst(NamedTuple):
    """Bytes that follow each other on the wire without a pause."""

    begins: int  # ns
    baud: int
    data: bytes

    def through(self, count: int) -> int:
        """Return when the first `count` bytes are through, ns."""
        return self.begins - (-count * _BITS_PER_BYTE * _NS // self.baud)

    def arrived(self, now: int) -> int:
        """Return how many bytes are through at `now` ns."""
        return min(len(self.data), max(0, (now - self.begins) * self.baud // (_BITS_PER_BYTE * _NS)))


class Adapter:
    """An ideal converter: hands over each burst when it is whole. Who asks earlier gets the bytes that are there."""

    def __init__(self, *, echo: bool = False) -> None:
        """Make it; with `echo` the host also hears itself."""
        self.echo = echo
        self._bursts: deque[Burst] = deque()

    def expect(self, burst: Burst) -> None:
        """Note what is on its way to the host. Bursts come in the order of their times."""
        self._bursts.append(burst)

    def due(self) -> int | None:
        """Return when the host is next handed bytes, ns, if any are on their way."""
        return self._bursts[0].through(len(self._bursts[0].data)) if self._bursts else None

    def collect(self, now: int) -> bytes:
        """Return what the host can have at `now` ns and has not had yet."""
        return self._take(now)

    def _arrival(self, count: int) -> int | None:
        """Return when the host's side of the wire has `count` bytes, ns, if that many are on their way."""
        for burst in self._bursts:
            if count <= len(burst.data):
                return burst.through(count)
            count -= len(burst.data)
        return None

    def _take(self, now: int) -> bytes:
        """Remove the bytes that have arrived by `now`, and return them."""
        taken = []
        while self._bursts:
            burst = self._bursts[0]
            count = burst.arrived(now)
            taken.append(burst.data[:count])
            if count < len(burst.data):
                self._bursts[0] = Burst(burst.through(count), burst.baud, burst.data[count:])
                break
            self._bursts.popleft()
        return b"".join(taken)


class _Buffering(Adapter):
    """Holds bytes back until they are due."""

    def collect(self, now: int) -> bytes:
        """Return what was due by `now` ns."""
        due, taken = self.due(), b""
        while due is not None and due <= now:
            taken += self._take(due)
            due = self.due()
        return taken


class LatencyTimer(_Buffering):
    """FTDI's: a packet goes to the host when it is full, or a time after its first byte."""

    def __init__(self, latency: int) -> None:
        """Set the timer, in ns."""
        super().__init__()
        self._latency = latency

    def due(self) -> int | None:
        """Return when the packet is full or the time is over, ns, if bytes are on their way."""
        first, full = self._arrival(1), self._arrival(_PACKET)
        if first is None:
            return None
        return first + self._latency if full is None else min(full, first + self._latency)


class UsbFrames(_Buffering):
    """A CDC device's: the host asks once a frame. Frames begin at whole milliseconds of simulated time."""

    def due(self) -> int | None:
        """Return when the frame begins that takes the next byte, ns, if bytes are on their way."""
        first = self._arrival(1)
        return None if first is None else -(-first // _FRAME) * _FRAME


ADAPTERS: Mapping[AdapterName, Callable[[], Adapter]] = {
    "none": Adapter,
    "ftdi16": partial(LatencyTimer, 16_000_000),
    "ftdi1": partial(LatencyTimer, 1_000_000),
    "cdc": UsbFrames,
    "uart-echo": partial(Adapter, echo=True),
}
