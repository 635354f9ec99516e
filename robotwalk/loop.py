"""The cycle, at an absolute deadline each time: write and read the bus, hear the sensors, estimate, supervise, control,
limit.

The goals written are those computed in the cycle before, so that they leave with no more jitter than the
wake-up has. The same code runs on wall time and on simulated time.
"""

import hashlib
import struct
import time
from collections import Counter
from collections.abc import Callable, Set
from typing import NamedTuple

from robotwalk.clock import Grid
from robotwalk.controller import NOTHING_WANTED, Wanted
from robotwalk.end_stops import EndStops
from robotwalk.estimator import Estimate
from robotwalk.feedforward import Feedforward
from robotwalk.limits import Gate
from robotwalk.ports import Clock, FootSwitches, Imu, ServoBus
from robotwalk.recorder import Row
from robotwalk.reentry import Reentry
from robotwalk.safety import Safety
from robotwalk.stability import Stability
from robotwalk.supervisor import Request, State
from robotwalk.tape import Tape
from robotwalk.timing import Histogram
from robotwalk.types import STILL, Command, FootSwitch, ImuState, JointState
from robotwalk.walker import Walker

_NS = 1_000_000_000
_SOFT = 0.4  # of the torque, for a robot that fell: enough to draw its legs in


class Tick(NamedTuple):
    """What one turn of the cycle did."""

    time: int  # ns, the deadline
    state: State
    joints: JointState
    estimate: Estimate
    wanted: Wanted
    goals: tuple[float, ...]
    stability: Stability | None  # None: not asked for
    news: tuple[tuple[str, str], ...] = ()  # what is worth an event: its kind, and what happened in words


class Loop:
    """Runs the cycle of one robot. The driver changes `command` between ticks, and shows by `beat` that it lives.

    Whatever a driver has it do goes onto its tape first, if it has one.

    Attributes:
        rate_hz, period: ticks per second; ns from one to the next.
        armed: whether torque was switched on, or partly, and not off since.
        wake, exchange, compute: how late the ticks began, how long the bus and the IMU took, and all else.
    """

    def __init__(
        self,
        *,
        rate_hz: int,
        clock: Clock,
        bus: ServoBus,
        imu: Imu | None = None,
        switches: FootSwitches | None = None,
        walker: Walker,
        feedforward: Feedforward,
        end_stops: EndStops,
        gate: Gate,
        safety: Safety,
        record: Callable[[Row], None] | None = None,
        tape: Tape | None = None,
        histograms: tuple[Histogram, Histogram, Histogram] | None = None,
        regroup: Callable[[Set[int]], Walker] | None = None,
    ) -> None:
        """Join the parts; `regroup` makes what is left of the robot walk, without the legs of dead joints (slots)."""
        self.rate_hz = rate_hz
        self._command = Command()
        self._beaten_at = 0
        self._safety = safety
        self.supervisor = safety.supervisor
        self.gate = gate
        self._clock = clock
        self._bus = bus
        self._imu = imu
        self._switches = switches
        self._walker = walker
        self._regroup = regroup
        self._feedforward = feedforward
        self._reentry = Reentry()
        self._end_stops = end_stops
        self._record = record
        self._taped: Callable[..., None] = tape.call if tape is not None else lambda name, argument=None: None
        self.period = _NS // rate_hz
        self._grid = Grid(rate_hz, after=clock.now())
        self._missed = 0  # ticks left out before the last
        self._slow_after = round(safety.driver.slow_after_s * _NS)
        self._paused = False
        self.armed = False
        self._goals: tuple[float, ...] = ()
        self._joints = JointState((), (), (), (), ())
        self._wanted = NOTHING_WANTED
        self.wake, self.exchange, self.compute = histograms or (Histogram(), Histogram(), Histogram())
        self._digest = hashlib.sha256()
        self._packing = struct.Struct(f"<{2 * len(bus.joints)}d")

    @property
    def command(self) -> Command:
        """What the robot is to do.

        It lasts for some time past the last `beat` (`safety: driver` of the robot's file); then the robot stands still.
        """
        return self._command

    @command.setter
    def command(self, command: Command) -> None:
        self._taped("command", command)
        self._command = command
        self._beaten_at = self._clock.now()

    def beat(self) -> None:
        """Show that whoever drives the robot is still there."""
        self._taped("beat")
        self._beaten_at = self._clock.now()

    def request(self, request: Request) -> None:
        """Have the supervisor change the state.

        Raises:
            UsageError: the robot cannot do that from its present state.
        """
        self._taped("request", request.value)
        self.supervisor.request(request)

    def arm(self, torque: float = 1.0) -> JointState:
        """Have the bus switch torque on, every joint where it is.

        Raises:
            BusError: see `ServoBus.arm`.
        """
        self._taped("arm", torque)
        state = self._bus.arm(self.period, torque)
        self.armed = True
        return state

    def disarm(self) -> list[str]:
        """Switch torque off; return the joints at which that could not be confirmed. Never raises."""
        self._taped("disarm")
        self.armed = False
        return self._bus.disarm()

    def hold(self) -> None:
        """Have every joint stay where it was last measured, whatever the driver wants, until `clear`."""
        self._taped("hold")
        if self.state in (State.STOP, State.HELD):
            return
        self.supervisor.hold()
        self._take_over(self._joints._replace(position=self._measured()))

    def clear(self) -> None:
        """Let a held robot go: it sits down, and may then stand up."""
        self._taped("clear")
        self.supervisor.clear()

    @property
    def state(self) -> State:
        """What the robot is allowed to do now."""
        return self.supervisor.state

    @property
    def fault(self) -> str | None:
        """Why the robot was brought down, if it was."""
        return self.supervisor.fault

    @property
    def low(self) -> bool:
        """Whether the robot is on its way down for a reason, or on its way up from there."""
        return self.supervisor.low

    @property
    def cuts(self) -> Counter[tuple[str, str]]:
        """How many goals the gate has cut, by joint and by what."""
        return self.gate.cuts

    def pause(self) -> None:
        """Have every joint hold what it holds, for no tick will follow for a while. The next one goes on from there."""
        self._taped("pause")
        self._bus.pause()
        self._paused = True

    @property
    def missed(self) -> int:
        """How many grid points were skipped."""
        return self._grid.missed

    def digest(self) -> str:
        """Return a hash of every joint position read and every goal sent so far."""
        return self._digest.hexdigest()

    def begin(self, state: JointState) -> None:
        """Take over joints that hold their places, as `arm` returned them; the first tick is on the next grid point."""
        self._taped("begin")
        self._take_over(state)
        self._grid, self._missed = Grid(self.rate_hz, after=self._clock.now()), 0

    def tick(self) -> Tick:
        """Wait for the deadline and turn the cycle once."""
        self._taped("tick")
        clock, dt = self._clock, 1.0 / self.rate_hz
        if self._paused:
            self._paused = False
            self._grid.resume(clock.now())
        deadline = self._grid.deadline
        clock.wait((), deadline)
        woke = clock.now()
        joints = self._bus.exchange(self._goals, self.period)
        self._joints = joints
        imu = self._imu.read() if self._imu is not None else None
        switches = self._switches.read() if self._switches is not None else ()
        read = clock.now()
        started = time.perf_counter_ns()
        tick = self._think(deadline, joints, imu, switches, dt)
        computed = time.perf_counter_ns() - started
        self._digest.update(self._packing.pack(*joints.position, *tick.goals))
        self.wake.add(woke - deadline)
        self.exchange.add(read - woke)
        self.compute.add(computed)
        if self._record is not None:
            self._record(Row(
                deadline, tick.state, self.command, tick.wanted.twist, tick.goals, joints, tick.estimate.pose,
                tick.stability, woke - deadline, read - woke, computed, imu, switches))
        self._grid.advance(clock.now())
        return tick

    def freeze(self) -> None:
        """Hold every joint where it is, through the gate: measured if it answered, else where it was sent.

        Nobody need talk to the servos any more. A robot that is held already keeps its goals: it would sag, for joints
        that bear something rest below what they are sent to.
        """
        self._taped("freeze")
        here = self._goals if self.state is State.HELD else self._measured()
        for _ in range(2):  # nobody acknowledges goals
            self._goals = self.gate.step(here, 1.0 / self.rate_hz)
            self._bus.exchange(self._goals, self.period)
        self._bus.pause()

    def _measured(self) -> tuple[float, ...]:
        """Return where each joint is: measured if it answered, else where it was sent."""
        return tuple([
            position if valid else goal
            for position, valid, goal in zip(self._joints.position, self._joints.valid, self._goals, strict=True)])

    def _take_over(self, state: JointState) -> None:
        """Go on from joints that hold their places."""
        self._walker.start(state.position)
        self.gate.reset(state.position)
        self._feedforward.reset(state.position)
        self._reentry.reset(state.position)
        self._end_stops.reset(state.position)
        self._goals = state.position
        self._joints = state
        self._wanted = self._wanted._replace(planted=())

    def _think(
        self, now: int, joints: JointState, imu: ImuState | None, switches: tuple[FootSwitch, ...], dt: float
    ) -> Tick:
        """Everything between the bytes read and the goals for the next write."""
        wanted = self._wanted
        estimate, stable = self._walker.perceive(joints, imu, switches, dt, feel=self._safety.efforts_tell)
        if wanted.barriers:
            estimate = estimate._replace(barriers=wanted.barriers)
        command = self._command
        if now - self._beaten_at > self._slow_after:
            command = command._replace(twist=STILL, heading=None)
        reseeded = self._bus.reseeded
        state, command, holding, news, dead, fell, waits = self._safety.step(
            joints, self._goals, command, wanted, imu, self._grid.missed - self._missed, self._reentry.behind)
        self._missed = self._grid.missed
        if dead and self._regroup is not None:
            self._walker = self._regroup(dead)
            self._walker.start(joints.position, estimate.pose)
        if fell:
            self._bus.soften(_SOFT)
            self._take_over(joints._replace(position=self._measured()))
        wanted = self._walker.step(state, command, estimate, dt, waits=waits)
        goals = self._reentry.step(
            self._feedforward.step(wanted.angles, wanted.torques, dt), wanted.angles, joints, holding, reseeded, dt)
        if reseeded:
            self.gate.take(reseeded, joints.position)
        goals = self.gate.step(self._end_stops.step(goals, joints, reseeded), dt)
        self._wanted, self._goals = wanted, goals
        return Tick(now, state, joints, estimate, wanted, goals, stable, news)

