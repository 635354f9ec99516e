"""A servo in its place: which joint it moves, and how its counts become the joint's SI units."""

from typing import NamedTuple

from hal.calibration import Calibration
from hal.encoding import BlockDecoder
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


class Sample(NamedTuple):
    """What one servo reported of its joint."""

    position: float  # rad
    velocity: float  # rad/s
    effort: float  # share of the largest output


class FeedbackDecoder:
    """Reads the feedback of servos of one model."""

    def __init__(self, model: ServoModel) -> None:
        cyclic, block = model.cyclic, model.feedback
        self.size = block.size
        self._decoder = BlockDecoder(block)
        names = [register.name for register in block.registers]
        self._position, self._velocity = names.index(cyclic.position), names.index(cyclic.velocity)
        self._effort = names.index(cyclic.effort)
        self._speed_scale = model[cyclic.velocity].si_scale
        self._effort_scale = 1.0 / cyclic.effort_full_scale

    def sample(self, servo: Wired, data: bytes) -> Sample:
        """Convert a servo's feedback, `size` bytes, to its joint's SI units."""
        values, calibration = self._decoder.unpack(data), servo.calibration
        return Sample(
            calibration.angle(values[self._position]),
            calibration.speed(values[self._velocity], self._speed_scale),
            calibration.direction * values[self._effort] * self._effort_scale,
        )
