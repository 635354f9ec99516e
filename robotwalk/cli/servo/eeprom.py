"""`robotwalk servo backup`, `restore` and `factory-reset`: all that a servo keeps without power."""

import datetime
import os
from pathlib import Path
from typing import Literal

from robotwalk.assembly import workbench
from robotwalk.cli.options import Flag, Json
from robotwalk.cli.output import complain, say, write_json
from robotwalk.cli.servo.options import Line, ServoId
from robotwalk.cli.servo.registers import change_fields, change_text, undo_of
from robotwalk.errors import UsageError


def backup(
    servo_id: ServoId, file: Path, /, *, line: Line, force: Flag = False, json: Json = False
) -> None:
    """Save all registers of a servo's EEPROM to a file.

    Parameters
    ----------
    file
        YAML, or JSON if its name ends so.
    force
        Overwrite the file if there is one.
    """
    if file.exists() and not force:
        raise UsageError(f"{file} exists already; --force overwrites it")
    if not os.access(file.parent, os.W_OK):
        raise UsageError(f"{file} cannot be written")
    time = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    with line.reading() as bench:
        saved = bench.backup(bench.servo(servo_id), time)
    try:
        file.write_text(workbench.backup_text(saved, file, line.models))
    except OSError as error:
        raise UsageError(f"{file} cannot be written: {error.strerror}") from error
    if json:
        write_json({"file": str(file), **saved.model_dump()})
    else:
        say(f"saved {len(saved.registers)} registers of id {saved.id} ({saved.model}) to {file}")


def restore(
    servo_id: ServoId, file: Path, /, *, line: Line, with_id: Flag = False, json: Json = False
) -> None:
    """Bring a servo's EEPROM back to what a backup holds. Only what differs is written; torque must be off.

    Parameters
    ----------
    servo_id
        It may be another servo of the same model.
    file
        From `robotwalk servo backup`.
    with_id
        Bring back the id and the baud rate too, last of all.
    """
    saved = workbench.read_backup(file, line.models)
    with line.writing() as bench:
        servo = bench.servo(servo_id)
        done = bench.restore(servo, saved, with_id=with_id)
    undo = undo_of(done.changes, done.id, line)
    if json:
        write_json({
            "id": done.id, "baud": done.baud, "model": saved.model, "undo": undo,
            "changes": [change_fields(change) for change in done.changes], "same": done.same, "left": done.left})
        return
    for change in done.changes:
        say(change_text(change))
    say(f"{_registers(len(done.changes))} changed, {done.same} were the same; it is id {done.id} at {done.baud} baud")
    if done.changes:
        say(f"to undo: {undo}" if undo else "only a backup taken before this would undo it")
    if servo.identity.firmware != saved.firmware:
        say(f"note: the backup is of firmware {saved.firmware}, the servo has {servo.identity.firmware}")
    if done.left:
        say(f"left as they are: {', '.join(done.left)} (--with-id brings them back)")


def factory_reset(
    servo_id: ServoId, /, *, line: Line, keep: Literal["nothing", "id", "id-and-baud"] = "nothing",
    yes: Flag = False, json: Json = False,
) -> None:
    """Bring a servo back to what the factory has set, and say where it then is.

    Parameters
    ----------
    keep
        What to leave as it is. Feetech's servos leave no choice.
    yes
        Do it: everything that was set up in this servo is lost.
    """
    if not yes:
        raise UsageError(
            f"a factory reset loses all that was set up in id {servo_id}: save it with `robotwalk servo backup`, "
            "then say --yes")
    with line.writing() as bench:
        servo = bench.servo(servo_id)
        done = bench.factory_reset(servo, workbench.Keep(keep))
    if json:
        write_json({"id": done.id, "baud": done.baud, "model": servo.model.name, "changed": done.changed})
    else:
        say(f"{servo.model.name}: {_registers(done.changed)} changed; it is now id {done.id} at {done.baud} baud")
    if not done.changed:
        complain("nothing has changed: it was as the factory made it, or its firmware does not know the instruction")


def _registers(count: int) -> str:
    return f"{count} register{'s' * (count != 1)}"
