"""`robotwalk stop` and `robotwalk clear`: to every loop that runs. Only light modules: it must be quick."""

import argparse
import time

from robotwalk.cli.output import complain, say, write_json
from robotwalk.process.shared import Mailbox, Stop, running

_PATIENCE = 1.0  # s within which a loop heeds it, if it lives
_LOOK = 0.002  # s
_NONE_RUNS = 4


def main(words: list[str]) -> int:
    """Run `stop` or `clear` from the command line; return the exit code."""
    does = stop if words[0] == "stop" else clear
    parser = argparse.ArgumentParser(prog=f"robotwalk {words[0]}", description=does.__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    if words[0] == "clear":
        return clear(json=parser.parse_args(words[1:]).json)
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--sit", action="store_true", help="sit down, then torque off")
    how.add_argument("--limp", action="store_true", help="torque off at once")
    chosen = parser.parse_args(words[1:])
    return stop(sit=chosen.sit, limp=chosen.limp, json=chosen.json)


def stop(*, sit: bool = False, limp: bool = False, json: bool = False) -> int:
    """Have every robot that runs hold where it is, until `robotwalk clear`."""
    return _tell(Stop.LIMP if limp else Stop.SIT if sit else Stop.HOLD, json)


def clear(*, json: bool = False) -> int:
    """Let robots go that were told to stop: they sit down, unless a servo reports a fault."""
    return _tell(Stop.CLEAR, json)


def _tell(what: Stop, json: bool) -> int:
    """Tell all loops; say what each does."""
    told = [(name, mailbox, mailbox.post_stop(what), time.monotonic()) for name, mailbox in running()]
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
        complain("no loop runs here")
        return _NONE_RUNS
    return 0 if all(loop["heeded"] for loop in loops) else 1


def _answer(mailbox: Mailbox, number: int, since: float) -> str | None:
    """Return what a loop does about it, in words that follow its name; None if it does not answer."""
    while time.monotonic() - since < _PATIENCE:
        message = mailbox.heed.read()
        if message is not None and message.number >= number:
            return message.data.decode(errors="replace")
        time.sleep(_LOOK)
    return None
