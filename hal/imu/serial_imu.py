"""An IMU on a serial line of its own: an `Imu`. It takes what has come, once a tick, and never waits."""

import math
from collections.abc import Callable, Mapping

from hal.imu import uart_rvc, witmotion
from hal.imu.model import FramesName, ImuConfig
from hal.imu.report import Report
from hal.imu.rotation import inverse, of_euler, product, to_euler, turned
from hal.unasked_frames import Framing
from hal.unasked_line import UnaskedLine
from robotwalk.ports import BytePort, Clock
from robotwalk.types import ImuState, SensorStatistics

_PROTOCOLS: Mapping[FramesName, tuple[Framing, Callable[[], Callable[[bytes], Report | None]]]] = {
    "uart-rvc": (uart_rvc.FRAMING, lambda: uart_rvc.decode),
    "witmotion": (witmotion.FRAMING, witmotion.Decoder),
}


class SerialImu:
    """A sensor that talks unasked, mounted on the robot's base."""

    def __init__(self, port: BytePort, clock: Clock, frames: FramesName, config: ImuConfig) -> None:
        """Listen on an opened port; `frames` is how the sensor of `config` talks."""
        framing, make_decoder = _PROTOCOLS[frames]
        self._line = UnaskedLine(port, clock, framing)
        self._decode = make_decoder()
        self._mounting = of_euler(*map(math.radians, config.mounting_deg))
        self._unmounting = inverse(self._mounting)
        self._stale_after = config.stale_after_s
        self._state: ImuState | None = None

    def read(self) -> ImuState | None:
        """Take what has come; return what is known of the base now. None: nothing has been heard yet."""
        reports = [report for frame in self._line.take() if (report := self._decode(frame)) is not None]
        age = self._line.heard(len(reports))
        if reports:
            self._state = self._of_base(reports[-1])
        elif self._state is not None:
            self._state = self._state._replace(age=age, valid=age <= self._stale_after)
        return self._state

    def statistics(self) -> SensorStatistics:
        """Return what it has said so far."""
        return self._line.statistics()

    def close(self) -> None:
        """Give the port back. Never raises."""
        self._line.close()

    def _of_base(self, report: Report) -> ImuState:
        roll, pitch, yaw = to_euler(product(report.attitude, self._unmounting))
        rate, acceleration = (
            None if vector is None else turned(self._mounting, vector)
            for vector in (report.angular_velocity, report.acceleration))
        return ImuState(roll, pitch, yaw, rate, acceleration, age=0.0, valid=True)
