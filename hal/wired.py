"""A servo in its place: which joint it moves, and how its counts become the joint's SI units."""

from collections.abc import Callable
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


def feedback_decoder(servo: Wired) -> Callable[[bytes], Sample]:
    """Return what converts a servo's feedback, as many bytes as its model's block has, to its joint's SI units."""
    model, calibration = servo.model, servo.calibration
    cyclic, block = model.cyclic, model.feedback
    names = [register.name for register in block.registers]
    position, velocity, effort = map(names.index, (cyclic.position, cyclic.velocity, cyclic.effort))
    unpack, angle, direction = BlockDecoder(block).unpack, calibration.angle, calibration.direction
    speed_scale = direction * model[cyclic.velocity].si_scale
    effort_scale = direction / cyclic.effort_full_scale

    def sample(data: bytes) -> Sample:
        values = unpack(data)
        return Sample(angle(values[position]), values[velocity] * speed_scale, values[effort] * effort_scale)

    return sample
