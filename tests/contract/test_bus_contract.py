"""What every bus keeps, whatever the brand of its servos and whatever carries its bytes.

Each test runs for each bundled robot, in process and in lock-step, over a pseudo-terminal, and over TCP: the
last two with the simulated robot in a process of its own, in real time.
"""

import math
import socket
from collections.abc import Callable, Iterator

import pytest

from hal import bus_plan
from robotwalk import assembly
from robotwalk.config import library
from robotwalk.errors import BusError
from robotwalk.types import JointState

from ..device import served

pytestmark = pytest.mark.xdist_group("bus contract")

PERIOD = 20_000_000  # ns; these tests are about the bus, not about a busy machine's pace

Opener = Callable[[], assembly.LocalSession]


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


@pytest.fixture(scope="module", params=library.names("robots"))
def robot(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module", params=["in process", "pty", "tcp"])
def opened(
    request: pytest.FixtureRequest, robot: str, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Opener]:
    """Yield what opens the robot's bus; it is the same device each time, as the test before has left it."""
    if request.param == "in process":
        simulation = assembly.simulate(robot, rate_hz=50)
        yield lambda: simulation
        return
    folder, address = str(tmp_path_factory.mktemp(robot)), f"127.0.0.1:{free_port()}"
    where = ("--pty", folder) if request.param == "pty" else ("--tcp", address)
    with served(robot, *where) as urls:
        yield lambda: assembly.attach(robot, urls, rate_hz=50)


def settle(session: assembly.LocalSession, goals: list[float], seconds: float) -> JointState:
    """Exchange for some time, at the period."""
    state = None
    begin = session.clock.now()
    for tick in range(round(seconds * 1e9 / PERIOD)):
        session.clock.wait((), begin + tick * PERIOD)
        state = session.bus.exchange(goals, PERIOD)
    assert state is not None
    return state


def test_arming_finds_every_joint_where_it_sits(opened: Opener) -> None:
    session = opened()
    state = session.bus.arm(PERIOD)
    assert all(state.valid)
    assert max(state.age) == 0.0
    for joint, angle in zip(session.blueprint.model.joints, state.position, strict=True):
        assert joint.lower < angle < joint.upper
    session.bus.close()


def test_a_joint_goes_where_it_is_told_and_the_others_stay(opened: Opener) -> None:
    session = opened()
    before = session.bus.arm(PERIOD).position
    goals = list(before)
    goals[0] += 0.15
    after = settle(session, goals, 1.0)
    assert after.position[0] - before[0] == pytest.approx(0.15, abs=0.04)
    for index in range(1, len(goals)):
        assert after.position[index] == pytest.approx(before[index], abs=0.05)
    assert max(map(abs, after.velocity)) < 0.2, "at rest"
    assert max(map(abs, after.effort)) < 0.5
    session.bus.close()


def test_a_bus_disarmed_and_closed_has_let_go_and_can_be_opened_again(opened: Opener) -> None:
    session = opened()
    session.bus.arm(PERIOD)
    assert session.bus.disarm() == []
    session.bus.close()
    again = opened()
    line = next(iter(again.bus.lines))
    for servo in line.servos:
        assert line.read_register(again.clock, servo, "torque_enable") == 0
    assert all(again.bus.arm(PERIOD).valid)
    again.bus.close()


def test_statistics_count_the_bytes_of_the_plan(opened: Opener) -> None:
    session = opened()
    state = session.bus.arm(PERIOD)
    before = session.bus.statistics()
    settle(session, list(state.position), 0.4)
    after = session.bus.statistics()
    for line in session.bus.lines:
        name = line.name
        ticks = after[name].transactions - before[name].transactions
        assert ticks == 20
        lost = after[name].lost_replies - before[name].lost_replies
        received = after[name].rx_bytes - before[name].rx_bytes
        plan = bus_plan.cycle_of(line.protocol, line.servos, line.cycle.readers)
        if not plan.spread:
            # Stuffing may add a byte here and there; a late reply on a busy machine may miss the count.
            assert received >= (ticks * len(line.servos) - lost) / len(line.servos) * plan.always.rx_bytes * 0.98
        assert after[name].bad_frames == 0 or after[name].lost_replies, "what came too late is no frame"
    session.bus.close()


def test_nan_is_refused_before_a_byte_is_sent(opened: Opener) -> None:
    session = opened()
    state = session.bus.arm(PERIOD)
    sent = {name: line.tx_bytes for name, line in session.bus.statistics().items()}
    goals = list(state.position)
    goals[-1] = math.nan
    with pytest.raises(ValueError, match="nan"):
        session.bus.exchange(goals, PERIOD)
    assert {name: line.tx_bytes for name, line in session.bus.statistics().items()} == sent
    session.bus.close()


def test_disarming_lets_every_joint_go(opened: Opener) -> None:
    session = opened()
    session.bus.arm(PERIOD)
    assert session.bus.disarm() == []
    for line in session.bus.lines:
        for servo in line.servos:
            assert line.read_register(session.clock, servo, "torque_enable") == 0
    session.bus.close()
    session.bus.close()


def test_an_id_that_nobody_has_is_missed(opened: Opener) -> None:
    session = opened()
    line = next(iter(session.bus.lines))
    stranger = line.servos[0]._replace(id=99, joint="nobody")
    with pytest.raises(BusError, match=rf"nobody \(id 99, bus {line.name}\) does not answer to a read of model_number"):
        line.read_register(session.clock, stranger, "model_number")
    session.bus.close()
