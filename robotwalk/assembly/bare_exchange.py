"""The bytes of a robot's ticks and nothing else, in a process like the loop's: what this computer can do at best.

The frames are made beforehand. They go out at each deadline, and so many bytes are read as the answers have; nobody
looks at them. What a loop misses beyond what this misses is its own doing.
"""

from collections.abc import Mapping
from multiprocessing.connection import Connection
from typing import NamedTuple

from hal.servo_line import ServoLine
from robotwalk.assembly.blueprint import Files, build
from robotwalk.assembly.lines import open_lines
from robotwalk.assembly.real_time import enter_real_time
from robotwalk.assembly.session import bus_of
from robotwalk.clock import Grid, WallClock
from robotwalk.realtime import name_process, processors_awake
from robotwalk.timing import Histogram, Percentiles

_NS = 1_000_000_000
_GRACE = 2_000_000  # ns past the bytes' time for an answer


class Bare(NamedTuple):
    """What came of it."""

    ticks: int
    missed: int
    wake: Percentiles


def serve_bare(
    files: Mapping[str, str], urls: Mapping[str, str], rate_hz: int, seconds: float, parent: Connection
) -> None:
    """Exchange for so long, and tell the parent of it: the body of a process of its own.

    The robot's torque is off meanwhile.
    """
    name_process("robotwalk-bare")
    blueprint, clock = build(Files.parse(files)), WallClock()
    bus = bus_of(blueprint, clock, open_lines(blueprint, {name: urls[name] for name in blueprint.bauds}))
    try:
        goals = bus.arm(_NS // rate_hz).position  # it finds out who answers to a fast read
        bus.disarm()
        scripts = [_Script(line, line.goal_frames(goals, goals)) for line in bus.lines]
        wake, ticks = Histogram(), round(seconds * rate_hz)
        with processors_awake() as awake:
            enter_real_time(awake)
            grid = Grid(rate_hz, after=clock.now())
            for _ in range(ticks):
                clock.wait((), grid.deadline)
                wake.add(clock.now() - grid.deadline)
                for script in scripts:
                    script.begin(clock.now())
                while pending := [script for script in scripts if script.expected]:
                    clock.wait([script.line.port for script in pending], min(script.deadline for script in pending))
                    for script in pending:
                        script.go_on(clock.now())
                grid.advance(clock.now())
        parent.send(Bare(ticks, grid.missed, wake.percentiles()))
    finally:
        bus.close()


class _Script:
    """One wire's frames, and the sizes of their answers."""

    def __init__(self, line: ServoLine, goals: bytes) -> None:
        self.line = line
        self.expected = self.deadline = 0  # bytes of the present answer that are not here; ns until it is given up
        readings = [reading for reader in line.cycle.readers for reading in reader.readings()]
        self._steps = [
            (before + reading.request, reading.reply.size)
            for before, reading in zip([goals, *[b""] * len(readings)], readings, strict=False)]
        self._next = 0

    def begin(self, now: int) -> None:
        """Send the first frames."""
        self._next = 0
        self.line.wire.receive()
        self._send(now)

    def go_on(self, now: int) -> None:
        """Take what has come; send the next frames when the answer is whole, or given up."""
        self.expected -= len(self.line.wire.receive())
        if self.expected <= 0 or now >= self.deadline:
            self._send(now)

    def _send(self, now: int) -> None:
        if self._next == len(self._steps):
            self.expected = 0
            return
        frames, self.expected = self._steps[self._next]
        self._next += 1
        self.line.wire.send(frames)
        self.deadline = now + self.line.wire.duration(len(frames) + self.expected) + _GRACE
