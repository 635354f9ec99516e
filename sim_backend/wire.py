"""Half-duplex serial wire in simulated time: bytes take their time at the baud rate.

Not modelled here: collisions (a host that talks into a reply is heard, and so is the reply).
"""

from sim_backend.adapter import Adapter, Burst
from sim_backend.device import Device
from sim_backend.simulated_clock import SimulatedClock


class SimulatedPort:
    """The host's end of the wire; a `robotwalk.ports.BytePort`.

    Attributes:
        device: what hangs on the far end.
        baud: of what is sent from now on, and of the replies to it.
        cuts: in the line between host and servos; with any, neither hears the other.
    """

    def __init__(self, clock: SimulatedClock, device: Device, baud: int, adapter: Adapter | None = None) -> None:
        """Connect the host to a wire through an adapter, by default an ideal one."""
        self._clock = clock
        self.device = device
        self.baud = baud
        self.cuts = 0
        self._adapter = adapter or Adapter()
        self._sent_at = 0  # ns, when the last byte sent has left
        self._answered_at = 0  # ns, when the last byte of all answers so far is through
        self._due: int | None = None  # ns, when `_hand_over` runs next
        self._received = b""

    def fileno(self) -> int:
        """Return -1: there is no descriptor."""
        return -1

    def write(self, data: bytes) -> None:
        """Send bytes; they reach the device as fast as the wire carries them."""
        burst = Burst(max(self._clock.now(), self._sent_at), self.baud, data)
        self._sent_at = burst.through(len(data))
        if self._adapter.echo:
            self._expect(burst)
        self._clock.schedule(self._sent_at, lambda: self._deliver(burst))

    def waiting(self) -> int:
        """Return how many bytes the adapter has handed over that were not read."""
        return len(self._received)

    def read(self) -> bytes:
        """Return the bytes that the adapter lets the host have."""
        data = self._received + self._adapter.collect(self._clock.now())
        self._received = b""
        return data

    def close(self) -> None:
        """Do nothing: there is no port to give back."""

    def disturb(self, noise: bytes) -> None:
        """Put bytes onto the wire that nobody sent: behind what is being said, and all that follows waits."""
        burst = Burst(max(self._clock.now(), self._sent_at, self._answered_at), self.baud, noise)
        self._sent_at = self._answered_at = burst.through(len(noise))
        self._expect(burst)
        self._clock.schedule(self._sent_at, lambda: self._deliver(burst))

    def volunteer(self, data: bytes) -> None:
        """Have the far end send bytes that nobody asked for, behind what it is sending."""
        if not self.cuts:
            burst = Burst(max(self._clock.now(), self._answered_at), self.baud, data)
            self._answered_at = burst.through(len(data))
            self._expect(burst)

    def _deliver(self, burst: Burst) -> None:
        if self.cuts:
            return
        time = self._clock.now()
        for delay, reply in self.device.receive(burst.data, time, burst.baud):
            answer = Burst(max(time + delay, self._answered_at), burst.baud, reply)
            self._answered_at = time = answer.through(len(reply))
            self._expect(answer)

    def _expect(self, burst: Burst) -> None:
        self._adapter.expect(burst)
        self._schedule_hand_over()

    def _schedule_hand_over(self) -> None:
        due = self._adapter.due()
        if due is not None and (self._due is None or due < self._due):
            self._due = due
            self._clock.schedule(due, self._hand_over)

    def _hand_over(self) -> None:
        if self._due is None or self._due > self._clock.now():
            return  # an earlier one has taken its place
        self._received += self._adapter.collect(self._clock.now())
        self._due = None
        self._schedule_hand_over()
