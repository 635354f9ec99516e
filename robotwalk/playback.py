"""A tape played back: the loop runs again on the time and the bytes that it had, and must do what it did."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple, NoReturn

from robotwalk.errors import BusError, UsageError
from robotwalk.loop import Loop
from robotwalk.ports import BytePort
from robotwalk.recorder import Row
from robotwalk.supervisor import Request
from robotwalk.tape import Call, Concluded, Failed, Now, Received, Sent, Step, Wait
from robotwalk.types import Command, JointState


class Difference(NamedTuple):
    """Where the loop does something else than the tape has."""

    tick: int  # counted from 1; 0: before the first
    time: int  # ns, when the clock was read last
    recorded: Step | None  # None: the tape is at its end
    replayed: Step | None  # None: the loop has done what it was called for
    error: Exception | None  # that the loop raised last; it may be what the run met too


class _Diverged(BaseException):
    """Nothing further can be compared. No handler of errors on the way may take it for one."""


class Playback:
    """Plays a tape to a loop that is built on `clock` and `port` and tells `conclude` of its ticks.

    Attributes:
        ticks, sent_bytes, received_bytes: how much was the same.
        difference: the first one found.
    """

    def __init__(self, steps: Iterator[Step]) -> None:
        self.ticks = self.sent_bytes = self.received_bytes = 0
        self.difference: Difference | None = None
        self._steps = steps
        self._time = 0
        self._error: Exception | None = None
        self._state = JointState((), (), (), (), ())  # as armed
        self._next = next(steps, None)

    def clock(self) -> "PlayedClock":
        """Return the clock of the tape."""
        return PlayedClock(self)

    def port(self, bus: str) -> "PlayedPort":
        """Return the tape's port of a bus."""
        return PlayedPort(bus, self)

    def run(self, make: Callable[[], Loop]) -> None:
        """Make the loop, and have it do all that the tape has, up to the first difference.

        Raises:
            UsageError: the tape has calls that this version's loop does not know.
        """
        try:
            loop = make()
            while isinstance(call := self._next, Call):
                self._advance()
                self._do(loop, call)
            if self._next is not None:
                self._diverge(None)
        except _Diverged:
            pass

    def conclude(self, row: Row) -> None:
        """Compare what the loop makes of the bytes with the tape."""
        self.expect(Concluded(row.joints))

    def expect(self, step: Wait | Sent | Concluded) -> None:
        """Compare what the loop does with the tape. The time of sending follows from the clock.

        Raises:
            BusError: so it ended then.
        """
        recorded = self._next
        if isinstance(recorded, Sent):
            recorded = recorded._replace(time=0)
        if type(recorded) is not type(step) or recorded != step:
            self._diverge(step)
        self._advance()
        if isinstance(step, Sent):
            self.sent_bytes += len(step.data)
            self._fail_as_then(step.bus)

    def now(self) -> int:
        """Return what the clock said then."""
        if not isinstance(self._next, Now):
            self._diverge(Now(self._time))
        assert isinstance(self._next, Now)
        self._time = self._next.time
        self._advance()
        return self._time

    def received(self, bus: str) -> bytes:
        """Return the bytes that had come then.

        Raises:
            BusError: so it ended then.
        """
        self._fail_as_then(bus)
        step = self._next
        if not (isinstance(step, Received) and step.bus == bus):
            self._diverge(Received(bus, self._time, b""))
        assert isinstance(step, Received)
        self._advance()
        self.received_bytes += len(step.data)
        return step.data

    def _do(self, loop: Loop, call: Call) -> None:
        action = self._action(loop, call)
        self.ticks += call.name == "tick"
        try:
            action()
        except Exception as error:  # the run may have met it too: what follows on the tape will tell
            self._error = error

    def _action(self, loop: Loop, call: Call) -> Callable[[], object]:
        match call:
            case Call("arm", float(torque)):
                return partial(self._arm, loop, torque)
            case Call("begin"):
                return partial(loop.begin, self._state)
            case Call("command", Command() as command):
                return partial(setattr, loop, "command", command)
            case Call("request", name) if name in {request.value for request in Request}:
                return partial(loop.request, Request(name))
            case Call("beat"):
                return loop.beat
            case Call("tick"):
                return loop.tick
            case Call("pause"):
                return loop.pause
            case Call("freeze"):
                return loop.freeze
            case Call("disarm"):
                return loop.disarm
            case Call("hold"):
                return loop.hold
            case Call("clear"):
                return loop.clear
        raise UsageError(f"the log has the loop do {call.name!r}, which this version does not know")

    def _arm(self, loop: Loop, torque: float) -> None:
        self._state = loop.arm(torque)

    def _fail_as_then(self, bus: str) -> None:
        if isinstance(self._next, Failed) and self._next.bus == bus:
            reason = self._next.reason
            self._advance()
            raise BusError(reason)

    def _diverge(self, replayed: Step | None) -> NoReturn:
        """Go no further: the loop does this instead of the tape's next step."""
        if self.difference is None:
            self.difference = Difference(self.ticks, self._time, self._next, replayed, self._error)
        raise _Diverged

    def _advance(self) -> None:
        self._next = next(self._steps, None)


class PlayedClock:
    """A clock that says what it said then."""

    def __init__(self, playback: Playback) -> None:
        self._playback = playback

    def now(self) -> int:
        """Return the time of then, ns."""
        return self._playback.now()

    def wait(self, ports: Sequence[BytePort], deadline: int) -> None:
        """Return at once, if the loop waited so then."""
        self._playback.expect(Wait(deadline))


class PlayedPort:
    """A port at which arrives what arrived then."""

    def __init__(self, bus: str, playback: Playback) -> None:
        self._bus = bus
        self._playback = playback

    def fileno(self) -> int:
        """Return -1: there is no descriptor."""
        return -1

    def waiting(self) -> int:
        """Return 0: nobody but a clock would ask."""
        return 0

    def write(self, data: bytes) -> None:
        """Compare bytes with those of then."""
        self._playback.expect(Sent(self._bus, 0, data))

    def read(self) -> bytes:
        """Return the bytes of then."""
        return self._playback.received(self._bus)

    def close(self) -> None:
        """Do nothing: there is no port to give back."""
