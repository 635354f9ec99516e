"""What a sensor reports, in its own frame."""

from typing import NamedTuple

from hal.imu.rotation import Quaternion
from robotwalk.types import Vec3


class Report(NamedTuple):
    """One measurement. The sensor's axes are those printed on it: right-handed, z up where it lies flat."""

    attitude: Quaternion  # of the sensor in a world with z up; where its yaw is 0 is the sensor's own affair
    angular_velocity: Vec3 | None  # rad/s, about the sensor's axes; None: it does not say
    acceleration: Vec3 | None  # m/s^2, along the sensor's axes; at rest it is one g upwards
