"""A servo's EEPROM as a file, and back into a servo."""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, NamedTuple

from pydantic import Field

from hal.maintenance import quantity
from hal.maintenance.servo import Change, Servo
from hal.register_map import Access, Memory, Register, Row, ServoModel
from robotwalk.errors import BusError, ServoError, UsageError

_ADDRESS = ("id", "baud_rate")  # how a servo is reached; restored last, and only if asked for


class Backup(Row):
    """What the file holds. Values are counts, as on the wire."""

    schema_version: Literal[1] = Field(alias="schema")
    model: str
    model_number: int
    id: int
    baud: int
    firmware: str
    time: str  # ISO 8601
    registers: Mapping[str, int]


class Problem(NamedTuple):
    """Something in a backup that its servo model does not have or does not take."""

    register: str
    what: str
    got: int


class Restored(NamedTuple):
    """What a restore did."""

    changes: tuple[Change, ...]
    same: int  # registers that held their values already
    left: tuple[str, ...]  # registers that differ and were not to be written
    id: int  # where the servo is now
    baud: int


def take(servo: Servo, time: str) -> Backup:
    """Read a servo's whole EEPROM.

    Raises:
        BusError: the servo does not answer.
    """
    values = servo.read_all(_eeprom(servo.model))
    return Backup(
        schema=1, model=servo.model.name, model_number=servo.model.model_number, id=servo.id,
        baud=servo.identity.baud, firmware=servo.identity.firmware or "unknown", time=time,
        registers={name: value for name, value in values.items() if value is not None})


def to_json(backup: Backup) -> str:
    """Return the file's text as JSON."""
    return json.dumps(backup.model_dump(by_alias=True), indent=2) + "\n"


def to_yaml(backup: Backup, model: ServoModel) -> str:
    """Return the file's text as YAML, each value with its meaning beside it."""
    head = {key: value for key, value in backup.model_dump(by_alias=True).items() if key != "registers"}
    lines = [f"# EEPROM of a {model.description}"]
    lines += [f"{key}: {json.dumps(value)}" for key, value in head.items()]
    lines.append("registers:  # in counts")
    for name, value in backup.registers.items():
        meaning = quantity.text(model[name], value)
        lines.append(f"  {name}: {value}" + (f"  # {meaning}" if meaning != str(value) else ""))
    return "\n".join(lines) + "\n"


def problems(backup: Backup, model: ServoModel) -> Iterator[Problem]:
    """Find what cannot be restored to this model."""
    for name, value in backup.registers.items():
        if name not in model.by_name or model[name].memory is not Memory.EEPROM:
            yield Problem(name, f"{model.name} has no such register in its EEPROM", value)
        elif model[name].access is Access.READ_WRITE:
            try:
                quantity.check(model[name], value)
            except UsageError as error:
                yield Problem(name, str(error), value)


def restore(servo: Servo, backup: Backup, *, with_id: bool) -> Restored:
    """Write what differs back into a servo, and read it back; id and baud rate last, if at all.

    Raises:
        BusError: the servo does not answer.
        ServoError: it is another model, its torque is on, it refuses or does not keep a value, or its new id is taken.
    """
    if servo.model.model_number != backup.model_number:
        raise ServoError(f"{servo} is no {backup.model}, of which the backup is")
    servo.require_limp()
    rows = [row for row in _eeprom(servo.model) if row.access is Access.READ_WRITE and row.name in backup.registers]
    present = servo.read_all(rows)
    differing = [row.name for row in rows if present[row.name] != backup.registers[row.name]]
    wanted = [name for name in differing if with_id or name not in _ADDRESS]
    wanted.sort(key=lambda name: name in _ADDRESS)
    changes: list[Change] = []
    for name in wanted:
        try:
            changes.append(servo.write(name, backup.registers[name]))
        except (BusError, ServoError) as error:
            done = ", ".join(change.register.name for change in changes) or "nothing"
            raise type(error)(f"{error}. Changed before that: {done}") from error
    left = tuple(name for name in differing if name not in wanted)
    return Restored(tuple(changes), len(rows) - len(differing), left, servo.id, servo.dialogue.port.baud)


def _eeprom(model: ServoModel) -> Sequence[Register]:
    return [register for register in model.registers if register.memory is Memory.EEPROM]
