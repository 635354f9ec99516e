"""The cycle: its order, its deadlines, the driver's heartbeat."""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import pytest

from robotwalk.controller import Controller
from robotwalk.end_stops import EndStops
from robotwalk.feedforward import Feedforward
from robotwalk.gait import Gait
from robotwalk.kinematics import resting_angles
from robotwalk.limits import Gate, JointLimit
from robotwalk.loop import Loop, Tick
from robotwalk.model import RobotModel
from robotwalk.ports import BytePort
from robotwalk.recorder import Row
from robotwalk.safety import Safety
from robotwalk.supervisor import Request, State
from robotwalk.types import BusStatistics, Command, DriveResponse, JointState, ServoCondition, Twist
from robotwalk.walker import Walker

RATE_HZ = 100
PERIOD = 10_000_000  # ns


class ManualClock:
    """Time that passes where the test says so, and in waiting."""

    def __init__(self) -> None:
        self.time = 123_456_789

    def now(self) -> int:
        return self.time

    def wait(self, ports: Sequence[BytePort], deadline: int) -> None:
        self.time = max(self.time, deadline)


class PerfectBus:
    """Joints that are where they were told to be one tick ago."""

    def __init__(self, model: RobotModel, clock: ManualClock) -> None:
        self.joints = model.joint_names
        self.alerts: dict[str, str] = {}
        self.notes: tuple[str, ...] = ()
        self.reseeded: tuple[int, ...] = ()
        self.written: list[tuple[float, ...]] = []
        self.exchange_ns = 4_000_000
        self.position = tuple(resting_angles(model, model.heights.sit))
        self._clock = clock

    def arm(self, period: int, torque: float = 1.0) -> JointState:
        return self._state()

    def exchange(self, goals: Sequence[float], period: int) -> JointState:
        self.written.append(tuple(goals))
        self._clock.time += self.exchange_ns
        state = self._state()
        self.position = tuple(goals)
        return state

    def pause(self) -> None: ...

    def disarm(self) -> None: ...

    def close(self) -> None: ...

    def statistics(self) -> Mapping[str, BusStatistics]:
        return {}

    def conditions(self) -> Mapping[str, ServoCondition]:
        return {}

    def condition(self, slot: int) -> ServoCondition:
        return ServoCondition(None, None, None, None, ())

    def _state(self) -> JointState:
        count = len(self.joints)
        return JointState(self.position, (0.0,) * count, (0.0,) * count, (True,) * count, (0.0,) * count)


class Rig:
    """A loop around perfect joints."""

    def __init__(self, model: RobotModel, gaits: Mapping[str, Gait]) -> None:
        self.clock = ManualClock()
        self.bus = PerfectBus(model, self.clock)
        self.rows: list[Row] = []
        self.loop = Loop(
            rate_hz=RATE_HZ, clock=self.clock, bus=self.bus,
            walker=Walker(model, Controller(model, gaits, "tripod"), gaits),
            feedforward=Feedforward([DriveResponse(0.0, 0.0, 0.0, 6.0)] * 18),
            end_stops=EndStops([(-4.0, 4.0)] * 18, [DriveResponse(0.0, 0.0, 0.0, 6.0)] * 18, 1.0 / RATE_HZ),
            gate=Gate(model.joint_names, [JointLimit(-4.0, 4.0, 100.0, 1e6)] * 18),
            safety=Safety(model, self.bus, RATE_HZ, [DriveResponse(0.0, 0.0, 0.0, 6.0)] * 18),
            record=self.rows.append)
        self.loop.begin(self.bus.arm(PERIOD))
        self.loop.supervisor.request(Request.ARM)

    def run(self, seconds: float, beat: bool = True) -> list[Tick]:
        ticks = []
        for _ in range(round(seconds * RATE_HZ)):
            if beat:
                self.loop.beat()
            ticks.append(self.loop.tick())
        return ticks

    def stand(self) -> None:
        self.loop.supervisor.request(Request.STAND)
        assert self.run(5.0)[-1].wanted.standing


@pytest.fixture
def rig(hexapod: RobotModel, gaits: Mapping[str, Gait]) -> Rig:
    return Rig(hexapod, gaits)


def test_each_tick_writes_what_the_tick_before_computed(rig: Rig) -> None:
    rig.loop.supervisor.request(Request.STAND)
    ticks = rig.run(0.5)
    assert rig.bus.written[0] == tuple(resting_angles_of(rig))
    assert rig.bus.written[1:] == [tick.goals for tick in ticks[:-1]]


def resting_angles_of(rig: Rig) -> Sequence[float]:
    return rig.rows[0].joints.position


def test_ticks_lie_on_an_absolute_grid_however_long_they_take(rig: Rig) -> None:
    rig.bus.exchange_ns = 7_000_000
    times = [tick.time for tick in rig.run(0.3)]
    assert {b - a for a, b in pairwise(times)} == {PERIOD}
    assert times[0] % PERIOD == 0
    assert rig.loop.missed == 0


def test_a_tick_that_overruns_skips_grid_points_and_they_are_counted(rig: Rig) -> None:
    rig.run(0.05)
    rig.bus.exchange_ns = 25_000_000
    (long,) = rig.run(0.01)
    rig.bus.exchange_ns = 4_000_000
    (after,) = rig.run(0.01)
    assert after.time - long.time == 3 * PERIOD
    assert rig.loop.missed == 2


def test_a_driver_who_falls_silent_lets_the_robot_slow_to_a_stand(rig: Rig) -> None:
    rig.stand()
    rig.loop.supervisor.request(Request.WALK)
    rig.loop.command = Command(Twist(0.10, 0.0, 0.0))
    assert rig.run(1.0)[-1].wanted.twist.vx == pytest.approx(0.10)
    silent = rig.run(3.0, beat=False)
    speeds = [tick.wanted.twist.vx for tick in silent]
    # The last beat was in the last tick before; half a second later it brakes, by its own limit of 0.3 m/s^2.
    assert speeds[48] == pytest.approx(0.10)
    assert speeds[60] < 0.10
    changes = [abs(b - a) for a, b in pairwise(speeds)]
    assert max(changes) <= 0.3 / RATE_HZ + 1e-9
    assert speeds[-1] == 0.0
    assert silent[-1].wanted.standing
    # Back again, it goes on.
    assert rig.run(1.0)[-1].wanted.twist.vx == pytest.approx(0.10)


def test_every_tick_is_recorded_with_what_it_did(rig: Rig) -> None:
    rig.loop.supervisor.request(Request.STAND)
    rig.bus.exchange_ns = 3_000_000
    ticks = rig.run(0.2)
    assert [row.time for row in rig.rows] == [tick.time for tick in ticks]
    assert [row.goals for row in rig.rows] == [tick.goals for tick in ticks]
    assert {row.state for row in rig.rows} == {State.STAND}
    assert {row.bus for row in rig.rows} == {3_000_000}
    assert all(row.tick > 0 for row in rig.rows)


def test_the_digest_tells_runs_apart(hexapod: RobotModel, gaits: Mapping[str, Gait]) -> None:
    def run(vx: float) -> str:
        rig = Rig(hexapod, gaits)
        rig.stand()
        rig.loop.supervisor.request(Request.WALK)
        rig.loop.command = Command(Twist(vx, 0.0, 0.0))
        rig.run(0.3)
        return rig.loop.digest()

    assert run(0.10) == run(0.10)
    assert run(0.05) != run(0.051)
