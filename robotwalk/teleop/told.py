"""What is known of the robot while it is driven: for the screen, for devices, for watchers."""

from collections.abc import Mapping
from typing import NamedTuple

from robotwalk.timing import Percentiles
from robotwalk.types import LEVEL, STILL, BusStatistics, Pose, ServoCondition, Twist

UNTIMED = Percentiles(0.0, 0.0, 0.0, 0.0)


class Told(NamedTuple):
    """All of it, at one moment."""

    state: str = "stop"
    driver: str | None = None
    note: str = ""  # why it is so, where that needs words
    pose: Pose = LEVEL  # of the base in odom
    twist: Twist = STILL  # in force
    conditions: Mapping[str, ServoCondition] = {}
    buses: Mapping[str, BusStatistics] = {}
    rate_hz: int = 0
    ticks: int = 0
    missed: int = 0
    wake: Percentiles = UNTIMED  # us
    exchange: Percentiles = UNTIMED
    compute: Percentiles = UNTIMED
