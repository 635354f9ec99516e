"""A servo in its place: which joint it moves."""

from typing import NamedTuple

from hal.calibration import Calibration
from hal.register_map import ServoModel


class Wired(NamedTuple):
    """A servo and the joint that it moves."""

    joint: str
    limb: str  # whose joints come to power together
    slot: int  # in the robot's joint order
    id: int
    model: ServoModel
    calibration: Calibration
    lower: float  # rad, the joint's limits
    upper: float

    def __str__(self) -> str:
        return f"{self.joint} (id {self.id})"
