"""The tape of a run: all that passes between the loop and what is outside it, in order.

    Call              what its driver has the loop do: "tick", "command", "arm", ...
    Now, Received     what it learns: the time, and bytes
    Wait, Sent        what it does: it waits, and sends bytes
    Failed            a port that takes or gives no bytes any more
    Concluded         what it makes of the bytes: the state of the joints

The rest follows from this: `robotwalk.playback` runs the loop again, and sees whether it waits, sends and
concludes as it did.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from robotwalk.errors import BusError
from robotwalk.ports import BytePort, Clock
from robotwalk.types import JointState

_LONGEST_BATCH = 256  # steps; a tick has some twenty, arming has thousands


class Call(NamedTuple):
    """The driver calls a method of the loop."""

    name: str
    argument: Any = None  # what JSON can hold


class Now(NamedTuple):
    """The clock is read."""

    time: int  # ns


class Wait(NamedTuple):
    """The loop waits for bytes, or for the deadline."""

    deadline: int  # ns


class Sent(NamedTuple):
    """Bytes go out on a bus."""

    bus: str
    time: int  # ns
    data: bytes


class Received(NamedTuple):
    """A bus is read. Often there is nothing."""

    bus: str
    time: int  # ns
    data: bytes


class Failed(NamedTuple):
    """What was asked of a port last has failed."""

    bus: str
    reason: str


class Concluded(NamedTuple):
    """The joints, as a tick has read them."""

    joints: JointState


Step = Call | Now | Wait | Sent | Received | Failed | Concluded


class Tape:
    """Collects steps; hands them over in batches, where a tick begins: the loop has time then, as it waits."""

    def __init__(self, hand_over: Callable[[list[Step]], None]) -> None:
        self._hand_over = hand_over
        self._steps: list[Step] = []

    def add(self, step: Step) -> None:
        """Take the next step."""
        self._steps.append(step)
        if len(self._steps) >= _LONGEST_BATCH:
            self.cut()

    def call(self, name: str, argument: Any = None) -> None:
        """Take a call of the loop by its driver."""
        if name == "tick":
            self.cut()
        self.add(Call(name, argument))

    def cut(self) -> None:
        """Hand over what has been collected."""
        if self._steps:
            steps, self._steps = self._steps, []
            self._hand_over(steps)


class TapedClock:
    """A clock whose every answer goes onto the tape."""

    def __init__(self, clock: Clock, tape: Tape) -> None:
        self._clock = clock
        self._add = tape.add

    def now(self) -> int:
        """Return the time in ns."""
        time = self._clock.now()
        self._add(Now(time))
        return time

    def wait(self, ports: Sequence[BytePort], deadline: int) -> None:
        """Return once a port has bytes to read or `deadline` has come."""
        self._add(Wait(deadline))
        # What the clock asks of the ports is its own affair.
        self._clock.wait([port.inner if isinstance(port, TapedPort) else port for port in ports], deadline)


class TapedPort:
    """A port whose every byte goes onto the tape, with its time.

    Attributes:
        inner: the port itself.
    """

    def __init__(self, bus: str, inner: BytePort, clock: Clock, tape: Tape) -> None:
        """Tape what passes at `inner`, by the time of an untaped `clock`."""
        self.inner = inner
        self._bus = bus
        self._now = clock.now
        self._add = tape.add

    def fileno(self) -> int:
        """Return the port's descriptor."""
        return self.inner.fileno()

    def waiting(self) -> int:
        """Return how many bytes have come. Only clocks ask; it is not taped."""
        return self.inner.waiting()

    def write(self, data: bytes) -> None:
        """Send bytes."""
        self._add(Sent(self._bus, self._now(), data))
        try:
            self.inner.write(data)
        except BusError as error:
            self._add(Failed(self._bus, str(error)))
            raise

    def read(self) -> bytes:
        """Return the bytes that have come."""
        try:
            data = self.inner.read()
        except BusError as error:
            self._add(Failed(self._bus, str(error)))
            raise
        self._add(Received(self._bus, self._now(), data))
        return data

    def close(self) -> None:
        """Give the line back."""
        self.inner.close()
