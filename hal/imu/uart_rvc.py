"""UART-RVC of CEVA's BNO080, BNO085 and BNO086 (PS0 high, PS1 low at reset): 100 frames a second at 115200 baud.

    AA AA  index  yaw  pitch  roll  ax  ay  az  3 reserved  sum        19 bytes; 16 bits each, low byte first

(BNO080 data sheet 1000-3927, 1.3.5.2.) Angles are in 0.01 deg, accelerations in mg; the sum is over all from the
index on. Rotations apply in the order yaw, pitch, roll. There is no angular velocity.

The data sheet calls pitch a rotation about y and roll one about x. Its own example says otherwise: of a sensor at
rest with pitch -1.10 and roll 20.85 deg it gives -371 mg along x and -20 mg along y, and a sensor that is turned by
20.85 deg about *y* feels -sin(20.85 deg) = -356 mg along x. So pitch is about x, roll about y, as Android has them.
"""

import math
import re
import struct

from hal.imu.report import Report
from hal.imu.rotation import about_x, about_y, about_z, product
from hal.unasked_frames import Framing
from robotwalk.types import Vec3

FRAMING = Framing(re.compile(rb"\xaa\xaa"), size=19, summed_from=2)

_FIELDS = struct.Struct("<3x6h")
_ANGLE = math.radians(0.01)
_MILLI_G = 9.80665e-3  # m/s^2
_TURN, _QUARTER = 18000, 9000  # the largest yaw and roll, and pitch


def decode(frame: bytes) -> Report | None:
    """Return what a whole frame reports; None if its angles cannot be."""
    yaw, pitch, roll, *acceleration = _FIELDS.unpack_from(frame)
    if abs(yaw) > _TURN or abs(roll) > _TURN or abs(pitch) > _QUARTER:
        return None
    attitude = product(about_z(yaw * _ANGLE), product(about_x(pitch * _ANGLE), about_y(roll * _ANGLE)))
    x, y, z = (value * _MILLI_G for value in acceleration)
    return Report(attitude, None, Vec3(x, y, z))
