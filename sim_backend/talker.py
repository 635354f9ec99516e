"""A device that talks unasked, again and again."""

from abc import ABC, abstractmethod

from sim_backend.reply import Reply
from sim_backend.simulated_clock import SimulatedClock
from sim_backend.wire import SimulatedPort

_NS = 1_000_000_000


class Talker(ABC):
    """What hangs on the far end of its line; a `Device` that hears nothing."""

    def __init__(self, rate_hz: float) -> None:
        self._period = _NS / rate_hz

    def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
        """Hear nothing."""
        return []

    def begin(self, clock: SimulatedClock, port: SimulatedPort, when: float) -> None:
        """Begin to talk, `when` of a period (0 to 1) from now."""
        first = clock.now() + when * self._period
        count = 0

        def report() -> None:
            nonlocal count
            port.volunteer(self.report())
            count += 1
            clock.schedule(round(first + count * self._period), report)

        clock.schedule(round(first), report)

    @abstractmethod
    def report(self) -> bytes:
        """Return what to say now."""
