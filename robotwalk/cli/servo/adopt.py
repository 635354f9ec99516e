"""`robotwalk servo adopt`: a replacement takes a servo's place in a robot."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from robotwalk.assembly import workbench
from robotwalk.cli.options import Json
from robotwalk.cli.output import complain, say, write_json
from robotwalk.cli.servo.look import Search
from robotwalk.cli.servo.options import Line, Port, Real, ServoId
from robotwalk.cli.servo.registers import change_fields, change_text

_ID = "The new servo's id now, if that is one of the robot's; nothing else should be connected then."


def adopt(
    robot: str, joint: str, /, *, port: Port | None = None, backup: Path | None = None,
    id: Annotated[ServoId | None, Parameter(help=_ID)] = None,
    baud: int | None = None, real: Real = False, json: Json = False,
) -> None:
    """Set up a new servo for a joint: baud rate, id, no return delay, and what the robot needs of it.

    It is the one servo on the line that is none of the robot's. The old one must be gone.

    Parameters
    ----------
    robot
        A bundled name, or the path of a YAML file.
    joint
        The joint whose servo it replaces.
    port
        The joint's line; default: what the robot's file says.
    backup
        Of the old servo, from `robotwalk servo backup`: all that it kept is brought over, but not its offset.
    baud
        The new servo's baud rate now. Default: all are looked at.
    """
    seat = workbench.seat(robot, joint, port)
    vacancy, model = seat.vacancy, seat.wired.model
    settings = vacancy.settings(workbench.read_backup(backup, seat.blueprint.servos) if backup else None)
    search = Search()
    with workbench.bench(
            seat.url, baud=baud or seat.baud, protocol=model.protocol, real=real, writes=True,
            servos=seat.blueprint.servos) as bench:
        search.run(bench, [baud] if baud else [rate for rate in bench.bauds() if rate in model.baud_rates])
        for clash in search.clashes:
            complain(str(clash))
        new = vacancy.newcomer(search.found, id)
        bench.tune(new.baud)
        servo = bench.servo(new.id)
        before = servo.place
        changes = vacancy.fill(servo, settings)
    calibrate = f"robotwalk calibrate {robot} {joint} --port {seat.bus}={seat.url}" + " --real" * real
    undo = f"robotwalk servo factory-reset {servo.id} --yes {Line(port=seat.url, real=real).words(servo.place.baud)}"
    if json:
        write_json({
            "joint": joint, **servo.place._asdict(), "model": model.name, "before": before._asdict(),
            "changes": [change_fields(change) for change in changes], "next": calibrate, "undo": undo})
        return
    for change in changes:
        say(change_text(change))
    say(f"{joint}: the {model.name} that was {before} is {servo.place}; all was read back")
    say(f"its zero is not the old one's. Next: {calibrate}")
    say(f"to undo, with it alone on the line, which makes it as it was when new: {undo}")
