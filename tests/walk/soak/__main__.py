"""Random command sequences, judged by MuJoCo's truth: `python -m tests.walk.soak [ROBOT ...] [--count N] ...`.

Progress goes to stderr; a line for each violation, with the command that repeats it, and a summary to stdout. The exit
code is 1 if anything was violated. Ctrl-C and SIGTERM end it early, with a summary of what was run.
"""

import argparse
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor

from .run import Outcome, run
from .verdict import BOUNDS, summary, violations

_ROBOTS = ("hexapod", "quadruped", "octopod", "pentapod")


def main() -> int:
    """Run, report, and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.walk.soak", description=__doc__)
    parser.add_argument("robots", nargs="*", default=list(_ROBOTS), metavar="ROBOT")
    parser.add_argument("--count", type=int, default=200, metavar="N", help="sequences for each robot (200)")
    parser.add_argument("--first-seed", type=int, default=0, metavar="S")
    parser.add_argument("--jobs", type=int, default=1, metavar="J", help="processes (1)")
    arguments = parser.parse_args()
    unknown = [robot for robot in arguments.robots if robot not in BOUNDS]
    if unknown:
        parser.error(f"no bounds for {', '.join(unknown)}; there are some for {', '.join(BOUNDS)}")
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.count)
    try:
        sound = [_soak(robot, seeds, arguments.jobs) for robot in arguments.robots]
    except KeyboardInterrupt:
        return 130
    return 0 if all(sound) else 1


def _soak(robot: str, seeds: Sequence[int], jobs: int) -> bool:
    """Run a robot's sequences, report, and return whether all was well."""
    outcomes: list[Outcome] = []
    sound = True
    try:
        for outcome in _progress(robot, seeds, jobs):
            outcomes.append(outcome)
            for complaint in violations(outcome):
                sound = False
                _say(f"{robot} seed {outcome.seed}: {complaint}; again: "
                     f"python -m tests.walk.soak {robot} --first-seed {outcome.seed} --count 1")
            if len(seeds) == 1:
                _tell(outcome)
    finally:
        if outcomes:
            text, little_slip = summary(robot, outcomes)
            _say(text)
    return sound and little_slip


def _progress(robot: str, seeds: Sequence[int], jobs: int) -> Iterator[Outcome]:
    began = time.monotonic()
    pool = ProcessPoolExecutor(jobs, initializer=signal.signal, initargs=(signal.SIGTERM, signal.SIG_DFL))
    try:
        for done, outcome in enumerate(pool.map(run, [robot] * len(seeds), seeds), 1):
            sys.stderr.write(f"\r{robot}: {done} of {len(seeds)} in {time.monotonic() - began:.0f} s ")
            sys.stderr.flush()
            yield outcome
        sys.stderr.write("\n")
    finally:
        pool.shutdown(cancel_futures=True)


def _tell(outcome: Outcome) -> None:
    """Show a single sequence."""
    time_of = 0.0
    for seconds, command in outcome.episodes:
        sys.stderr.write(f"{time_of:6.2f} s  {command}\n")
        time_of += seconds


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
