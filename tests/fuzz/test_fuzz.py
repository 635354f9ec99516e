"""A short run of what `make fuzz` does for long."""

from collections.abc import Callable
from random import Random

import pytest

from . import fakes, hosts, sensors

_INPUTS = 1000  # of each

TRIALS = dict([*hosts.trials(), *fakes.trials(), *sensors.trials()])


@pytest.mark.parametrize("name", TRIALS)
def test_garbled_bytes_do_no_harm(name: str) -> None:
    trial: Callable[[Random], bytes] = TRIALS[name]
    # Each trial asserts what is to be so: see hosts, fakes, sensors.
    streams = {trial(Random(f"{name} {seed}")) for seed in range(_INPUTS)}
    assert len(streams) > 0.9 * _INPUTS, "it was garbled in many ways"
