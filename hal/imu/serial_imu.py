"""An IMU on a serial line of its own: an `Imu`. It takes what has come, once a tick, and never waits."""

import math
from collections.abc import Callable, Mapping

from hal.imu import uart_rvc, witmotion
from hal.imu.framing import FrameReceiver, Framing
from hal.imu.model import FramesName, ImuConfig
from hal.imu.report import Report
from hal.imu.rotation import inverse, of_euler, product, to_euler, turned
from robotwalk.errors import BusError
from robotwalk.ports import BytePort, Clock
from robotwalk.types import ImuState, ImuStatistics

_NS = 1_000_000_000
_PAUSE = 500_000_000  # ns; after a longer one nobody knows how old what has come is: a driver's buffer holds 4096 bytes

_PROTOCOLS: Mapping[FramesName, tuple[Framing, Callable[[], Callable[[bytes], Report | None]]]] = {
    "uart-rvc": (uart_rvc.FRAMING, lambda: uart_rvc.decode),
    "witmotion": (witmotion.FRAMING, witmotion.Decoder),
}


class SerialImu:
    """A sensor that talks unasked, mounted on the robot's base."""

    def __init__(self, port: BytePort, clock: Clock, frames: FramesName, config: ImuConfig) -> None:
        """Listen on an opened port; `frames` is how the sensor of `config` talks."""
        framing, make_decoder = _PROTOCOLS[frames]
        self._port = port
        self._clock = clock
        self._receiver = FrameReceiver(framing)
        self._decode = make_decoder()
        self._mounting = of_euler(*map(math.radians, config.mounting_deg))
        self._unmounting = inverse(self._mounting)
        self._stale_after = config.stale_after_s
        self._read_at: int | None = None  # ns
        self._heard_at = 0  # ns
        self._state: ImuState | None = None
        self._reports = self._rx_bytes = 0
        self._max_age = 0.0
        self._failure: str | None = None

    def read(self) -> ImuState | None:
        """Take what has come; return what is known of the base now. None: nothing has been heard yet."""
        now = self._clock.now()
        report = self._latest(now)
        if report is not None:
            self._heard_at = now
            self._state = self._of_base(report)
        elif self._state is not None:
            age = (now - self._heard_at) / _NS
            self._state = self._state._replace(age=age, valid=age <= self._stale_after)
            self._max_age = max(self._max_age, age)
        return self._state

    def statistics(self) -> ImuStatistics:
        """Return what it has said so far."""
        return ImuStatistics(
            self._rx_bytes, self._reports, self._receiver.stray_bytes, self._max_age, self._failure)

    def close(self) -> None:
        """Give the port back. Never raises."""
        self._port.close()

    def _latest(self, now: int) -> Report | None:
        """Return the last measurement that has come since the last call."""
        data = self._received()
        before, self._read_at = self._read_at, now
        if before is None or now - before > _PAUSE:
            self._receiver.reset()  # of what piled up meanwhile the newest may be lost
            return None
        self._rx_bytes += len(data)
        latest = None
        for frame in self._receiver.take(data):
            report = self._decode(frame)
            if report is not None:
                self._reports += 1
                latest = report
        return latest

    def _received(self) -> bytes:
        """Return what has come. A port that is dead stays so: silence, for a walk need not end for that."""
        if self._failure is not None:
            return b""
        try:
            return self._port.read()
        except BusError as error:
            self._failure = str(error)
            return b""

    def _of_base(self, report: Report) -> ImuState:
        roll, pitch, yaw = to_euler(product(report.attitude, self._unmounting))
        rate, acceleration = (
            None if vector is None else turned(self._mounting, vector)
            for vector in (report.angular_velocity, report.acceleration))
        return ImuState(roll, pitch, yaw, rate, acceleration, age=0.0, valid=True)
