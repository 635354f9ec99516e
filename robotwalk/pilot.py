"""Turns the loop's cycle until a motion is over, and heeds faults, stops and signals between ticks."""

from collections.abc import Callable, Sequence

from robotwalk.chronicle import Chronicle
from robotwalk.cycle import BusReports, Cycle, SensorReports
from robotwalk.errors import Held, RobotwalkError, SafetyStop, UsageError
from robotwalk.interrupts import Interrupts
from robotwalk.loop import Tick
from robotwalk.supervisor import Request, State
from robotwalk.types import Command

LONGEST_SIT_DOWN = 20.0  # s, the last steps included


class Pilot:
    """Has the robot do one thing after another.

    Attributes:
        last: the last tick; None: there was none.
        observers: called with every tick.
        frozen: whether it was left with torque on.
        doubtful: joints at which torque may still be on though it was switched off.
    """

    def __init__(
        self, loop: Cycle, bus: BusReports, sensors: Sequence[SensorReports], joints: tuple[str, ...], torque: float,
        chronicle: Chronicle, interrupts: Interrupts,
    ) -> None:
        """Take the parts; `torque` is the share of their largest output that the servos may use."""
        self.last: Tick | None = None
        self.observers: list[Callable[[Tick], None]] = []
        self.frozen = False
        self.doubtful: list[str] = []
        self._loop = loop
        self._bus = bus
        self._sensors = sensors
        self._joints = joints
        self._torque = torque
        self._chronicle = chronicle
        self._interrupts = interrupts

    @property
    def torque_doubt(self) -> str | None:
        """Where torque may still be on though it was switched off, in words; None if it is off everywhere."""
        return next((event.text for event in self._chronicle.events if event.kind == "torque"), None)

    def request(self, request: Request) -> None:
        """Ask the supervisor for a state.

        Raises:
            UsageError: the robot cannot do that from its present state.
            SafetyStop: since the last tick it was told to stop, or had to.
        """
        try:
            self._loop.request(request)
        except UsageError:
            self._heed(self._loop.state)
            raise
        self._chronicle.note("state", self._loop.state.value)

    def arm(self) -> None:
        """Have every servo hold where it is.

        Raises:
            BusError: a servo is missing.
        """
        self.request(Request.ARM)
        try:
            state = self._loop.arm(self._torque)
        except BaseException:
            self.request(Request.DISARM)
            raise
        for text in self._bus.notes:
            self._chronicle.note("audit", text)
        self._loop.begin(state)

    def run(
        self, seconds: float, *, until: Callable[[Tick], bool] = lambda tick: False, what: str | None = None
    ) -> None:
        """Turn the cycle for some time or until something is so; `what` names a motion that must end by then.

        Raises:
            SafetyStop: the robot had to sit down, was told to stop, or could not end the motion.
            KeyboardInterrupt, SystemExit: see `Interrupts.check`.
        """
        for _ in range(round(seconds * self._loop.rate_hz)):
            tick = self._tick()
            self._heed(tick.state)
            if until(tick):
                return
            self._interrupts.check()
        if what is not None:
            self._chronicle.note("timeout", f"{what} took longer than {seconds:.0f} s")
            raise SafetyStop(f"the robot could not {what} within {seconds:.0f} s")

    def seat(self) -> None:
        """Sit down and switch torque off; as long as somebody's `stop` holds the robot, wait.

        Raises:
            SafetyStop: the robot was coming down for a fault, or could not sit.
            SystemExit: see `await_clear`.
        """
        while True:
            try:
                self.await_clear()
                self._sit()
            except RobotwalkError:
                if self._loop.state is not State.HELD:
                    raise
                continue  # held on its way, or so lately that the loop refused what was asked of it
            break
        self._disarm()

    def await_clear(self) -> None:
        """Wait for as long as somebody's `stop` holds the robot in place; then it is on its way down, and may stand.

        Raises:
            SystemExit: told to end meanwhile, by SIGTERM or SIGHUP; the robot is left as it is, with torque on.
        """
        if self._loop.state is State.HELD:
            try:
                while self._tick().state is State.HELD:
                    self._interrupts.check(held=True)
            except SystemExit:
                self._freeze()
                raise

    def close(self) -> None:
        """Sit down if need be, switch torque off, give the ports back. A Ctrl-C meanwhile freezes the robot.

        Raises:
            RobotwalkError: the robot could not sit down.
            KeyboardInterrupt, SystemExit: the robot is frozen, by a Ctrl-C or as `await_clear` says.
        """
        try:
            if not self.frozen:
                self._interrupts.heed_only_ctrl_c()
                self._seat_unwatched_if_need_be()
        except KeyboardInterrupt:
            self._freeze()
            raise
        except SafetyStop:
            raise
        except Exception as error:
            self._chronicle.note("error", f"could not sit down: {error!r}")
            if isinstance(error, RobotwalkError):
                raise
            raise SafetyStop(f"the robot could not sit down: {error!r}") from error
        finally:
            if not self.frozen:
                with self._chronicle.noting("as torque was switched off"):
                    self._disarm()
                self._close_ports()
            self._chronicle.close()
            self._interrupts.restore()

    def _tick(self) -> Tick:
        """Turn the cycle once.

        Raises:
            SafetyStop: the loop is gone.
        """
        # The caller of this thread is the driver, and alive.
        self._loop.beat()
        try:
            tick = self.last = self._loop.tick()
        except SafetyStop as error:
            self._chronicle.note("safety_stop", str(error))
            raise
        self._chronicle.add(tick, self._loop.command, 1.0 / self._loop.rate_hz)
        for observer in self.observers:
            observer(tick)
        return tick

    def _heed(self, state: State) -> None:
        """Let a fault bring the robot down, or raise that it was told to stop, if that is how it is."""
        if state is State.FAULT:
            self._come_down()
        if state is State.HELD:
            self._chronicle.note("stop", "told to stop: held in place")
            raise Held("the robot was told to stop, and was held in place")

    def _sit(self) -> None:
        """Step to rest and sit down.

        Raises:
            SafetyStop: the robot was coming down for a fault, or could not sit.
        """
        state = self._loop.state
        if state is State.FAULT:
            self._come_down()
        if state in (State.STAND, State.WALK, State.MEND):
            self._loop.command = Command()
            self.request(Request.SIT)
            state = State.SIT
        if state is State.SIT:
            self.run(LONGEST_SIT_DOWN, until=lambda tick: tick.state is State.READY, what="sit")

    def _come_down(self) -> None:
        """Let a fault bring the robot down, switch torque off, and raise.

        Raises:
            SafetyStop: always.
        """
        reason = self._loop.fault or "it was stopped"
        for _ in range(round(LONGEST_SIT_DOWN * self._loop.rate_hz)):
            if self._tick().state is State.STOP:
                break
            self.await_clear()  # first: it heeds signals in its own way
            self._interrupts.check()
        self._disarm()
        self._chronicle.note("safety_stop", reason)
        raise SafetyStop(
            f"the robot was brought down because {reason}; {self.torque_doubt or 'torque is off'}")

    def _seat_unwatched_if_need_be(self) -> None:
        """Sit down; an observer that fails, as when its terminal is gone, must not keep the robot from it."""
        try:
            self.seat()
        except RobotwalkError:
            raise
        except Exception as error:
            self.observers.clear()
            self._chronicle.note("error", f"on the way down: {error!r}")
            self.seat()

    def _freeze(self) -> None:
        """Hold every joint where it was last measured, with torque on, give the ports back, and leave it so."""
        self.frozen = True
        try:
            self._loop.freeze()
            self._close_ports()
        except Exception as error:  # its ports stay with the loop, which holds or seats it
            self._chronicle.note("error", f"could not freeze: {error!r}")
        self._chronicle.note("freeze", "frozen in place; torque stays on")

    def _disarm(self) -> None:
        """Switch torque off, if we have switched it on, and say so if that cannot be confirmed."""
        if self._loop.armed:
            self.doubtful = list(self._joints)
            for _ in range(2):
                with self._chronicle.noting("as torque was switched off"):
                    self.doubtful = self._loop.disarm()
                    break
            if self.doubtful:
                self._chronicle.note("torque", f"torque may still be on at {', '.join(self.doubtful)}: cut the power")
        if self._loop.state is State.READY:
            self.request(Request.DISARM)

    def _close_ports(self) -> None:
        """Give all ports back."""
        ports: list[BusReports | SensorReports] = [self._bus, *self._sensors]
        for port in ports:
            with self._chronicle.noting("as a port was given back"):
                port.close()
