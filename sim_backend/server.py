"""A simulated robot as a device in real time: one thread, one loop.

Simulated time follows the monotonic clock. Bytes go onto the simulated wire when they arrive here, and to the
client when its adapter hands them over; all else is as in lock-step.
"""

import contextlib
import gc
import select
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

from robotwalk.model import RobotModel
from robotwalk.realtime import DEVICE_PRIORITY, raise_priority, sharpen_timers
from sim_backend.endpoint import Endpoint
from sim_backend.real_time import RealTime
from sim_backend.simulated_clock import SimulatedClock
from sim_backend.simulation import SimulatedRobot
from sim_backend.truth_stream import TruthStream
from sim_backend.wire import SimulatedPort

_NS = 1_000_000_000
_WARM_UP = 100_000_000  # ns simulated: it comes to rest on its belly, and all code that will run has run


class Ported(Protocol):
    """What a server needs of what it serves."""

    @property
    def clock(self) -> SimulatedClock:
        """Its time."""
        ...

    @property
    def ports(self) -> Mapping[str, SimulatedPort]:
        """The host's end of each bus."""
        ...


class Server:
    """Couples the ports of a simulated robot to endpoints that programs open, and its clock to the wall's."""

    def __init__(
        self, robot: Ported, endpoints: Mapping[str, Endpoint], pace: RealTime, warn: Callable[[str], None],
    ) -> None:
        """Serve each bus at the endpoint of its name. `warn` is told, once, when the computer is too slow."""
        self._clock = robot.clock
        self._ports = list(robot.ports.values())
        self._couplings: list[tuple[SimulatedPort, Endpoint]] = [
            (robot.ports[bus], endpoint) for bus, endpoint in endpoints.items()]
        self._pace = pace
        self._warn: Callable[[str], None] | None = warn

    def run(self, check: Callable[[], None], seconds: float | None) -> None:
        """Serve for so long, or until `check` raises."""
        ends = None if seconds is None else time.monotonic_ns() + round(seconds * _NS)
        while ends is None or time.monotonic_ns() < ends:
            check()
            self._catch_up()
            # There is always a next event: the next physics step.
            wake = self._pace.wall(self._clock.next_event())
            self._listen(wake if ends is None else min(wake, ends))

    def _catch_up(self) -> None:
        """Run the simulation up to now, and hand clients what is due to them on the way."""
        target = self._pace.target(self._clock.now())
        if self._pace.dropped and self._warn:
            self._warn("this computer stalled or is too slow for real time: simulated time was dropped")
            self._warn = None
        while True:
            self._clock.wait(self._ports, target)
            due = [(port, endpoint) for port, endpoint in self._couplings if port.waiting()]
            if not due:
                return
            for port, endpoint in due:
                endpoint.send(port.read())

    def _listen(self, until: int) -> None:
        """Sleep until that monotonic time or until bytes come, and put those onto the wire at this moment."""
        descriptors = [descriptor for _, endpoint in self._couplings for descriptor in endpoint.descriptors()]
        # select() counts in microseconds; poll() would round up to whole milliseconds.
        ready, _, _ = select.select(descriptors, [], [], max(0, until - time.monotonic_ns()) / _NS)
        if not ready:
            return
        self._catch_up()
        for port, endpoint in self._couplings:
            data, baud = endpoint.receive(ready), endpoint.baud
            if data and baud:
                port.baud = baud
                port.write(data)


def serve(
    robot: SimulatedRobot, model: RobotModel, doors: AbstractContextManager[Mapping[str, Endpoint]], *,
    truth: Path | None, seconds: float | None, ready: Callable[[dict[str, str]], None], check: Callable[[], None],
    warn: Callable[[str], None],
) -> None:
    """Open the endpoints, tell `ready` their URLs by bus, and serve for so long or until `check` raises.

    Raises:
        BusError, UsageError: an endpoint or the file of the truth cannot be opened.
    """
    robot.clock.wait((), _WARM_UP)
    # What is there stays there: the collector need not look at it again while others wait for a reply.
    gc.collect()
    gc.freeze()
    sharpen_timers()
    raise_priority(DEVICE_PRIORITY)
    with doors as endpoints, contextlib.ExitStack() as stack:
        pace = RealTime(robot.clock.now())
        if truth is not None:
            stack.callback(TruthStream(truth, model, robot, pace).close)
        server = Server(robot, endpoints, pace, warn)
        check()
        ready({bus: endpoint.url for bus, endpoint in endpoints.items()})
        server.run(check, seconds)
