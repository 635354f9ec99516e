"""The loop's end: does what the mailbox says with one loop, and shows what comes of it.

    the driver's calls and orders   are heeded between ticks
    stops, from anybody             hold, sit or let go, whatever the driver wants; so does the stop input
    a driver that is silent         has the loop slow to a stand (see `Loop`), and later sit
    the command that is gone        SIGTERM comes from the kernel then: sit
"""

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from robotwalk.cycle import SensorReports
from robotwalk.errors import RobotwalkError, SafetyStop, UsageError
from robotwalk.interrupts import Interrupts
from robotwalk.loop import Loop, Tick
from robotwalk.ports import ServoBus
from robotwalk.process.mailbox import packed, unpacked
from robotwalk.process.messages import REPORT, Answer, Call, Orders, Report, Status
from robotwalk.process.pulse import PulsingClock
from robotwalk.process.shared import Mailbox, Stop
from robotwalk.process.stop_input import Heeded, StopWatch
from robotwalk.supervisor import Request, State
from robotwalk.types import Command, JointState

_NS = 1_000_000_000
_IDLE = 5_000_000  # ns between looks into the mailbox while torque is off
_NEWS = 0.5  # s between two statuses
_LONGEST_SIT_DOWN = 20.0  # s
_UP = (State.STAND, State.WALK, State.MEND)


class Servant:
    """Serves until it is told to end, or has brought the robot down."""

    def __init__(
        self, loop: Loop, bus: ServoBus, sensors: Mapping[str, SensorReports], clock: PulsingClock, mailbox: Mailbox,
        doorbell: int, lacking: Sequence[str], abandoned: float, watch: StopWatch,
    ) -> None:
        """Join the parts.

        Args:
            loop, bus, sensors: what is served; the sensors by the names of their lines.
            clock: the loop's.
            mailbox: shared with the driver.
            doorbell: an eventfd to ring after each tick.
            lacking: what there is no right to, in words.
            abandoned: s without a sign of the driver after which the robot sits down.
            watch: of the stop input.
        """
        self._loop, self._bus, self._sensors = loop, bus, sensors
        self._clock, self._mailbox, self._doorbell, self._lacking = clock, mailbox, doorbell, tuple(lacking)
        self._abandoned = abandoned
        self._watch = watch
        self._pressed: Heeded | None = None  # what the stop input says
        self._obeyed = False  # it has been done
        self._news: tuple[tuple[str, str], ...] = ()  # for the next tick
        self._armed = JointState((), (), (), (), ())  # the joints, as armed
        self._runs = False  # the loop goes round
        self._leaving: str | None = None  # why the robot sits down without its driver
        self._sit_by = 0
        self._ended: str | None = None
        self._doubtful: list[str] = []
        self._away = True  # the driver; it need not beat
        self._numbers: Counter[str] = Counter()  # of the newest message heeded, by slot
        self._heard = clock.now()
        self._news_at = 0
        self._ticks = 0
        self._interrupts = Interrupts()

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
            if self._leaving is not None and self._ended is None:
                self._go_down(self._leaving)
            if self._clock.now() >= self._news_at:
                self._tell()
        self._clock.armed = False
        self._tell()
        self._ring()

    def _listen(self) -> None:
        """Heed what has come."""
        self._heed_stops()
        self._heed_stop_input()
        if self._leaving is None and self._is_new("command"):
            orders = self._read("command")
            if isinstance(orders, Orders):
                self._away = orders.away
                if orders.command != self._loop.command:
                    self._loop.command = orders.command
        if self._is_new("call"):
            call = self._read("call")
            if isinstance(call, Call):
                self._answer(self._numbers["call"], call)
        self._listen_for_life()

    def _listen_for_life(self) -> None:
        """Look whether anybody drives."""
        try:
            self._interrupts.check()
        except (KeyboardInterrupt, SystemExit):
            self._leave("the loop's process was told to end: the robot sat down")
        mailbox = self._mailbox
        if self._is_new("guardian" if self._away else "driver"):
            self._numbers["guardian"], self._numbers["driver"] = mailbox.guardian.number, mailbox.driver.number
            self._heard = self._clock.now()
            self._loop.beat()
        elif not self._loop.armed:
            self._heard = self._clock.now()
        elif self._clock.now() - self._heard > self._abandoned * _NS:
            self._leave(f"nobody drove the robot for {self._abandoned:g} s: it sat down")

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
        number, stop = found
        self._numbers["stop"] = number
        self._mailbox.heed.write(self._heed(stop).encode()[:400], number)

    def _heed_stop_input(self) -> None:
        """Do what the stop input says, once; as long as it says so nothing undoes it."""
        self._pressed = self._watch.look()
        if self._pressed is None or not self._loop.armed:
            self._obeyed = False
        elif not self._obeyed:
            self._obeyed = True
            self._news += (("stop_input", self._pressed.reason),)
            self._heed(self._pressed.stop, self._pressed.reason)

    def _heed(self, stop: Stop, why: str = "told to stop") -> str:
        """Do what somebody tells the robot, and return what that is, in words that follow its name."""
        loop = self._loop
        if stop is Stop.LIMP:
            self._disarm()
            self._end(f"{why}: its torque was switched off at once")
            return f"has its torque off{self._doubt}"
        if not loop.armed:
            if stop is Stop.SIT:
                self._end(f"{why}: its torque was off already")
            return "has its torque off already"
        if stop is Stop.HOLD:
            loop.hold()
            return "holds where it is; `robotwalk clear` lets it sit down, `robotwalk stop --limp` lets go"
        if stop is Stop.CLEAR and loop.state is not State.HELD:
            return "is not held"
        if stop is Stop.CLEAR and self._pressed is not None:
            return f"stays held, for it is {self._pressed.reason}; `robotwalk stop --sit` lets it down all the same"
        if stop is Stop.CLEAR and self._bus.alerts:
            told = "; ".join(f"the servo of {joint} {words}" for joint, words in self._bus.alerts.items())
            return f"stays held, for {told}; `robotwalk stop --sit` lets it down all the same"
        loop.clear()
        if stop is Stop.SIT:
            self._leave(f"{why}: the robot sat down")
        return "sits down"

    @property
    def _doubt(self) -> str:
        return f", but it may still be on at {', '.join(self._doubtful)}: cut the power" if self._doubtful else ""

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
                if self._pressed is not None:
                    raise SafetyStop(f"cannot arm: {self._pressed.reason}")
                with self._clock.arming(self._watch):
                    self._armed = self._loop.arm(torque)
                return self._armed
            case Call("begin"):
                self._loop.begin(self._armed)
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

    def _leave(self, why: str) -> None:
        """Have the robot sit down without its driver; then its torque goes off, and this ends."""
        if self._leaving is None:
            self._leaving = why
            self._sit_by = self._clock.now() + round(_LONGEST_SIT_DOWN * _NS)

    def _go_down(self, why: str) -> None:
        loop, now = self._loop, self._clock.now()
        if loop.state is State.HELD:  # until somebody clears it
            self._sit_by = now + round(_LONGEST_SIT_DOWN * _NS)
        elif loop.state in _UP:
            loop.command = Command()
            loop.request(Request.SIT)
        elif not loop.armed or loop.state is State.READY:
            self._disarm()
            self._end(why)
        elif now > self._sit_by:
            self._disarm()
            self._end(f"{why.partition(':')[0]}: the robot could not sit within {_LONGEST_SIT_DOWN:.0f} s")

    def _end(self, why: str) -> None:
        self._ended = why
        self._runs = False

    def _show(self, tick: Tick) -> None:
        """Let everybody see a tick."""
        self._ticks += 1
        if self._news:
            tick, self._news = tick._replace(news=self._news + tick.news), ()
        tick = tick._replace(wanted=tick.wanted._replace(legs=()))
        self._mailbox.telemetry.write(REPORT.pack(Report(tick, self._loop.fault, self._loop.low, self._loop.missed)))
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
            self._ended, tuple(self._doubtful))
        self._mailbox.status.write(packed(status))
