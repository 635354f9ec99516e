"""Whether the IMU is heard: what a run's events tell of it."""

from robotwalk.ports import Imu
from robotwalk.types import ImuState

_SILENT = 0.5  # s of ticks; with fewer it may be the first ones after a pause


class ImuWatch:
    """Notices when an IMU falls silent, and when it is back."""

    def __init__(self, imu: Imu) -> None:
        self._imu = imu
        self._heard = True
        self._heard_at = 0.0

    def step(self, seen: ImuState | None, seconds: float) -> str | None:
        """Return what is new, in words, when so many seconds of ticks have passed in all."""
        if seen is not None and seen.valid:
            self._heard_at = seconds
        heard = seconds - self._heard_at < _SILENT
        if heard is self._heard:
            return None
        self._heard = heard
        if heard:
            return "the IMU is heard again"
        failure = self._imu.statistics().failure
        return f"the IMU is silent{f': {failure}' if failure else ''}"
