"""The loop's end: does what the mailbox says with one loop, and shows what comes of it.

    the driver's calls and orders   are heeded between ticks
    stops, from anybody             hold, sit or let go, whatever the driver wants
    a driver that is silent         has the loop slow to a stand (see `Loop`), and later sit
    the command that is gone        SIGTERM comes from the kernel then: sit
"""

import os
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from robotwalk.clock import WallClock
from robotwalk.cycle import SensorReports
from robotwalk.errors import RobotwalkError, UsageError
from robotwalk.interrupts import Interrupts
from robotwalk.loop import Loop, Tick
from robotwalk.ports import BytePort, ServoBus
from robotwalk.process.mailbox import packed, unpacked
from robotwalk.process.messages import Answer, Call, Orders, Report, Status
from robotwalk.process.shared import Mailbox, Pulse, Stop
from robotwalk.robot import Robot
from robotwalk.supervisor import Request, State
from robotwalk.types import JointState

_NS = 1_000_000_000
_IDLE = 5_000_000  # ns between looks into the mailbox while torque is off
_NEWS = 0.5  # s between two statuses
_ABANDONED = 10.0  # s without a sign of the driver before the robot sits down


class PulsingClock(WallClock):
    """The wall's clock, of a loop that shows a sign of life wherever it waits."""

    def __init__(self, mailbox: Mailbox) -> None:
        self._mailbox = mailbox
        self.armed = False  # torque is on, or coming

    def wait(self, ports: Sequence[BytePort], deadline: int) -> None:
        """Return once a port has bytes to read or `deadline` has come; sleep meanwhile."""
        self._mailbox.beat(Pulse(time.monotonic_ns(), self.armed))
        super().wait(ports, deadline)


class Servant:
    """Serves until it is told to end, or has brought the robot down."""

    def __init__(
        self, loop: Loop, bus: ServoBus, sensors: Mapping[str, SensorReports], robot: Robot, clock: PulsingClock,
        mailbox: Mailbox, doorbell: int, lacking: Sequence[str],
    ) -> None:
        """Join the parts.

        Args:
            loop, bus, sensors: what is served; the sensors by the names of their lines.
            robot: it again, as a driver has it: to sit down without one.
            clock: the loop's.
            mailbox: shared with the driver.
            doorbell: an eventfd to ring after each tick.
            lacking: what there is no right to, in words.
        """
        self._loop, self._bus, self._sensors, self._robot = loop, bus, sensors, robot
        self._clock, self._mailbox, self._doorbell, self._lacking = clock, mailbox, doorbell, tuple(lacking)
        self._held = JointState((), (), (), (), ())  # as armed
        self._runs = False  # the loop goes round
        self._ended: str | None = None
        self._doubtful: list[str] = []
        self._away = True  # the driver; it need not beat
        self._numbers: Counter[str] = Counter()  # of the newest message heeded, by slot
        self._heard = clock.now()
        self._news_at = 0
        self._ticks = 0
        self._interrupts = Interrupts()
        robot.observers.append(self._show)

    def serve(self) -> None:
        """Serve. Whatever is wrong with the loop itself comes out as an exception: the guardian will see to it."""
        self._interrupts.install()
        self._tell()
        while self._ended is None:
            self._listen()
            if self._runs:
                tick = self._loop.tick()
                if tick.state is State.STOP:  # a fault has brought it down
                    self._disarm()
                self._show(tick)
            elif self._ended is None:
                self._clock.wait((), self._clock.now() + _IDLE)
                self._clock.armed = self._loop.armed
            if self._clock.now() >= self._news_at:
                self._tell()
        self._clock.armed = False
        self._tell()
        self._ring()

    def _listen(self) -> None:
        """Heed what has come."""
        self._heed_stops()
        if self._is_new("command"):
            orders = self._read("command")
            if isinstance(orders, Orders):
                self._away = orders.away
                if orders.command != self._loop.command:
                    self._loop.command = orders.command
        if self._is_new("call"):
            call = self._read("call")
            if isinstance(call, Call):
                self._answer(self._numbers["call"], call)
        if self._is_new("guardian" if self._away else "driver"):
            self._numbers["guardian"], self._numbers["driver"] = (
                self._mailbox.guardian.number, self._mailbox.driver.number)
            self._heard = self._clock.now()
            self._loop.beat()
        elif not self._loop.armed:
            self._heard = self._clock.now()
        elif self._clock.now() - self._heard > _ABANDONED * _NS and self._loop.state is not State.HELD:
            self._sit(f"nobody drove the robot for {_ABANDONED:.0f} s: it sat down")
        try:
            self._interrupts.check()
        except (KeyboardInterrupt, SystemExit):
            self._sit("the loop's process was told to end: the robot sat down")

    def _is_new(self, slot: str) -> bool:
        number: int = getattr(self._mailbox, slot).number
        return number != self._numbers[slot]

    def _read(self, slot: str) -> Any:
        message = getattr(self._mailbox, slot).read()
        if message is None:
            return None
        self._numbers[slot] = message.number
        return unpacked(message.data)

    def _heed_stops(self) -> None:
        found = self._mailbox.stop_after(self._numbers["stop"])
        if found is None:
            return
        self._numbers["stop"], stop = found
        match stop:
            case Stop.HOLD:
                self._loop.hold()
            case Stop.CLEAR:
                self._loop.clear()
            case Stop.SIT:
                self._loop.clear()
                self._sit("told to stop: the robot sat down")
            case Stop.LIMP:
                self._disarm()
                self._end("told to stop: its torque was switched off at once")
        self._mailbox.heed.write(b"", self._numbers["stop"])

    def _answer(self, number: int, call: Call) -> None:
        """Do what the driver asks for, and tell what came of it."""
        error, result = None, None
        try:
            result = self._do(call)
        except RobotwalkError as failure:
            error = type(failure).__name__, str(failure)
        self._clock.armed = self._loop.armed
        self._tell()
        answer = Answer(number, error, result, self._loop.state, self._loop.armed, self._ticks)
        self._mailbox.answer.write(packed(answer), number)
        self._ring()

    def _do(self, call: Call) -> Any:
        match call:
            case Call("request", str(name)):
                self._loop.request(Request(name))
            case Call("arm", float(torque)):
                self._clock.armed = True
                self._held = self._loop.arm(torque)
                return self._held
            case Call("begin"):
                self._loop.begin(self._held)
                self._runs = True
            case Call("disarm"):
                self._disarm()
                return self._doubtful
            case Call("freeze"):
                self._loop.freeze()
                self._runs = self._loop.armed = False
            case Call("end"):
                self._end("")
            case _:
                raise UsageError(f"the loop cannot {call.name}")
        return None

    def _disarm(self) -> None:
        self._runs = False
        if self._loop.armed:
            self._doubtful = self._loop.disarm()

    def _end(self, why: str) -> None:
        self._ended = why
        self._runs = False

    def _sit(self, why: str) -> None:
        """Sit down without a driver, switch torque off, and end."""
        if self._loop.armed:
            try:
                self._robot.close()
            except RobotwalkError as error:
                why = f"{why} ({error})"
            self._doubtful = self._robot.doubtful
        self._end(why)

    def _show(self, tick: Tick) -> None:
        """Let everybody see a tick."""
        self._ticks += 1
        self._mailbox.telemetry.write(packed(Report(tick, self._loop.fault, self._loop.low, self._loop.missed)))
        self._ring()

    def _ring(self) -> None:
        os.eventfd_write(self._doorbell, 1)

    def _tell(self) -> None:
        """Write the status."""
        self._news_at = self._clock.now() + round(_NEWS * _NS)
        loop, bus = self._loop, self._bus
        status = Status(
            loop.missed, loop.cuts, loop.digest(), tuple(bus.notes), dict(bus.conditions()), dict(bus.statistics()),
            {line: sensor.statistics() for line, sensor in self._sensors.items()}, self._lacking,
            self._mailbox.log.dropped, self._ended, tuple(self._doubtful))
        self._mailbox.status.write(packed(status))
