"""`python -m tests.fuzz [INPUTS] [FIRST_SEED]`: so many inputs of each kind, and a report of how many there were."""

import sys
import time
from random import Random

from . import fakes, hosts, sensors


def main(inputs: int = 20_000, first: int = 0) -> None:
    """Run all trials; the first that fails ends it, and its seed is told."""
    total, began = 0, time.monotonic()
    for name, trial in [*hosts.trials(), *fakes.trials(), *sensors.trials()]:
        size = 0
        for seed in range(first, first + inputs):
            try:
                size += len(trial(Random(f"{name} {seed}")))
            except BaseException:
                print(f"{name}: seed {seed}", file=sys.stderr)  # noqa: T201 (a tool of the repository's own)
                raise
        total += inputs
        print(f"{name:32} {inputs} inputs, {size} bytes")  # noqa: T201
    print(f"{total} inputs in {time.monotonic() - began:.0f} s, no failure")  # noqa: T201


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
