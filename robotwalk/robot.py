"""One robot, from its chair and back: `stand`, `walk`, `follow`, `sit`."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType, TracebackType
from typing import NamedTuple, Self

from robotwalk.behaviours import Behaviour
from robotwalk.black_box import BlackBox
from robotwalk.chronicle import Chronicle
from robotwalk.command_check import check_command, check_duration
from robotwalk.cycle import BusReports, Cycle, SensorReports
from robotwalk.detour import Detour
from robotwalk.errors import UsageError
from robotwalk.estimator import Estimate
from robotwalk.interrupts import Interrupts
from robotwalk.loop import Tick
from robotwalk.model import RobotModel
from robotwalk.pilot import LONGEST_SIT_DOWN, Pilot
from robotwalk.recorder import Event, Recorder
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


class RobotState(NamedTuple):
    """What is known of the robot now."""

    state: State
    joints: JointState
    odometry: Pose  # of the base in odom, by leg odometry
    twist: Twist  # commanded to the legs, after scaling
    imu: ImuState | None = None  # None: there is none, or it has not been heard yet
    switches: tuple[FootSwitch, ...] = ()  # of each foot; empty: there are none


class Robot:
    """A robot on its bus. Leaving the block, by any path, seats it and switches torque off.

    Each call that moves the robot returns when the motion is over. Ctrl-C, SIGTERM and SIGHUP are taken
    between ticks: the first one leaves the block, so the robot sits; a Ctrl-C while it sits down freezes it
    as it is, with torque on, and so do SIGTERM and SIGHUP while somebody's `stop` holds it.

    On a bus the loop goes on between calls, in its own process: a program may take its time, and one that is killed
    leaves a robot that sits down. In simulation no time passes then; a loop in this process has the servos hold their
    last goals, their own watchdogs off, until the next call.

    Attributes:
        model, gaits, loop: what it is made of; of the gaits, the names.
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
        self.loop = loop
        self._refused = refused
        self._bus = bus
        self._imu = imu
        self._switches = foot_switches
        self._interrupts = Interrupts()
        self._chronicle = Chronicle(recorder, imu, foot_switches)
        sensors = [sensor for sensor in (imu, foot_switches) if sensor is not None]
        self._pilot = Pilot(loop, bus, sensors, model.joint_names, torque, self._chronicle, self._interrupts)
        self._entered = False

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
        if self._pilot.last is None:
            raise UsageError("nothing is known of the robot's joints before stand()")
        return self._pilot.last

    @property
    def events(self) -> list[Event]:
        """What has happened so far."""
        return self._chronicle.events

    @property
    def observers(self) -> list[Callable[[Tick], None]]:
        """Are called with every tick."""
        return self._pilot.observers

    @property
    def black_box(self) -> BlackBox | None:
        """What keeps the last minute, and is saved when the robot stops for its safety; None: nothing does."""
        return self._chronicle.black_box

    @black_box.setter
    def black_box(self, box: BlackBox | None) -> None:
        self._chronicle.black_box = box

    @property
    def frozen(self) -> bool:
        """Whether it was left with torque on."""
        return self._pilot.frozen

    @property
    def doubtful(self) -> list[str]:
        """Joints at which torque may still be on though it was switched off."""
        return self._pilot.doubtful

    @property
    def torque_doubt(self) -> str | None:
        """Where torque may still be on though it was switched off, in words; None if it is off everywhere."""
        return self._pilot.torque_doubt

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
            self._pilot.arm()
        self.loop.command = Command()
        if state is not State.STAND:
            self._pilot.request(Request.HALT if state is State.WALK else Request.STAND)
        self._pilot.run(_LONGEST_STAND_UP, until=lambda tick: tick.wanted.standing, what="stand")
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
            self._pilot.request(Request.WALK)
        self._pilot.run(seconds, until=until)
        self.loop.command = self.loop.command._replace(twist=STILL, heading=None)
        self._pilot.request(Request.HALT)
        self._pilot.run(LONGEST_SIT_DOWN, until=lambda tick: tick.wanted.standing, what="stop")
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
        self._pilot.seat()

    def await_clear(self) -> None:
        """Wait for as long as somebody's `stop` holds the robot in place; then it is on its way down, and may stand.

        Raises:
            SystemExit: told to end meanwhile, by SIGTERM or SIGHUP; the robot is left as it is, with torque on.
        """
        self._pilot.await_clear()

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
        self._chronicle.note(kind, text)

    def close(self) -> None:
        """Sit down if need be, switch torque off, give the ports back. A Ctrl-C meanwhile freezes the robot.

        Raises:
            KeyboardInterrupt, SystemExit: the robot is frozen, by a Ctrl-C or as `await_clear` says.
        """
        self._entered = False
        self._pilot.close()
