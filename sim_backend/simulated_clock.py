"""Simulated time: it passes only while somebody waits, event by event."""

import heapq
from collections.abc import Callable, Sequence

from robotwalk.ports import BytePort


class SimulatedClock:
    """One queue of events for the physics and all wires, so that several buses overlap as on real wires.

    Events at one time run in the order in which they were scheduled, so that runs repeat bit for bit.
    """

    def __init__(self) -> None:
        self._now = 0
        self._events: list[tuple[int, int, Callable[[], None]]] = []
        self._scheduled = 0

    def now(self) -> int:
        """Return the simulated time, ns."""
        return self._now

    def schedule(self, when: int, event: Callable[[], None]) -> None:
        """Have `event` run when the time reaches `when` (ns), at once if that is past."""
        heapq.heappush(self._events, (max(when, self._now), self._scheduled, event))
        self._scheduled += 1

    def next_event(self) -> int:
        """Return when the next event runs, ns. There must be one."""
        return self._events[0][0]

    def wait(self, ports: Sequence[BytePort], deadline: int) -> None:
        """Let time pass until a port has bytes to read or `deadline` has come."""
        events = self._events
        while not any(port.waiting() for port in ports):
            if not events or events[0][0] > deadline:
                self._now = max(self._now, deadline)
                return
            self._now, _, event = heapq.heappop(events)
            event()
