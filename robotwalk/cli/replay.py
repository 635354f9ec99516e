"""`robotwalk replay`: run the loop of a log again, on the time and the bytes of then."""

from pathlib import Path
from typing import Any

from robotwalk.assembly import replay as replays
from robotwalk.cli.options import Json
from robotwalk.cli.output import complain, say, write_json

_NS = 1_000_000_000


def replay(log: Path, /, *, json: Json = False) -> int:
    """Run the loop of a log again, on the time and the bytes of then, and compare every byte that it sends.

    Parameters
    ----------
    log
        From `robotwalk walk --log`. The robot's files are in it: what they are now does not matter.
    """
    done = replays.replay(log)
    if json:
        write_json(_fields(done))
    else:
        _show(done)
    if done.damage is not None:
        complain(f"{log} is not whole, {done.damage}: that is as far as it goes")
    return 0 if done.difference is None else 1


def _fields(done: replays.Replay) -> dict[str, Any]:
    difference = done.difference
    return {
        "robot": done.robot, "ticks": done.ticks, "sent_bytes": done.sent_bytes, "received_bytes": done.received_bytes,
        "identical": difference is None, "damage": done.damage,
        "difference": None if difference is None else {
            "tick": difference.tick, "time_ns": difference.time,
            "recorded": replays.in_words(difference.recorded), "replayed": replays.in_words(difference.replayed)}}


def _show(done: replays.Replay) -> None:
    difference = done.difference
    if difference is None:
        say(f"{done.robot}: {done.ticks} ticks, {done.sent_bytes + done.received_bytes} bytes, identical")
        return
    say(f"{done.robot}: differs in tick {difference.tick}, at {difference.time / _NS:.6f} s")
    say(f"  in the log    {replays.in_words(difference.recorded)}")
    say(f"  in the replay {replays.in_words(difference.replayed)}")
    if difference.error is not None:
        say(f"  the loop had raised {difference.error!r}")
