"""Half-duplex serial wire in simulated time: bytes take their time at the baud rate.

Not modelled here: collisions (a host that talks into a reply), and the latency of an adapter.
"""

from collections import deque
from typing import Protocol

from sim_backend.dynamixel_device import Reply
from sim_backend.simulated_clock import SimulatedClock

_BITS_PER_BYTE = 10  # 8N1
_NS = 1_000_000_000


class Device(Protocol):
    """All that hangs on the far end of a wire."""

    def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
        """Take bytes, the last of which arrives at `now` ns; return what is answered."""
        ...


class SimulatedPort:
    """The host's end of the wire; a `robotwalk.ports.BytePort`.

    A reply wakes a waiting host when it is whole, as an adapter that gathers bytes does. A host that reads
    before that gets the bytes that have arrived by then.
    """

    def __init__(self, clock: SimulatedClock, device: Device, baud: int) -> None:
        self._clock = clock
        self.device = device
        self._baud = baud
        self._free_at = 0  # ns, when the last byte sent has left
        self._bursts: deque[tuple[int, bytes]] = deque()  # (ns at which the first byte begins, bytes)
        self._whole = 0  # bursts that have arrived whole

    def fileno(self) -> int:
        """Return -1: there is no descriptor."""
        return -1

    def write(self, data: bytes) -> None:
        """Send bytes; they reach the device as fast as the wire carries them."""
        arrives = max(self._clock.now(), self._free_at) + self._duration(len(data))
        self._free_at = arrives
        self._clock.schedule(arrives, lambda: self._deliver(data))

    def waiting(self) -> int:
        """Return how many bytes of whole bursts can be read."""
        return sum(len(self._bursts[index][1]) for index in range(self._whole)) if self._whole else 0

    def read(self) -> bytes:
        """Return the bytes that have arrived."""
        now, arrived = self._clock.now(), []
        while self._bursts:
            begins, data = self._bursts[0]
            count = min(len(data), max(0, (now - begins) * self._baud // (_BITS_PER_BYTE * _NS)))
            arrived.append(data[:count])
            if count < len(data):
                self._bursts[0] = (begins + self._duration(count), data[count:])
                break
            self._bursts.popleft()
            self._whole -= 1
        return b"".join(arrived)

    def close(self) -> None:
        """Do nothing: there is no port to give back."""

    def _duration(self, size: int) -> int:
        return -(-size * _BITS_PER_BYTE * _NS // self._baud)

    def _deliver(self, data: bytes) -> None:
        time = self._clock.now()
        for delay, reply in self.device.receive(data, time, self._baud):
            begins = time + delay
            time = begins + self._duration(len(reply))
            self._bursts.append((begins, reply))
            self._clock.schedule(time, self._note_whole)

    def _note_whole(self) -> None:
        self._whole += 1
