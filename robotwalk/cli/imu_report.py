"""What an IMU adds to the report of a walk."""

import math
from typing import Any

from robotwalk.types import ImuState, SensorStatistics


class ImuReport:
    """Sums up what it told while the robot walked."""

    def __init__(self) -> None:
        self._count = 0
        self._roll = self._pitch = 0.0  # rad, all added up
        self._tilt = 0.0  # rad, the largest

    def add(self, imu: ImuState | None) -> None:
        """Take what is known in one tick; what is not valid does not count."""
        if imu is not None and imu.valid:
            self._count += 1
            self._roll += imu.roll
            self._pitch += imu.pitch
            self._tilt = max(self._tilt, math.acos(math.cos(imu.roll) * math.cos(imu.pitch)))

    @property
    def heard(self) -> bool:
        """Whether it told anything."""
        return self._count > 0

    def fields(self, statistics: SensorStatistics | None) -> dict[str, Any]:
        """Return the field `imu` of a report; none if the robot has no IMU."""
        if statistics is None:
            return {}
        carried = statistics._asdict()
        heard = self.heard
        return {"imu": carried | {
            "max_age_ms": 1e3 * carried.pop("max_age"),
            "mean_roll_deg": math.degrees(self._roll / self._count) if heard else None,
            "mean_pitch_deg": math.degrees(self._pitch / self._count) if heard else None,
            "max_tilt_deg": math.degrees(self._tilt) if heard else None}}
