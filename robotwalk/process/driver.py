"""The driver's end: a loop in another process, to be driven as one in this process is."""

import os
import select
import subprocess
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from robotwalk import errors
from robotwalk.errors import RobotwalkError, SafetyStop
from robotwalk.loop import Tick
from robotwalk.process.guardian import Guardian
from robotwalk.process.mailbox import packed, unpacked
from robotwalk.process.messages import REPORT, Answer, Call, Orders, Status
from robotwalk.process.shared import Mailbox, Stop
from robotwalk.supervisor import Request, State
from robotwalk.timing import Histogram
from robotwalk.types import BusStatistics, Command, JointState, SensorStatistics, ServoCondition

_LOOK = 0.05  # s between looks whether the loop is still there
_STARTED = 30.0  # s within which its process must be ready
_ENDED = 5.0  # s within which it must be gone once it has said that it ends


class RemoteLoop:
    """A `robotwalk.cycle.Cycle` in a process of its own, and what reports on its bus and its IMU."""

    def __init__(
        self, rate_hz: int, mailbox: Mailbox, path: Path, doorbell: int, process: subprocess.Popen[bytes],
        guardian: Guardian, give_back: Callable[[], None],
    ) -> None:
        """Take a process that has just been started.

        Args:
            rate_hz: ticks per second.
            mailbox, path: shared with it, and the file's path.
            doorbell: an eventfd that it rings after each tick.
            process: it.
            guardian: who watches it.
            give_back: closes the ports.

        Raises:
            RobotwalkError: it does not start.
        """
        self.rate_hz = rate_hz
        self.state = State.STOP
        self.fault: str | None = None
        self.low = False
        self.armed = False
        self.missed = 0
        self.wake, self.exchange, self.compute = map(Histogram, mailbox.histograms)
        self._mailbox, self._path, self._doorbell = mailbox, path, doorbell
        self._process, self._guardian, self._give_back = process, guardian, give_back
        self._orders = Orders(Command(), away=True)
        self._seen = 0  # the newest tick
        self._gone: str | None = None  # why there is no loop any more, if there is none
        self._await(lambda: mailbox.status.number > 0, _STARTED)

    @property
    def command(self) -> Command:
        """What the robot is to do."""
        return self._orders.command

    @command.setter
    def command(self, command: Command) -> None:
        self._order(Orders(command, away=False))

    @property
    def status(self) -> Status:
        """What changes slowly, as last heard."""
        message = self._mailbox.status.read()
        if message is None:
            raise SafetyStop("the loop's process is gone")
        status: Status = unpacked(message.data)
        return status

    @property
    def notes(self) -> Sequence[str]:
        """What the last arming mended or found worth telling, in words."""
        return self.status.notes

    @property
    def cuts(self) -> Counter[tuple[str, str]]:
        """How many goals the gate has cut, by joint and by what."""
        return self.status.cuts

    def digest(self) -> str:
        """Return a hash of every joint position read and every goal sent so far."""
        return self.status.digest

    def conditions(self) -> Mapping[str, ServoCondition]:
        """Return what each servo last told of itself, by its joint."""
        return self.status.conditions

    def statistics(self) -> Mapping[str, BusStatistics]:
        """Return what each bus carried, by its name."""
        return self.status.statistics

    def beat(self) -> None:
        """Show that whoever drives the robot is still there."""
        self._mailbox.driver.write(b"")

    def request(self, request: Request) -> None:
        """Have the supervisor change the state. Raises UsageError if it may not."""
        self._call("request", request.value)

    def arm(self, torque: float = 1.0) -> JointState:
        """Have the bus switch torque on, every joint where it is. Raises BusError."""
        state: JointState = self._call("arm", torque)
        return state

    def begin(self, state: JointState) -> None:
        """Have the loop begin with the joints as they were armed; it goes round from now on."""
        self._call("begin")

    def tick(self) -> Tick:
        """Wait for the next tick and return it.

        Raises:
            SafetyStop: there will be none any more.
        """
        if self._orders.away:
            self._order(self._orders._replace(away=False))
            newest = self._mailbox.telemetry.newest()
            self._seen = max(self._seen, newest.number - 1 if newest else 0)
        while (message := self._mailbox.telemetry.next(self._seen)) is None:
            self._require()
            self._doze()
        self._seen = message.number
        report = REPORT.unpack(message.data)
        self.state, self.fault, self.low, self.missed = report.tick.state, report.fault, report.low, report.missed
        return report.tick

    def pause(self) -> None:
        """Let the robot stand as it does: the driver has nothing to say for a while."""
        self._order(self._orders._replace(away=True))

    def hold(self) -> None:
        """Have every joint stay where it is, whatever the driver wants, until `clear`."""
        self._mailbox.post_stop(Stop.HOLD)

    def clear(self) -> None:
        """Let a held robot go: it sits down, and may then stand up."""
        self._mailbox.post_stop(Stop.CLEAR)

    def disarm(self) -> list[str]:
        """Switch torque off; return the joints at which that could not be confirmed. Never raises."""
        try:
            doubtful = self._call("disarm")
        except RobotwalkError:
            doubtful = self._doubtful
            self.state, self.armed = State.STOP, False
        return list(doubtful)

    def freeze(self) -> None:
        """Have the loop hold every joint where it is, and end."""
        self._call("freeze")
        self.close()

    def close(self) -> None:
        """Have the loop end, and give the ports back. Never raises; may be called twice."""
        if self._doorbell < 0:
            return
        try:
            self._call("end")
            self._process.wait(_ENDED)
        except (RobotwalkError, subprocess.TimeoutExpired):
            self._process.kill()
            self._process.wait()
        self._gone = self._gone or "it was told to end"
        self._guardian.stand_down()
        self._give_back()
        self._path.unlink(missing_ok=True)
        os.close(self._doorbell)
        self._doorbell = -1

    def _order(self, orders: Orders) -> None:
        self._orders = orders
        self._mailbox.command.write(packed(orders))
        self.beat()

    def _call(self, name: str, argument: object = None) -> Any:
        """Have the loop do something, and return what came of it.

        Raises:
            SafetyStop: there is no loop any more.
            RobotwalkError: it could not do it.
        """
        self._require()
        number = self._mailbox.call.write(packed(Call(name, argument)))
        self._await(lambda: self._mailbox.answer.number >= number)
        message = self._mailbox.answer.read()
        assert message is not None, "nobody else writes it"
        answer: Answer = unpacked(message.data)
        self.state, self.armed, self._seen = answer.state, answer.armed, max(self._seen, answer.tick)
        if answer.error is not None:
            kind, text = answer.error
            raise getattr(errors, kind, RobotwalkError)(text)
        return answer.result

    def _await(self, done: Callable[[], bool], seconds: float | None = None) -> None:
        """Wait until something is so."""
        until = None if seconds is None else time.monotonic() + seconds
        while not done():
            self._require()
            self._doze()
            if until is not None and time.monotonic() > until:
                self._process.kill()
                raise RobotwalkError("the loop's process does not start")

    def _doze(self) -> None:
        """Sleep until the loop rings, or for a moment."""
        if select.select([self._doorbell], [], [], _LOOK)[0]:
            os.eventfd_read(self._doorbell)

    def _require(self) -> None:
        """Raise SafetyStop if the loop is no more; by then the robot is as safe as it gets."""
        if self._gone is None:
            if self._guardian.reason is not None:
                self._guardian.wait()
                self._gone = self._guardian.reason
            else:
                message = self._mailbox.status.read()
                self._gone = unpacked(message.data).ended if message is not None else None
            if self._gone is None:
                return
            self.state = State.STOP
        doubtful = self._doubtful
        doubt = f"torque may still be on at {', '.join(doubtful)}: cut the power" if doubtful else "torque is off"
        raise SafetyStop(f"{self._gone}; {doubt}")

    @property
    def _doubtful(self) -> Sequence[str]:
        """Joints at which torque may still be on, when there is no loop any more."""
        return self._guardian.doubtful if self._guardian.reason else self.status.doubtful


class RemoteSensor:
    """What a loop in another process tells of an IMU or of foot switches."""

    def __init__(self, loop: RemoteLoop, line: str) -> None:
        self._loop, self._line = loop, line

    def statistics(self) -> SensorStatistics:
        """Return what it said since its port was opened."""
        return self._loop.status.sensors[self._line]

    def close(self) -> None:
        """Do nothing: its port goes with the others."""
