"""What a servo measures, over and over, in units for people."""

import math
from typing import NamedTuple

from hal.encoding import unpack
from hal.maintenance.dialogue import NoAnswerError
from hal.maintenance.servo import Servo
from hal.register_map import Block, ServoModel
from robotwalk.errors import ServoError


class Sample(NamedTuple):
    """One moment of one servo."""

    id: int
    position_deg: float  # from the encoder's centre
    velocity_deg_s: float
    load_percent: float  # of the largest output
    voltage_v: float
    temperature_c: float
    errors: tuple[str, ...]  # of its hardware


def sample(servo: Servo) -> Sample | None:
    """Read a servo; None if it does not answer."""
    model, cyclic = servo.model, servo.model.cyclic
    voltage, temperature = cyclic.telemetry.voltage, cyclic.telemetry.temperature
    block = _block(model)
    try:
        data = servo.dialogue.read(servo.id, block.address, block.size)
        errors = tuple(servo.faults())
    except (NoAnswerError, ServoError):
        return None
    counts = {row.name: unpack(row, data[row.address - block.address :][: row.size]) for row in block.registers}
    position = counts[cyclic.position] - model.encoder.centre
    return Sample(
        id=servo.id,
        position_deg=math.degrees(position * model.encoder.radians_per_tick),
        velocity_deg_s=math.degrees(counts[cyclic.velocity] * model[cyclic.velocity].si_scale),
        load_percent=100.0 * counts[cyclic.effort] / cyclic.effort_full_scale,
        voltage_v=counts[voltage] * model[voltage].scale,
        temperature_c=counts[temperature] * model[temperature].scale,
        errors=errors)


def _block(model: ServoModel) -> Block:
    """Return what is read at once."""
    cyclic = model.cyclic
    telemetry = cyclic.telemetry
    names = cyclic.position, cyclic.velocity, cyclic.effort, telemetry.voltage, telemetry.temperature
    return Block(tuple(sorted((model[name] for name in names), key=lambda row: row.address)))
