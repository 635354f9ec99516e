"""Who a servo is that has answered a ping."""

from collections.abc import Sequence
from typing import NamedTuple

from hal.encoding import unpack
from hal.maintenance import quantity
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


def identify(dialogue: Dialogue, models: Sequence[ServoModel], status: Status) -> Identity:
    """Read who it is that answered. All `models` speak the protocol of the dialogue."""
    number, model = _model(dialogue, models, status.id)
    return Identity(
        status.id, models[0].protocol, dialogue.port.baud, status.alert, number, model,
        firmware(dialogue, model, status.id) if model else None,
        _measured(dialogue, model, status.id, "present_input_voltage"),
        _measured(dialogue, model, status.id, "present_temperature"))


def firmware(dialogue: Dialogue, model: ServoModel, servo_id: int) -> str | None:
    """Return the firmware's version: "45", or "3.7" where it takes two registers."""
    rows = [register for register in model.registers if register.name.startswith(_FIRMWARE)]
    values = [_peek(dialogue, servo_id, register) for register in rows]
    return None if None in values else ".".join(map(str, values))


def _model(
    dialogue: Dialogue, models: Sequence[ServoModel], servo_id: int
) -> tuple[int | None, ServoModel | None]:
    """Return the number that is where these models have theirs, and the model of that number."""
    number = None
    for row in dict.fromkeys(model["model_number"] for model in models):
        number = _peek(dialogue, servo_id, row)
        for model in models:
            if model.model_number == number and model["model_number"] == row:
                return number, model
    return number, None


def _measured(dialogue: Dialogue, model: ServoModel | None, servo_id: int, name: str) -> float | None:
    if model is None or name not in model.by_name:
        return None
    value = _peek(dialogue, servo_id, model[name])
    return None if value is None else quantity.in_units(model[name], value)


def _peek(dialogue: Dialogue, servo_id: int, register: Register) -> int | None:
    """Return a register's counts, None if the servo does not tell."""
    try:
        return unpack(register, dialogue.read(servo_id, register.address, register.size))
    except (NoAnswerError, ServoError):
        return None
