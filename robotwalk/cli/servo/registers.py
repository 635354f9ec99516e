"""`robotwalk servo info`, `read` and `write`: registers by name, in units."""

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any

from cyclopts import Parameter

from robotwalk.assembly import workbench
from robotwalk.cli.options import Json
from robotwalk.cli.output import complain, say, write_json, write_table
from robotwalk.cli.servo.options import Line, ServoId
from robotwalk.errors import UsageError

Raw = Annotated[bool, Parameter(negative="", help="Counts, as on the wire, instead of units.")]

_MEMORIES = {"eeprom": "EEPROM, kept without power", "ram": "RAM, back to its defaults at every start"}
_NUMBERED = re.compile(r"(.*_)\d+")
_FEW = 8  # registers of one numbered name; more are told in one row while nobody has touched them


def info(servo_id: ServoId, /, *, line: Line, json: Json = False) -> None:
    """Show everything about one servo: model, firmware, hardware errors, and all its registers.

    """
    with line.reading() as bench:
        servo = bench.servo(servo_id)
        values = servo.read_all(servo.model.registers)
        faults = servo.faults()
    identity = servo.identity
    if json:
        registers = {
            name: _fields(servo.model[name], counts) | {"memory": servo.model[name].memory.value}
            for name, counts in values.items() if counts is not None}
        write_json({
            "id": servo.id, "model": servo.model.name, "model_number": servo.model.model_number,
            "firmware": identity.firmware, "protocol": identity.protocol, "baud": identity.baud,
            "hardware_errors": faults, "registers": registers})
        return
    say(f"id {servo.id}: {servo.model.description}")
    say(f"model number {servo.model.model_number}, firmware {identity.firmware or 'unknown'}, {identity.protocol}, "
        f"{identity.baud} baud")
    say(f"hardware errors: {', '.join(faults) or 'none'}")
    for memory, title in _MEMORIES.items():
        rows = [row for row in servo.model.registers if row.memory.value == memory]
        write_table(title, ["address", "register", "counts", "value", "factory", ""], list(_rows(rows, values)))


def read(servo_id: ServoId, /, *registers: str, line: Line, raw: Raw = False, json: Json = False) -> None:
    """Read registers of one servo by their names.

    Parameters
    ----------
    registers
        Names, as `robotwalk servo info` shows them.
    """
    if not registers:
        raise UsageError("say which registers; `robotwalk servo info` shows all")
    with line.reading() as bench:
        servo = bench.servo(servo_id)
        rows = [workbench.quantity.register_of(servo.model, name) for name in dict.fromkeys(registers)]
        values = {row.name: servo.read(row.name) for row in rows}
    if json:
        fields = {row.name: _fields(row, values[row.name]) for row in rows}
        write_json({"id": servo.id, "model": servo.model.name, "registers": fields})
        return
    for row in rows:
        counts = values[row.name]
        say(f"{row.name} = {counts if raw else workbench.quantity.text(row, counts)}")


def write(servo_id: ServoId, /, *assignments: str, line: Line, raw: Raw = False, json: Json = False) -> None:
    """Write registers of one servo, and read them back. What the EEPROM already holds is not written again.

    Parameters
    ----------
    assignments
        REGISTER=VALUE, the value in the register's unit: max_voltage_limit=12.5 or max_voltage_limit=12.5V.
    """
    pairs = [_split(words) for words in assignments]
    if not pairs:
        raise UsageError("say what to write: REGISTER=VALUE")
    changes = []
    with line.writing() as bench:
        servo = bench.servo(servo_id)
        # All are checked before any is written.
        wanted = [(name, _counts(servo, name, words, raw)) for name, words in pairs]
        for name, counts in wanted:
            changes.append(servo.write(name, counts))
            if not json:
                say(_told(changes[-1], raw))
            if changes[-1].after != counts:
                complain(f"{name} was to be {counts} and reads back as {changes[-1].after}")
    undo = undo_of(changes, servo.id, line)
    if json:
        write_json({"id": servo.id, "model": servo.model.name, "undo": undo, "changes": [
            change_fields(change) | {"asked": counts} for change, (_, counts) in zip(changes, wanted, strict=True)]})
    elif undo:
        say(f"to undo: {undo}")


def undo_of(changes: Sequence[workbench.Change], servo_id: int, line: Line) -> str | None:
    """Return what to type to take back what was written to the EEPROM; None if nothing was, or it cannot be had so.

    What a restart takes back is not looked at before it is written. A new id or baud rate has its own commands.
    """
    old = [change for change in changes if change.before is not None and change.changed]
    if not old or any(change.register.name in ("id", "baud_rate") for change in old):
        return None
    pairs = " ".join(f"{change.register.name}={change.before}" for change in old)
    return f"robotwalk servo write {servo_id} {pairs} --raw {line.words(line.baud)}"


def change_fields(change: workbench.Change) -> dict[str, Any]:
    """Return what a write did, for JSON."""
    before = None if change.before is None else _fields(change.register, change.before)
    return {"register": change.register.name, "before": before, "after": _fields(change.register, change.after)}


def change_text(change: workbench.Change) -> str:
    """Return what a write did, for a person."""
    return _told(change, raw=False)


def _split(words: str) -> tuple[str, str]:
    name, equals, value = words.partition("=")
    if not (name and equals and value):
        raise UsageError(f"say REGISTER=VALUE, such as return_delay_time=0, not {words!r}")
    return name.strip(), value


def _counts(servo: workbench.Servo, name: str, words: str, raw: bool) -> int:
    register = workbench.quantity.register_of(servo.model, name)
    return workbench.quantity.counts(register, words, raw=raw)


def _told(change: workbench.Change, raw: bool) -> str:
    def text(counts: int) -> str:
        return str(counts) if raw else workbench.quantity.text(change.register, counts)

    name = change.register.name
    if change.before is None:
        return f"{name} = {text(change.after)}"
    if change.changed:
        return f"{name} = {text(change.after)}, was {text(change.before)}"
    return f"{name} = {text(change.after)} already; not written"


def _fields(register: workbench.Register, counts: int) -> dict[str, Any]:
    return {
        "raw": counts, "value": workbench.quantity.in_units(register, counts), "unit": register.unit,
        **({"flags": workbench.quantity.flags(register, counts)} if register.flags else {})}


def _rows(registers: list[workbench.Register], values: Mapping[str, int | None]) -> Iterator[list[str]]:
    """Yield a line for each register; one for many that are numbered and as the factory set them."""
    for stem, group in itertools.groupby(sorted(registers, key=lambda row: row.address), key=_stem):
        rows = list(group)
        if len(rows) > _FEW and all(values[row.name] == row.default for row in rows):
            numbers = f"{rows[0].name} to {rows[-1].name.removeprefix(stem)}"
            yield [f"{rows[0].address}-{rows[-1].end - 1}", numbers, "", "as from the factory", "", ""]
        else:
            yield from (_row(row, values[row.name]) for row in rows)


def _stem(register: workbench.Register) -> str:
    match = _NUMBERED.fullmatch(register.name)
    return match[1] if match else register.name


def _row(register: workbench.Register, counts: int | None) -> list[str]:
    access = "" if register.access == "rw" else "read-only"
    if counts is None:
        return [str(register.address), register.name, "", "not in this firmware", "", access]
    text = workbench.quantity.text
    differs = register.default not in (None, counts)
    factory = text(register, register.default) if differs and register.default is not None else ""
    return [str(register.address), register.name, str(counts), text(register, counts), factory, access]
