"""A loop's sign of life, and what ends its arming: given wherever it waits, for there it passes by all the time."""

import contextlib
from collections.abc import Iterator, Sequence

from robotwalk.clock import WallClock
from robotwalk.errors import SafetyStop
from robotwalk.ports import BytePort
from robotwalk.process.shared import Mailbox, Pulse
from robotwalk.process.stop_input import StopWatch


class PulsingClock(WallClock):
    """The wall's clock, of a loop in a process of its own.

    Attributes:
        armed: torque is on, or coming.
    """

    def __init__(self, mailbox: Mailbox) -> None:
        self.armed = False
        self._mailbox = mailbox
        self._heeds: int | None = None  # the number of the newest stop before arming
        self._watch: StopWatch | None = None  # while arming

    def wait(self, ports: Sequence[BytePort], deadline: int) -> None:
        """Return once a port has bytes to read or `deadline` has come; sleep meanwhile.

        Raises:
            SafetyStop: somebody said stop while the robot was being armed.
        """
        self._mailbox.beat(Pulse(self.now(), self.armed))
        if self._heeds is not None and self._mailbox.stop.number != self._heeds:
            self._heeds = None
            raise SafetyStop("told to stop while the robot was being armed")
        if self._watch is not None and (heeded := self._watch.look()) is not None:
            self._watch = None
            raise SafetyStop(f"{heeded.reason} while the robot was being armed")
        super().wait(ports, deadline)

    @contextlib.contextmanager
    def arming(self, watch: StopWatch) -> Iterator[None]:
        """Meanwhile torque comes on, which takes seconds, and a stop ends it."""
        self.armed = True
        self._heeds, self._watch = self._mailbox.stop.number, watch
        try:
            yield
        finally:
            self._heeds = self._watch = None
