"""Who a servo is that has answered a ping."""

from typing import NamedTuple

from hal.encoding import unpack
from hal.maintenance import quantity
from hal.maintenance.dialects import Dialects
from hal.maintenance.dialogue import Dialogue, NoAnswerError
from hal.protocol import Status
from hal.register_map import Memory, Register, ServoModel
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
    twins: tuple[ServoModel, ...] = ()  # other models that it may be as well: they have its number

    @property
    def name(self) -> str:
        """The model's name, or what is known instead of it."""
        if self.model is not None:
            return " or ".join(model.name for model in (self.model, *self.twins))
        return "does not answer reads" if self.model_number is None else f"unknown (model number {self.model_number})"

    def may_be(self, model: ServoModel) -> bool:
        """Whether nothing speaks against its being of a model."""
        return self.model is not None and model.name in (known.name for known in (self.model, *self.twins))


def identify(dialects: Dialects, status: Status) -> Identity:
    """Read who it is that answered a ping."""
    servo_id, baud = status.id, dialects.any.port.baud
    number, models = _models(dialects, servo_id)
    if not models:
        return Identity(servo_id, dialects.name, baud, status.alert, number, None, None, None, None)
    model, *twins = models
    dialogue, telemetry = dialects.of(model), model.cyclic.telemetry
    if dialogue is not dialects.any:
        status = dialogue.ping(servo_id).of(servo_id) or status  # each protocol reads the error byte its own way
    return Identity(
        servo_id, model.protocol, baud, status.alert, number, model, firmware(dialogue, model, servo_id),
        _measured(dialogue, servo_id, model[telemetry.voltage]),
        _measured(dialogue, servo_id, model[telemetry.temperature]), tuple(twins))


def firmware(dialogue: Dialogue, model: ServoModel, servo_id: int) -> str | None:
    """Return the firmware's version: "45", or "3.7" where it takes two registers."""
    rows = [register for register in model.registers if register.name.startswith(_FIRMWARE)]
    values = [_peek(dialogue, servo_id, register) for register in rows]
    return None if None in values else ".".join(map(str, values))


def _models(dialects: Dialects, servo_id: int) -> tuple[int | None, list[ServoModel]]:
    """Return the number that is where these models have theirs, and the models of that number that it may be.

    Dynamixel's, at address 0, comes first: Feetech's firmware version, which lies there, is no model's number. At
    Feetech's address an AX has its id and baud rate, which may be anything. A number that no model has is told low
    byte first: of servos with the high byte first there are fewer.
    """
    number = None
    rows = dict.fromkeys((model["model_number"], dialects.of(model)) for model in dialects.models)
    for row, dialogue in sorted(rows, key=lambda place: (place[0].address, place[0].byte_order)):
        number = _peek(dialogue, servo_id, row)
        alike = [
            model for model in dialects.models if model.model_number == number and model["model_number"] == row]
        if alike:
            return number, _told_apart(dialogue, servo_id, alike)
    return number, []


def _told_apart(dialogue: Dialogue, servo_id: int, alike: list[ServoModel]) -> list[ServoModel]:
    """Return the one of some models with one number whose factory settings the servo still has; all if none is it.

    So the voltage limits tell an STS3215 for 7.4 V from one for 12 V, unless somebody has changed them.
    """
    rows = [
        row for row in alike[0].registers
        if row.memory is Memory.EEPROM and len({model[row.name].default for model in alike}) > 1]
    values = {row.name: _peek(dialogue, servo_id, row) for row in rows}
    fitting = [model for model in alike if all(model[name].default == value for name, value in values.items())]
    return fitting if len(fitting) == 1 else alike


def _measured(dialogue: Dialogue, servo_id: int, register: Register) -> float | None:
    value = _peek(dialogue, servo_id, register)
    return None if value is None else quantity.in_units(register, value)


def _peek(dialogue: Dialogue, servo_id: int, register: Register) -> int | None:
    """Return a register's counts, None if the servo does not tell."""
    try:
        return unpack(register, dialogue.read(servo_id, register.address, register.size))
    except (NoAnswerError, ServoError):
        return None
