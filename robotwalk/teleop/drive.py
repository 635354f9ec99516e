"""Drives a robot by what its drivers ask for, from chair to chair."""

import math
import time
from collections.abc import Callable

from robotwalk.command_check import LONGEST_WALK
from robotwalk.errors import SafetyStop
from robotwalk.estimator import Estimate
from robotwalk.loop import Tick
from robotwalk.robot import Robot
from robotwalk.supervisor import State
from robotwalk.teleop.ask import Wish
from robotwalk.teleop.bridge import Bridge
from robotwalk.teleop.told import Told
from robotwalk.types import Command

_PERIOD = 0.02  # s between two looks at the devices
_TOLD_EVERY = 0.1  # s
_IDLE = 120.0  # s that it stands with nobody driving before it sits, to spare its servos
_UP = (State.STAND, State.WALK, State.MEND)
_HINTS = {
    State.HELD: "held in place: Enter (or `robotwalk clear`) lets it sit down",
    State.STOP: "it sits, torque is off: Enter lets it stand up",
}


class Drive:
    """One session. While it walks it is a behaviour, whose commands come from the helm."""

    def __init__(
        self, robot: Robot, bridge: Bridge, show: Callable[[float, Told, str | None], None], note: str = "", *,
        seated: bool = False, ending: Callable[[], None] = lambda: None,
    ) -> None:
        """Prepare to drive; `show` is told what is known at a time (s), and what was refused.

        `ending` is called before the robot sits down for the last time.

        `note` is told while there is nothing else to tell. A robot that begins `seated` has torque off until a driver
        wants it to stand.
        """
        self._seated = seated
        self._ending = ending
        self._robot = robot
        self._bridge = bridge
        self._show = show
        self._note = note
        self._wishes: list[Wish] = []
        self._command = Command()
        self._looked_at = self._told_at = -math.inf
        self._driven_at = math.inf
        self._ticks = 0
        self.told = Told()

    @property
    def done(self) -> bool:
        """Whether something else is wanted than to walk."""
        return bool(self._wishes)

    @property
    def seconds(self) -> float:
        """How long it lasted so far, in ticks."""
        return self._ticks / self._robot.loop.rate_hz

    def run(self) -> None:
        """Stand up, be driven, sit.

        Raises:
            SafetyStop, KeyboardInterrupt, SystemExit: it ended early; the robot sits, or is frozen.
        """
        robot = self._robot
        robot.observers.append(self._watch)
        with robot:
            try:
                self._serve()
            finally:
                self._ending()
            self._do(robot.sit)

    def _serve(self) -> None:
        """Stand up, and do what is wished until somebody wishes to quit."""
        if not self._seated:
            self._show(time.monotonic(), Told(note="it is found, armed and stands up"), None)
            self._do(self._robot.stand)
        while (wish := self._next()) is not Wish.QUIT:
            if wish is Wish.SIT:
                self._do(self._robot.sit)
            elif wish is Wish.STAND:
                self._do(self._robot.stand)

    def _do(self, motion: Callable[[], object]) -> None:
        """Have the robot do something. If a STOP holds it meanwhile it sits once that is cleared.

        Raises:
            SafetyStop: the robot had to come down.
        """
        try:
            motion()
        except SafetyStop:
            if self._robot.loop.state is not State.HELD:
                raise
            self._wishes.clear()
            self._do(self._robot.sit)

    def step(self, estimate: Estimate, dt: float) -> Command:
        """Return the command of this tick."""
        return self._command

    def _next(self) -> Wish:
        """Walk, or wait where it sits, until something else is wanted."""
        while not self._wishes:
            if self._robot.loop.state in _UP:
                self._do(lambda: self._robot.follow(self, seconds=LONGEST_WALK))
            else:
                time.sleep(_PERIOD)
                self._robot.check_interrupts()
                self._look()
        return self._wishes.pop(0)

    def _watch(self, tick: Tick) -> None:
        self._ticks += 1
        self._look()

    def _look(self) -> None:
        """Hear the drivers, if it is time."""
        now = time.monotonic()
        if now - self._looked_at < _PERIOD:
            return
        self._looked_at = now
        if now - self._told_at >= _TOLD_EVERY:
            self._told_at = now
            self.told = self._tell()
        turn = self._bridge.turn(now, self.told)
        self._command = turn.command
        for wish in turn.wishes:
            self._heed(wish)
        self.told = self.told._replace(driver=turn.driver)
        self._show(now, self.told, turn.refusal)
        self._sit_if_idle(now)

    def _heed(self, wish: Wish) -> None:
        """Do at once what cannot wait; keep the rest for when the robot is done with what it is at."""
        held = self._robot.loop.state is State.HELD
        if wish is Wish.STOP:
            self._robot.loop.hold()
        elif wish is Wish.CLEAR or (held and wish is Wish.STAND):
            self._robot.loop.clear()
        elif not held:
            self._wishes.append(wish)

    def _sit_if_idle(self, now: float) -> None:
        if self.told.driver is not None or self.told.state not in ("stand", "walk"):
            self._driven_at = now
        elif now - self._driven_at > _IDLE and not self._wishes:
            self._robot.note("idle", f"nobody drove for {_IDLE:.0f} s: it sits")
            self._wishes.append(Wish.SIT)

    def _tell(self) -> Told:
        """Gather what is known."""
        robot, loop = self._robot, self._robot.loop
        if self._ticks == 0:
            return Told(note="torque is off until somebody says stand", rate_hz=loop.rate_hz)
        state = robot.state
        newest = robot.events[-1].text if robot.events and robot.events[-1].kind != "state" else self._note
        note = _HINTS.get(state.state, newest)
        return Told(
            state.state.value, None, note, state.odometry, state.twist, robot.conditions(),
            robot.bus_statistics(), loop.rate_hz, self._ticks, loop.missed, loop.wake.percentiles(),
            loop.exchange.percentiles(), loop.compute.percentiles())
