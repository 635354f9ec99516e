"""A line on which a sensor talks unasked. It takes what has come, once a tick, and never waits."""

from hal.unasked_frames import FrameReceiver, Framing
from robotwalk.errors import BusError
from robotwalk.ports import BytePort, Clock
from robotwalk.types import SensorStatistics

_NS = 1_000_000_000
_PAUSE = 500_000_000  # ns; after a longer one nobody knows how old what has come is: a driver's buffer holds 4096 bytes


class UnaskedLine:
    """Listens on an opened port."""

    def __init__(self, port: BytePort, clock: Clock, framing: Framing) -> None:
        self._port = port
        self._clock = clock
        self._receiver = FrameReceiver(framing)
        self._read_at: int | None = None  # ns
        self._heard_at: int | None = None  # ns
        self._reports = self._rx_bytes = 0
        self._age = self._max_age = 0.0
        self._failure: str | None = None

    def take(self) -> list[bytes]:
        """Return the frames that have come since the last call."""
        now = self._clock.now()
        data = self._received()
        before, self._read_at = self._read_at, now
        if self._heard_at is not None:
            self._age = (now - self._heard_at) / _NS
        if before is None or now - before > _PAUSE:
            self._receiver.reset()  # of what piled up meanwhile the newest may be lost
            return []
        self._rx_bytes += len(data)
        return self._receiver.take(data)

    def heard(self, reports: int) -> float:
        """Count the reports that the frames just taken held; return how old the last one of all is, s.

        It counts as young as the tick in which it was taken.
        """
        if reports:
            self._reports += reports
            self._heard_at = self._read_at
            self._age = 0.0
        self._max_age = max(self._max_age, self._age)
        return self._age

    def statistics(self) -> SensorStatistics:
        """Return what was said so far."""
        return SensorStatistics(
            self._rx_bytes, self._reports, self._receiver.stray_bytes, self._max_age, self._failure)

    def close(self) -> None:
        """Give the port back. Never raises."""
        self._port.close()

    def _received(self) -> bytes:
        """Return what has come. A port that is dead stays so: silence, for a walk need not end for that."""
        if self._failure is not None:
            return b""
        try:
            return self._port.read()
        except BusError as error:
            self._failure = str(error)
            return b""
