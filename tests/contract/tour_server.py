"""Serves a tour bench for each model named, in real time, in a process of its own: `tour_server FOLDER MODEL...`.

It says "ready" when the terminals are there, and what was witnessed, as JSON, when its standard input is closed.
"""

import json
import select
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from sim_backend.pty_endpoint import open_ptys
from sim_backend.real_time import RealTime
from sim_backend.server import Server
from sim_backend.simulated_clock import SimulatedClock
from sim_backend.wire import SimulatedPort
from tests.contract.tour_bench import BAUD, MS, TourBench


class Benches(NamedTuple):
    clock: SimulatedClock
    ports: Mapping[str, SimulatedPort]


def main(folder: str, *names: str) -> None:
    clock = SimulatedClock()
    benches = {name: TourBench(name, 1, 2, clock=clock, step_ns=5 * MS) for name in names}
    clock.wait((), 20 * MS)

    def check() -> None:
        if select.select([sys.stdin], [], [], 0)[0]:
            raise EOFError

    with open_ptys(Path(folder), dict.fromkeys(names, BAUD)) as endpoints:
        server = Server(
            Benches(clock, {name: bench.port for name, bench in benches.items()}), endpoints, RealTime(clock.now()),
            lambda text: None)
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        try:
            server.run(check, None)
        except EOFError:
            seen = {
                name: [sorted(bench.witness.instructions), sorted(bench.witness.errors)]
                for name, bench in benches.items()}
            sys.stdout.write(json.dumps(seen) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
