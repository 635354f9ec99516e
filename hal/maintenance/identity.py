"""Who a servo is that has answered a ping."""

from typing import NamedTuple

from hal.encoding import unpack
from hal.maintenance import quantity
from hal.maintenance.dialects import Dialects
from hal.maintenance.dialogue import Dialogue, NoAnswerError
from hal.protocol import Status
from hal.register_map import Register, ServoModel
from robotwalk.errors import ServoError

_FIRMWARE = "firmware_"  # how the names of the registers begin that hold its version


class Identity(NamedTuple):
    """What a servo says of itself; None where it does not."""

    id: int
    protocol: str
    baud: int
    alert: bool  # it reports a fault of its hardware
    model_number: int | None
    model: ServoModel | None  # None: no file of `configs/servos` has that number
    firmware: str | None
    voltage_v: float | None
    temperature_c: float | None

    @property
    def name(self) -> str:
        """The model's name, or what is known instead of it."""
        if self.model is not None:
            return self.model.name
        return "does not answer reads" if self.model_number is None else f"unknown (model number {self.model_number})"


def identify(dialects: Dialects, status: Status) -> Identity:
    """Read who it is that answered a ping."""
    servo_id, baud = status.id, dialects.any.port.baud
    number, model = _model(dialects, servo_id)
    if model is None:
        return Identity(servo_id, dialects.name, baud, status.alert, number, None, None, None, None)
    dialogue, telemetry = dialects.of(model), model.cyclic.telemetry
    if dialogue is not dialects.any:
        status = dialogue.ping(servo_id).of(servo_id) or status  # each protocol reads the error byte its own way
    return Identity(
        servo_id, model.protocol, baud, status.alert, number, model, firmware(dialogue, model, servo_id),
        _measured(dialogue, servo_id, model[telemetry.voltage]),
        _measured(dialogue, servo_id, model[telemetry.temperature]))


def firmware(dialogue: Dialogue, model: ServoModel, servo_id: int) -> str | None:
    """Return the firmware's version: "45", or "3.7" where it takes two registers."""
    rows = [register for register in model.registers if register.name.startswith(_FIRMWARE)]
    values = [_peek(dialogue, servo_id, register) for register in rows]
    return None if None in values else ".".join(map(str, values))


def _model(dialects: Dialects, servo_id: int) -> tuple[int | None, ServoModel | None]:
    """Return the number that is where these models have theirs, and the model of that number.

    Dynamixel's, at address 0, comes first: Feetech's firmware version, which lies there, is no model's number. At
    Feetech's address an AX has its id and baud rate, which may be anything.
    """
    number = None
    rows = dict.fromkeys((model["model_number"], dialects.of(model)) for model in dialects.models)
    for row, dialogue in sorted(rows, key=lambda place: place[0].address):
        number = _peek(dialogue, servo_id, row)
        for model in dialects.models:
            if model.model_number == number and model["model_number"] == row:
                return number, model
    return number, None


def _measured(dialogue: Dialogue, servo_id: int, register: Register) -> float | None:
    value = _peek(dialogue, servo_id, register)
    return None if value is None else quantity.in_units(register, value)


def _peek(dialogue: Dialogue, servo_id: int, register: Register) -> int | None:
    """Return a register's counts, None if the servo does not tell."""
    try:
        return unpack(register, dialogue.read(servo_id, register.address, register.size))
    except (NoAnswerError, ServoError):
        return None
