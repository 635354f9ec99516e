"""Loops on one computer keep off each other's processors."""

import os
import subprocess
import sys
from contextlib import ExitStack

LOOP = "import os; from robotwalk.realtime import pin; print(pin(), *os.sched_getaffinity(0), flush=True); input()"


def test_each_loop_takes_a_processor_of_its_own_until_none_is_left() -> None:
    places: list[int] = []
    with ExitStack() as stack:
        for _ in range(len(os.sched_getaffinity(0)) + 1):  # the last has to share, or an earlier one: others may run
            loop = stack.enter_context(subprocess.Popen(
                [sys.executable, "-c", LOOP], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True))
            stack.callback(loop.kill)
            assert loop.stdout is not None
            alone, *affinity = loop.stdout.readline().split()
            (place,) = map(int, affinity)
            assert place in os.sched_getaffinity(0)
            if alone == "False":
                return
            assert place not in places
            places.append(place)
    raise AssertionError(f"more loops than processors, and each thought itself alone: {places}")
