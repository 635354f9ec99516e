"""WitMotion's WT901, WT61 and their like: packets of 11 bytes, several to a measurement, as often as they are set to.

    55 51  ax ay az  temperature  sum       16 g / 32768
    55 52  wx wy wz  temperature  sum       2000 deg/s / 32768
    55 53  roll pitch yaw  version  sum     180 deg / 32768      16 bits each, low byte first

(WT901 data sheet v20-0702, 5.1; BWT61CL data sheet v20-0630, 6.1.) The sum is over all bytes before it. Other packets
(time 50, magnetic field 54, ...) come in between, and are passed over.
"""

import math
import re
import struct

from hal.imu.report import Report
from hal.imu.rotation import of_euler
from hal.unasked_frames import Framing
from robotwalk.types import Vec3

FRAMING = Framing(re.compile(rb"\x55[\x50-\x5f]"), size=11, summed_from=0)

_FIELDS = struct.Struct("<2x3h")
_ACCELERATION, _RATE, _ANGLE = 0x51, 0x52, 0x53
_FULL = 32768
_G = 9.80665  # m/s^2
_SCALE = {_ACCELERATION: 16.0 * _G / _FULL, _RATE: math.radians(2000.0) / _FULL, _ANGLE: math.pi / _FULL}


class Decoder:
    """Puts a measurement together; it is whole with its angles, which come last."""

    def __init__(self) -> None:
        self._before: dict[int, Vec3] = {}

    def __call__(self, frame: bytes) -> Report | None:
        """Return what is whole with this packet."""
        kind = frame[1]
        if kind not in _SCALE:
            return None
        x, y, z = (value * _SCALE[kind] for value in _FIELDS.unpack_from(frame))
        if kind != _ANGLE:
            self._before[kind] = Vec3(x, y, z)
            return None
        before, self._before = self._before, {}
        return Report(of_euler(x, y, z), before.get(_RATE), before.get(_ACCELERATION))
