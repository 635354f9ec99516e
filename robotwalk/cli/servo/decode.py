"""`robotwalk servo decode`: what is said on a bus, in words."""

import math
import sys
from collections.abc import Iterable
from pathlib import Path

from robotwalk.assembly import transcript
from robotwalk.cli.options import Json
from robotwalk.cli.output import say, write_json
from robotwalk.cli.servo.options import BAUD, Baud, Protocol
from robotwalk.errors import UsageError

_ARROWS = {"instruction": "->", "status": "<-", "garbage": "??"}


def decode(
    log: Path | None = None, /, *, port: str | None = None, baud: Baud = BAUD, protocol: Protocol = None,
    robot: str | None = None, bus: str | None = None, servo: str | None = None, seconds: float | None = None,
    id: int | None = None, json: Json = False,
) -> None:
    """Print a log's traffic in words, or that on a line where others speak: it listens, and sends nothing.

    Parameters
    ----------
    log
        From `robotwalk walk --log`.
    port
        A line to listen to, in place of a log.
    robot
        Whose servos are on that line: then registers are told by name.
    bus
        Which of the robot's buses it is; of a log, the only one to print.
    servo
        In place of a robot: the model of all servos there (see `robotwalk list servos`).
    seconds
        How long to listen. Default: until Ctrl-C.
    id
        Print only what is said to this servo alone or by it alone.
    """
    if (log is None) == (port is None):
        raise UsageError("say what to decode: either a log or --port URL")
    if seconds is not None and not (math.isfinite(seconds) and seconds > 0.0):
        raise UsageError(f"--seconds should be above 0, not {seconds}")
    if log is not None:
        lines: Iterable[transcript.Line] = (
            line for line in transcript.of_log(log) if bus is None or line.bus == bus)
    else:
        lines = transcript.of_line(
            str(port), baud=baud, protocol=protocol, robot=robot, bus=bus, servo=servo, seconds=seconds)
    for line in lines:
        said = line.said
        if id is not None and said.id != id:
            continue
        if json:
            write_json({
                "t": round(line.seconds, 6), "bus": line.bus, "kind": said.kind, "id": said.id, "words": said.words,
                "bytes": said.raw.hex(" ")})
        else:
            say(f"{line.seconds:12.6f}  {line.bus}  {_ARROWS[said.kind]}  {said.words}")
        if port is not None:
            sys.stdout.flush()


