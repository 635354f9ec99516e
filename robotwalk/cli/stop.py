"""`robotwalk stop` and `robotwalk clear`: to every loop that runs, or to one. Only light modules: it must be quick."""

import argparse
import re
import time
from pathlib import Path

from robotwalk.cli.output import complain, say, write_json
from robotwalk.errors import UsageError
from robotwalk.process.shared import Mailbox, Stop, running

_PATIENCE = 1.0  # s within which a loop heeds it, if it lives
_LOOK = 0.002  # s
_NONE_RUNS = 4


def main(words: list[str]) -> int:
    """Run `stop` or `clear` from the command line; return the exit code."""
    does = stop if words[0] == "stop" else clear
    parser = argparse.ArgumentParser(prog=f"robotwalk {words[0]}", description=does.__doc__)
    parser.add_argument("robot", nargs="?", help="only this one: its name, its file, or its loop as a stop told it")
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    if words[0] == "clear":
        chosen = parser.parse_args(words[1:])
        return clear(chosen.robot, json=chosen.json)
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--sit", action="store_true", help="sit down, then torque off")
    how.add_argument("--limp", action="store_true", help="torque off at once")
    chosen = parser.parse_args(words[1:])
    return stop(chosen.robot, sit=chosen.sit, limp=chosen.limp, json=chosen.json)


def stop(robot: str | None = None, /, *, sit: bool = False, limp: bool = False, json: bool = False) -> int:
    """Have every robot that runs, or the one that is named, hold where it is, until `robotwalk clear`."""
    return _tell(Stop.LIMP if limp else Stop.SIT if sit else Stop.HOLD, robot, json)


def clear(robot: str | None = None, /, *, json: bool = False) -> int:
    """Let robots go that were told to stop: they sit down, unless a servo reports a fault."""
    return _tell(Stop.CLEAR, robot, json)


def _tell(what: Stop, robot: str | None, json: bool) -> int:
    """Tell all loops, or those of a robot; say what each does."""
    name_of_it = None if robot is None else _name_of(robot)
    told, others = [], []
    for name, mailbox in running():
        if name_of_it in (None, name, name.rpartition("-")[0]):
            told.append((name, mailbox, mailbox.post_stop(what), time.monotonic()))
        else:
            others.append(name)
    loops = []
    for name, mailbox, number, since in told:
        does = _answer(mailbox, number, since)
        loops.append({"loop": name, "heeded": does is not None, "does": does})
        if does is None:
            complain(f"{name} does not heed it: cut its power")
        elif not json:
            say(f"{name} {does}")
    if json:
        write_json({"stop": what.name.lower(), "loops": loops})
    if not told:
        known = f"; there are {', '.join(others)}" if others else ""
        complain(f"no loop{f' of {name_of_it}' if name_of_it else ''} runs here{known}")
        return _NONE_RUNS
    return 0 if all(loop["heeded"] for loop in loops) else 1


def _name_of(robot: str) -> str:
    """Return a robot's name; of its file no more is read than that.

    Raises:
        UsageError: the file cannot be read, or has no name.
    """
    if Path(robot).suffix not in (".yaml", ".yml"):
        return robot
    try:
        text = Path(robot).read_text()
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read {robot}; `robotwalk stop` alone is for every robot") from error
    found = re.search(r"^name:\s*['\"]?([^'\"#\n]*[^'\"#\s])", text, re.MULTILINE)
    if found is None:
        raise UsageError(f"{robot} has no name; `robotwalk stop` alone is for every robot")
    return found[1]


def _answer(mailbox: Mailbox, number: int, since: float) -> str | None:
    """Return what a loop does about it, in words that follow its name; None if it does not answer."""
    while time.monotonic() - since < _PATIENCE:
        message = mailbox.heed.read()
        if message is not None and message.number >= number:
            return message.data.decode(errors="replace")
        time.sleep(_LOOK)
    return None
