"""One robot, from its chair and back: `stand`, `walk`, `follow`, `sit`."""

import contextlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType, TracebackType
from typing import NamedTuple, Self

from robotwalk.barriers import Kind
from robotwalk.behaviours import Behaviour
from robotwalk.black_box import BlackBox
from robotwalk.cycle import BusReports, Cycle, SensorReports
from robotwalk.detour import Detour
from robotwalk.errors import Held, RobotwalkError, SafetyStop, UsageError
from robotwalk.estimator import Estimate
from robotwalk.interrupts import Interrupts
from robotwalk.loop import Tick
from robotwalk.model import RobotModel
from robotwalk.recorder import Event, Recorder
from robotwalk.sensor_watch import SensorWatch
from robotwalk.supervisor import Request, State
from robotwalk.types import (
    LEVEL,
    STILL,
    BusStatistics,
    Command,
    FootSwitch,
    ImuState,
    JointState,
    Pose,
    SensorStatistics,
    ServoCondition,
    Twist,
)

_LONGEST_STAND_UP = 15.0  # s; so long as this, something blocks it
_LONGEST_SIT_DOWN = 20.0  # s, the last steps included
_STOPS = ("safety_stop", "stop", "timeout")  # events after which the black box is saved
_BARRED: Mapping[Kind, str] = {
    "edge": "a foot found no ground ahead: stopped",
    "obstacle": "feet cannot step over what holds them back: stopped"}
LONGEST_WALK = 86400.0  # s, a day
LONGEST_PERIOD = 60.0  # s, of a gait


class RobotState(NamedTuple):
    """What is known of the robot now."""

    state: State
    joints: JointState
    odometry: Pose  # of the base in odom, by leg odometry
    twist: Twist  # commanded to the legs, after scaling
    imu: ImuState | None = None  # None: there is none, or it has not been heard yet
    switches: tuple[FootSwitch, ...] = ()  # of each foot; empty: there are none


def check_duration(seconds: float) -> None:
    """Raise UsageError if no walk can last so long."""
    if not 0.0 <= seconds <= LONGEST_WALK:
        raise UsageError(f"a walk lasts 0 to {LONGEST_WALK:.0f} s, not {seconds}")


def check_command(command: Command, model: RobotModel, gaits: Sequence[str], refused: Mapping[str, str]) -> None:
    """Raise UsageError if a command makes no sense for a robot of these `gaits`; others are `refused`, and why."""
    numbers = [*command.twist, *command.posture, command.heading or 0.0, command.height or 0.0, command.period or 1.0]
    if not all(math.isfinite(number) for number in numbers):
        raise UsageError(f"a command needs finite numbers, not {command}")
    if command.gait is not None and command.gait in refused:
        raise UsageError(f"{model.name} cannot {command.gait}: {refused[command.gait]}")
    if command.gait is not None and command.gait not in gaits:
        raise UsageError(f"{model.name} has no gait {command.gait!r}; it has {', '.join(gaits)}")
    if command.period is not None and not 0.0 < command.period <= LONGEST_PERIOD:
        raise UsageError(f"a gait's period is over 0 and up to {LONGEST_PERIOD:.0f} s, not {command.period}")
    heights = model.heights
    if command.height is not None and not heights.lowest <= command.height <= heights.highest:
        raise UsageError(
            f"height {command.height} m is outside {heights.lowest} to {heights.highest} m of {model.name}")


class Robot:
    """A robot on its bus. Leaving the block, by any path, seats it and switches torque off.

    Each call that moves the robot returns when the motion is over. Ctrl-C, SIGTERM and SIGHUP are taken
    between ticks: the first one leaves the block, so the robot sits; a Ctrl-C while it sits down freezes it
    as it is, with torque on, and so do SIGTERM and SIGHUP while somebody's `stop` holds it.

    On a bus the loop goes on between calls, in its own process: a program may take its time, and one that is killed
    leaves a robot that sits down. In simulation no time passes then; a loop in this process has the servos hold their
    last goals, their own watchdogs off, until the next call.

    Attributes:
        model, gaits, loop, events: what it is made of, and what has happened.
        observers: called with every tick.
        frozen: whether it was left with torque on.
        black_box: what keeps the last minute, and is saved when the robot stops for its safety; None: nothing does.
        doubtful: joints at which torque may still be on though it was switched off.
    """

    def __init__(
        self, model: RobotModel, gaits: Sequence[str], loop: Cycle, bus: BusReports, *,
        imu: SensorReports | None = None, foot_switches: SensorReports | None = None, recorder: Recorder | None = None,
        torque: float = 1.0, refused: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        """Join the parts.

        Args:
            model, gaits, loop, bus, imu, foot_switches, recorder: the parts; of the gaits, the names.
            torque: share of their largest output that the servos may use.
            refused: gaits that are for these feet, but more than the servos can give, and why.
        """
        self.model = model
        self.gaits = tuple(gaits)
        self._refused = refused
        self.loop = loop
        self.events: list[Event] = []
        self.observers: list[Callable[[Tick], None]] = []
        self._bus = bus
        self._imu = imu
        self._switches = foot_switches
        self._imu_watch = SensorWatch("the IMU", imu.statistics) if imu is not None else None
        self._switch_watch = (
            SensorWatch("the foot-switch board", foot_switches.statistics) if foot_switches is not None else None)
        self._recorder = recorder
        self._torque = torque
        self._interrupts = Interrupts()
        self._seconds = 0.0
        self._last: Tick | None = None
        self._entered = False
        self.frozen = False
        self.black_box: BlackBox | None = None
        self.doubtful: list[str] = []

    def __enter__(self) -> Self:
        self._interrupts.install()
        self._entered = True
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None and issubclass(kind, (KeyboardInterrupt, SystemExit)):
            self.note("interrupt", "interrupted" if kind is KeyboardInterrupt else "told to end")
        self.close()
        if kind is None:
            self._interrupts.check()  # what came too late to be heeded while the robot sat down

    @property
    def state(self) -> RobotState:
        """What is known of the robot now.

        Raises:
            UsageError: it was never armed, so nothing is known.
        """
        last = self._last_tick
        seen = last.estimate
        return RobotState(
            self.loop.state, last.joints, seen.pose, last.wanted.twist, seen.imu, seen.switches)

    @property
    def _last_tick(self) -> Tick:
        if self._last is None:
            raise UsageError("nothing is known of the robot's joints before stand()")
        return self._last

    @property
    def torque_doubt(self) -> str | None:
        """Where torque may still be on though it was switched off, in words; None if it is off everywhere."""
        return next((event.text for event in self.events if event.kind == "torque"), None)

    def stand(self) -> None:
        """Arm if need be and stand up, or stop walking and stand.

        Raises:
            BusError: a servo is missing.
            SafetyStop: the robot had to sit down.
        """
        if not self._entered:
            raise UsageError("use the robot in a `with` block: only that seats it whatever happens")
        state = self.loop.state
        if state is State.STOP:
            self._arm()
        self.loop.command = Command()
        if state is not State.STAND:
            self._request(Request.HALT if state is State.WALK else Request.STAND)
        self._run(_LONGEST_STAND_UP, until=lambda tick: tick.wanted.standing, what="stand")
        self.loop.pause()

    def walk(
        self, vx: float = 0.0, vy: float = 0.0, wz: float = 0.0, *, seconds: float, gait: str | None = None,
        heading: float | None = None, height: float | None = None, posture: Pose = LEVEL, period: float | None = None,
    ) -> None:
        """Walk for `seconds`, then stop and stand.

        Args:
            vx: speed forwards, m/s.
            vy: speed to the left, m/s.
            wz: turn to the left, rad/s.
            seconds: how long; slowing down comes on top.
            gait: its name; None is the robot's default.
            heading: where to face, rad in odom, in place of `wz`; turned to and held.
            height: of the base above the ground, m; None is the robot's own.
            posture: displacement of the body from its course, m and rad, in the base frame.
            period: of the gait, s, as far as strides and servos allow; None is as slow as the speed allows.

        Raises:
            UsageError: a value makes no sense, or the robot does not stand.
            SafetyStop: the robot had to sit down.
        """
        command = Command(Twist(vx, vy, wz), heading, height, posture, gait, period)
        self._walk(command, seconds, until=lambda tick: False)

    def follow(
        self, behaviour: Behaviour, *, seconds: float, gait: str | None = None, height: float | None = None,
        period: float | None = None, detours: bool = True,
    ) -> bool:
        """Let a behaviour steer until it is done or `seconds` have passed, then stop and stand.

        Args:
            behaviour: one of `robotwalk.behaviours`, or of yours.
            seconds: how long at most; slowing down comes on top.
            gait, height, period: where the behaviour leaves them open, as for `walk`.
            detours: whether to go round where its way is barred; else the robot stands there.

        Returns:
            Whether it was done.

        Raises:
            UsageError: a value makes no sense, one that the behaviour commands too, or the robot does not stand.
            SafetyStop: the robot had to sit down.
        """

        driver = Detour(behaviour) if detours else behaviour

        def command(estimate: Estimate) -> Command:
            wanted = driver.step(estimate, 1.0 / self.loop.rate_hz)
            return wanted._replace(
                gait=gait if wanted.gait is None else wanted.gait,
                height=height if wanted.height is None else wanted.height,
                period=period if wanted.period is None else wanted.period)

        def steer(tick: Tick) -> bool:
            self.command(command(tick.estimate))
            return behaviour.done

        self._walk(command(self._last_tick.estimate), seconds, until=steer)
        return behaviour.done

    def _walk(self, command: Command, seconds: float, *, until: Callable[[Tick], bool]) -> None:
        """Walk for some time or until something is so, then stop and stand."""
        check_duration(seconds)
        self.command(command)
        if self.loop.state is not State.WALK:
            self._request(Request.WALK)
        self._run(seconds, until=until)
        self.loop.command = self.loop.command._replace(twist=STILL, heading=None)
        self._request(Request.HALT)
        self._run(_LONGEST_SIT_DOWN, until=lambda tick: tick.wanted.standing, what="stop")
        self.loop.pause()

    def command(self, command: Command) -> None:
        """Change what the robot is to do, from the next tick on.

        Raises:
            UsageError: a value makes no sense; the command before stays in force.
        """
        check_command(command, self.model, self.gaits, self._refused)
        self.loop.command = command

    def sit(self) -> None:
        """Step to rest, sit down, switch torque off. Does nothing to a robot that we have not armed.

        As long as somebody's `stop` holds the robot it waits.

        Raises:
            SafetyStop: the robot was coming down for a fault, or could not sit.
            SystemExit: see `await_clear`.
        """
        while True:
            try:
                self.await_clear()
                self._sit()
            except RobotwalkError:
                if self.loop.state is not State.HELD:
                    raise
                continue  # held on its way, or so lately that the loop refused what was asked of it
            break
        self._disarm()

    def _sit(self) -> None:
        """Step to rest and sit down."""
        state = self.loop.state
        if state is State.FAULT:
            self._come_down()
        if state in (State.STAND, State.WALK, State.MEND):
            self.loop.command = Command()
            self._request(Request.SIT)
            state = State.SIT
        if state is State.SIT:
            self._run(_LONGEST_SIT_DOWN, until=lambda tick: tick.state is State.READY, what="sit")

    def await_clear(self) -> None:
        """Wait for as long as somebody's `stop` holds the robot in place; then it is on its way down, and may stand.

        Raises:
            SystemExit: told to end meanwhile, by SIGTERM or SIGHUP; the robot is left as it is, with torque on.
        """
        if self.loop.state is State.HELD:
            try:
                while self._tick().state is State.HELD:
                    self._interrupts.check(held=True)
            except SystemExit:
                self._freeze()
                raise

    def conditions(self) -> Mapping[str, ServoCondition]:
        """Return what each servo last told of itself, by its joint: voltage, temperature, current, faults."""
        return self._bus.conditions()

    def bus_statistics(self) -> Mapping[str, BusStatistics]:
        """Return what each bus carried, by its name."""
        return self._bus.statistics()

    def imu_statistics(self) -> SensorStatistics | None:
        """Return what the IMU said so far; None if the robot has none."""
        return self._imu.statistics() if self._imu is not None else None

    def foot_switch_statistics(self) -> SensorStatistics | None:
        """Return what the foot-switch board said so far; None if the robot has none."""
        return self._switches.statistics() if self._switches is not None else None

    def check_interrupts(self) -> None:
        """Raise what a signal stands for that has come: a driver who waits where no tick follows calls this.

        Raises:
            KeyboardInterrupt, SystemExit: see `Interrupts.check`.
        """
        self._interrupts.check()

    def note(self, kind: str, text: str) -> None:
        """Add an event to the run's list."""
        event = Event(round(self._seconds, 3), kind, text)
        self.events.append(event)
        if self._recorder is not None:
            with self._noting("in the log"):
                self._recorder.event(self._last.time if self._last else 0, event)
        if kind in _STOPS and self.black_box is not None:
            with self._noting("in the black box"):
                self.note("black_box", self.black_box.save(text, self.events))

    @contextlib.contextmanager
    def _noting(self, where: str) -> Iterator[None]:
        """Make an event, and no more, of an error that must not keep the robot from being stopped."""
        try:
            yield
        except Exception as error:
            # Straight to the list: it may be the log that failed.
            self.events.append(Event(round(self._seconds, 3), "error", f"{where}: {error!r}"))

    def close(self) -> None:
        """Sit down if need be, switch torque off, give the ports back. A Ctrl-C meanwhile freezes the robot.

        Raises:
            KeyboardInterrupt, SystemExit: the robot is frozen, by a Ctrl-C or as `await_clear` says.
        """
        self._entered = False
        try:
            if not self.frozen:
                self._interrupts.heed_only_ctrl_c()
                self._sit_unwatched_if_need_be()
        except KeyboardInterrupt:
            self._freeze()
            raise
        except SafetyStop:
            raise
        except Exception as error:
            self.note("error", f"could not sit down: {error!r}")
            if isinstance(error, RobotwalkError):
                raise
            raise SafetyStop(f"the robot could not sit down: {error!r}") from error
        finally:
            if not self.frozen:
                with self._noting("as torque was switched off"):
                    self._disarm()
                self._close_ports()
            with self._noting("in the log"):
                self._close_log()
            self._interrupts.restore()

    def _close_ports(self) -> None:
        for port in (self._bus, self._imu, self._switches):
            if port is not None:
                with self._noting("as a port was given back"):
                    port.close()

    def _close_log(self) -> None:
        failure = self._recorder.close() if self._recorder is not None else None
        self._recorder = None
        if failure is not None:
            self.note("log", failure)

    def _sit_unwatched_if_need_be(self) -> None:
        """Sit down; an observer that fails, as when its terminal is gone, must not keep the robot from it."""
        try:
            self.sit()
        except RobotwalkError:
            raise
        except Exception as error:
            self.observers.clear()
            self.note("error", f"on the way down: {error!r}")
            self.sit()

    def _request(self, request: Request) -> None:
        self.loop.request(request)
        self.note("state", self.loop.state.value)

    def _arm(self) -> None:
        self._request(Request.ARM)
        try:
            state = self.loop.arm(self._torque)
        except BaseException:
            self._request(Request.DISARM)
            raise
        for text in self._bus.notes:
            self.note("audit", text)
        self.loop.begin(state)

    def _disarm(self) -> None:
        """Switch torque off, if we have switched it on, and say so if that cannot be confirmed."""
        if self.loop.armed:
            self.doubtful = list(self.model.joint_names)
            for _ in range(2):
                with self._noting("as torque was switched off"):
                    self.doubtful = self.loop.disarm()
                    break
            if self.doubtful:
                self.note("torque", f"torque may still be on at {', '.join(self.doubtful)}: cut the power")
        if self.loop.state is State.READY:
            self._request(Request.DISARM)

    def _freeze(self) -> None:
        """Hold every joint where it was last measured, with torque on, and leave it so."""
        self.frozen = True
        try:
            self.loop.freeze()
            self._close_ports()
        except Exception as error:  # its ports stay with the loop, which holds or seats it
            self.note("error", f"could not freeze: {error!r}")
        self.note("freeze", "frozen in place; torque stays on")

    def _run(
        self, seconds: float, *, until: Callable[[Tick], bool] = lambda tick: False, what: str | None = None
    ) -> None:
        """Turn the cycle for some time or until something is so; `what` names a motion that must end by then."""
        for _ in range(round(seconds * self.loop.rate_hz)):
            tick = self._tick()
            if tick.state is State.FAULT:
                self._come_down()
            if tick.state is State.HELD:
                self.note("stop", "told to stop: held in place")
                raise Held("the robot was told to stop, and was held in place")
            if until(tick):
                return
            self._interrupts.check()
        if what is not None:
            self.note("timeout", f"{what} took longer than {seconds:.0f} s")
            raise SafetyStop(f"the robot could not {what} within {seconds:.0f} s")

    def _tick(self) -> Tick:
        # The caller of this thread is the driver, and alive.
        self.loop.beat()
        was_barred = self._last.wanted.barred if self._last is not None else None
        try:
            tick = self._last = self.loop.tick()
        except SafetyStop as error:
            self.note("safety_stop", str(error))
            raise
        if self.black_box is not None:
            try:
                self.black_box.add(tick, self.loop.command)
            except Exception as error:
                self.black_box = None
                self.note("error", f"in the black box: {error!r}")
        for kind, text in tick.news:
            self.note(kind, text)
        barred = tick.wanted.barred
        if barred is not None and barred != was_barred:
            self.note(barred.kind, _BARRED[barred.kind])
        self._seconds += 1.0 / self.loop.rate_hz
        self._listen(tick.estimate)
        for observer in self.observers:
            observer(tick)
        return tick

    def _listen(self, estimate: Estimate) -> None:
        """Note it when a sensor falls silent, or is back."""
        imu, switches = estimate.imu, estimate.switches
        if self._imu_watch is not None:
            news = self._imu_watch.step(imu is not None and imu.valid, self._seconds)
            if news is not None:
                self.note("imu", news)
        if self._switch_watch is not None:
            news = self._switch_watch.step(any(switch.closed is not None for switch in switches), self._seconds)
            if news is not None:
                self.note("feet", news)

    def _come_down(self) -> None:
        """Let a fault bring the robot down, switch torque off, and raise.

        Raises:
            SafetyStop: always.
        """
        reason = self.loop.fault or "it was stopped"
        for _ in range(round(_LONGEST_SIT_DOWN * self.loop.rate_hz)):
            if self._tick().state is State.STOP:
                break
            self.await_clear()  # first: it heeds signals in its own way
            self._interrupts.check()
        self._disarm()
        self.note("safety_stop", reason)
        raise SafetyStop(
            f"the robot was brought down because {reason}; {self.torque_doubt or 'torque is off'}")
