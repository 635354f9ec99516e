"""`robotwalk servo set-id` and `set-baud`: where a servo is to be found."""

from robotwalk.assembly import workbench
from robotwalk.cli.options import Json
from robotwalk.cli.output import say, write_json
from robotwalk.cli.servo.options import Line, ServoId


def set_id(old: ServoId, new: ServoId, /, *, line: Line, json: Json = False) -> None:
    """Give a servo another id. Its torque must be off, and nobody else may have the id, old or new.

    Connect one alone if several come from the factory: two with one id that answer alike sound like one.

    Parameters
    ----------
    old
        What it answers to now.
    new
        What it shall answer to.
    """
    with line.writing() as bench:
        servo = bench.servo(old)
        before = servo.place
        workbench.set_id(servo, new)
    _report(servo, before, f"set-id {new} {old} {line.words(servo.place.baud)}", json=json)


def set_baud(servo_id: ServoId, new_baud: int, /, *, line: Line, json: Json = False) -> None:
    """Give a servo another baud rate. Its torque must be off, and its id must be free there.

    Parameters
    ----------
    new_baud
        What it shall have; --baud is what it has.
    """
    with line.writing() as bench:
        servo = bench.servo(servo_id)
        before = servo.place
        workbench.set_baud(servo, new_baud)
    _report(servo, before, f"set-baud {servo_id} {before.baud} {line.words(new_baud)}", json=json)


def _report(servo: workbench.Servo, before: workbench.Place, undo: str, *, json: bool) -> None:
    now, undo = servo.place, f"robotwalk servo {undo}"
    if json:
        write_json({
            **now._asdict(), "model": servo.model.name, "before": before._asdict(), "changed": now != before,
            "undo": undo})
    elif now == before:
        say(f"{servo.model.name}: it is {now} already; nothing was written")
    else:
        say(f"{servo.model.name}: {now}, was {before}; read back there")
        say(f"to undo: {undo}")
