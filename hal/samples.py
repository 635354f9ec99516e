"""What servos report of their joints, from the bytes of their feedback to SI units."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from hal.encoding import decoder
from hal.register_map import Block, Register
from hal.whole_reply import Outline
from hal.wired import Wired


class Sample(NamedTuple):
    """What one servo reported of its joint."""

    position: float  # rad
    velocity: float  # rad/s
    effort: float  # share of the largest output at the present supply


def sample_decoder(servo: Wired) -> Callable[[bytes], Sample]:
    """Return what converts a servo's feedback, as many bytes as its model's block has."""
    decode = samples_decoder([servo], Outline(0, 0, 0))
    assert decode is not None

    def sample(data: bytes) -> Sample:
        [(_, values)] = decode(data)
        return Sample(*values)

    return sample


def samples_decoder(
    servos: Sequence[Wired], outline: Outline
) -> Callable[[bytes], Iterator[tuple[int, tuple[float, float, float]]]] | None:
    """Return what converts the feedback of servos, laid out side by side: to slots and samples.

    None if their registers do not lie alike.
    """
    fields = _fields(servos[0].model.feedback)
    if any(_fields(servo.model.feedback) != fields for servo in servos):
        return None
    size = outline.before + servos[0].model.feedback.size + outline.after
    unpack = decoder([
        (register, outline.lead + place * size + outline.before + offset)
        for place in range(len(servos)) for register, offset in fields])
    names, cyclic = [register.name for register, _ in fields], servos[0].model.cyclic
    position, velocity, effort = map(names.index, (cyclic.position, cyclic.velocity, cyclic.effort))
    step, slots = len(fields), [servo.slot for servo in servos]
    angles = [
        (servo.calibration.zero, servo.calibration.direction, servo.calibration.centre,
         servo.calibration.radians_per_tick) for servo in servos]
    speeds = [servo.calibration.direction * servo.model[cyclic.velocity].si_scale for servo in servos]
    efforts = [servo.calibration.direction / servo.model.cyclic.effort_full_scale for servo in servos]

    def samples(data: bytes) -> Iterator[tuple[int, tuple[float, float, float]]]:
        values = unpack(data)
        return zip(slots, zip(
            [zero + direction * (count - centre) * scale  # as Calibration.angle
             for count, (zero, direction, centre, scale) in zip(values[position::step], angles, strict=True)],
            [count * scale for count, scale in zip(values[velocity::step], speeds, strict=True)],
            [count * scale for count, scale in zip(values[effort::step], efforts, strict=True)],
            strict=True), strict=True)

    return samples


def _fields(block: Block) -> list[tuple[Register, int]]:
    return [(register, register.address - block.address) for register in block.registers]
