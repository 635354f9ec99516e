"""Lost bytes and silent servos: what the robot does then."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import pytest

from robotwalk import assembly
from robotwalk.config.safety import RecoveryConfig, SafetyConfig
from robotwalk.errors import BusError, SafetyStop, UsageError
from robotwalk.loop import Tick
from robotwalk.supervisor import State
from sim_backend.device import Reply

pytestmark = pytest.mark.usefixtures("watched_joints")

Tamper = Callable[[list[Reply], int], list[Reply]]


class TamperedDevice:
    """Everything on a bus, with someone at the wire on its way back."""

    def __init__(self, device: object, tamper: Tamper) -> None:
        self.device, self.tamper = device, tamper

    def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
        return self.tamper(self.device.receive(data, now, baud), now)  # type: ignore[attr-defined]


def frail() -> assembly.Blueprint:
    """Return a hexapod that sits down for good at the first servo that is silent."""
    hexapod = assembly.load("hexapod")
    recovery = RecoveryConfig(tries=0, walk_on_with_legs=None)
    return replace(hexapod, model=replace(hexapod.model, safety=SafetyConfig(recovery=recovery)))


def tampered(tamper: Tamper) -> assembly.Simulation:
    simulation = assembly.simulate(frail())
    simulation.world.ports["legs"].device = TamperedDevice(simulation.world.ports["legs"].device, tamper)
    return simulation


def seconds(ns: int) -> float:
    return ns * 1e-9


def test_an_unpowered_bus_is_reported_with_the_joints_that_are_missing() -> None:
    simulation = tampered(lambda replies, now: [])
    with simulation.robot as robot, pytest.raises(BusError, match=r"lf_coxa \(id 1\).*rr_tibia \(id 18\).*powered"):
        robot.stand()
    assert simulation.world.truth().base.z == pytest.approx(0.025, abs=0.003)


def test_one_reply_in_twenty_lost_costs_samples_but_no_step() -> None:
    count = 0

    def lose_some(replies: list[Reply], now: int) -> list[Reply]:
        nonlocal count
        if seconds(now) < 0.5 or sum(len(reply.data) for reply in replies) < 200:
            return replies
        count += 1
        return [] if count % 20 == 0 else replies

    simulation = tampered(lose_some)
    with simulation.robot as robot:
        robot.stand()
        before = simulation.world.truth().base
        robot.walk(vx=0.10, seconds=5.0)
        assert simulation.world.truth().base.x - before.x == pytest.approx(0.5, rel=0.10)
    lost = robot.bus_statistics()["legs"].lost_replies
    assert lost > 18 * 20
    assert lost % 18 == 0


def test_a_joint_reply_cut_short_keeps_the_joints_before_the_cut() -> None:
    def cut(replies: list[Reply], now: int) -> list[Reply]:
        # 8 bytes of head and 14 a servo: leave seven servos whole.
        return [Reply(r.delay_ns, r.data[: 8 + 7 * 14 + 3]) if len(r.data) > 200 else r for r in replies]

    simulation = assembly.simulate("hexapod")
    port = simulation.world.ports["legs"]
    honest = port.device
    seen: list[Tick] = []

    def cut_one_tick(tick: Tick) -> None:
        seen.append(tick)
        port.device = TamperedDevice(honest, cut) if len(seen) == 1 else honest

    with simulation.robot as robot:
        robot.stand()
        robot.observers.append(cut_one_tick)
        robot.walk(vx=0.05, seconds=0.2)
    before, during, after = (tick.joints for tick in seen[:3])
    assert during.valid == (True,) * 7 + (False,) * 11
    assert during.age[0] == 0.0
    # The others were last heard of in the tick before, and this one waited for them in vain.
    assert 0.01 <= during.age[17] < 0.015
    assert during.position[7:] == before.position[7:], "a failed read is never data"
    assert after.valid == (True,) * 18
    assert after.age == (0.0,) * 18


def test_a_dead_servo_costs_those_behind_it_one_sample_and_two_milliseconds_at_most() -> None:
    simulation = assembly.simulate("hexapod", faults=[{"at": 5.0, "fault": "dead_servo", "joint": "lm_coxa"}])
    ticks: list[Tick] = []
    with simulation.robot as robot:
        robot.stand()
        robot.observers.append(ticks.append)
        robot.walk(vx=0.05, seconds=3.0)
    first = next(i for i, tick in enumerate(ticks) if not all(tick.joints.valid))
    assert ticks[first].joints.valid == (True,) * 3 + (False,) * 15
    for tick in ticks[first + 1 : first + 40]:
        assert tick.joints.valid == (True,) * 3 + (False,) + (True,) * 14
    exchange = robot.loop.exchange.percentiles()
    assert exchange.max <= exchange.p50 + 2000


def test_a_servo_that_falls_silent_for_good_ends_in_a_sit_with_torque_off() -> None:
    def silence(replies: list[Reply], now: int) -> list[Reply]:
        # Joint reply stops before the last servo.
        return [Reply(r.delay_ns, r.data[:-14]) if len(r.data) > 200 and seconds(now) > 5.0 else r for r in replies]

    simulation = tampered(silence)
    ticks: list[Tick] = []
    with simulation.robot as robot:
        robot.observers.append(ticks.append)
        robot.stand()
        with pytest.raises(SafetyStop, match=r"joint rr_tibia has not answered for 0\.5\d s"):
            robot.walk(vx=0.10, seconds=20.0)
        assert robot.loop.supervisor.state is State.STOP
    assert State.FAULT in {tick.state for tick in ticks}
    assert simulation.world.truth().base.z < 0.04
    assert all(servo.table["torque_enable"] == 0 for servo in simulation.world.servos)
    tilts = [abs(simulation.world.truth().base.roll), abs(simulation.world.truth().base.pitch)]
    assert max(tilts) < 0.05


@pytest.mark.parametrize("at", [4.0, 4.3, 4.6, 4.9, 5.2])
def test_a_fault_near_the_end_of_a_walk_is_no_success_and_no_fall(at: float) -> None:
    def silence(replies: list[Reply], now: int) -> list[Reply]:
        return [Reply(r.delay_ns, r.data[:-14]) if len(r.data) > 200 and seconds(now) > at else r for r in replies]

    simulation = tampered(silence)

    def session() -> None:
        with simulation.robot as robot:
            robot.stand()
            robot.walk(vx=0.10, seconds=2.0)
            robot.walk(vx=0.10, seconds=2.0)

    with pytest.raises(SafetyStop, match="rr_tibia"):
        session()
    assert "safety_stop" in [event.kind for event in simulation.robot.events]
    assert simulation.world.truth().base.z < 0.04


def test_an_interrupt_while_a_fault_brings_the_robot_down_does_not_drop_it() -> None:
    def silence(replies: list[Reply], now: int) -> list[Reply]:
        return [Reply(r.delay_ns, r.data[:-14]) if len(r.data) > 200 and seconds(now) > 5.0 else r for r in replies]

    simulation = tampered(silence)
    heights: list[float] = []
    interrupted = False

    def impatient(tick: Tick) -> None:
        nonlocal interrupted
        heights.append(simulation.world.truth().base.z)
        if tick.state is State.FAULT and not interrupted:
            interrupted = True
            raise KeyboardInterrupt

    def session() -> None:
        with simulation.robot as robot:
            robot.observers.append(impatient)
            robot.stand()
            robot.walk(vx=0.10, seconds=20.0)

    with pytest.raises(SafetyStop):
        session()
    drops = [a - b for a, b in pairwise(heights)]
    assert max(drops) < 0.002, "lowered, at 6 cm/s, not dropped"
    assert simulation.world.truth().base.z < 0.04


def test_a_servo_that_overheats_in_mid_walk_brings_the_robot_down() -> None:
    simulation = assembly.simulate("hexapod")

    def heat(tick: Tick) -> None:
        if tick.state is State.WALK:
            simulation.world.physics.temperature_c[5] = 90.0

    def session() -> None:
        with simulation.robot as robot:
            robot.stand()
            robot.observers.append(heat)
            robot.walk(vx=0.05, seconds=5.0)

    with pytest.raises(SafetyStop, match="the servo of lm_tibia reports overheating"):
        session()
    assert simulation.world.truth().base.z < 0.04
    assert all(servo.table["torque_enable"] == 0 for servo in simulation.world.servos)


def test_a_robot_that_nobody_armed_is_left_as_it_is() -> None:
    simulation = assembly.simulate("hexapod")
    for servo in simulation.world.servos:
        servo.table["torque_enable"] = 1
    with simulation.robot:
        pass
    assert all(servo.table["torque_enable"] == 1 for servo in simulation.world.servos)


def test_a_robot_is_used_in_a_with_block_only() -> None:
    robot = assembly.simulate("hexapod").robot
    with pytest.raises(UsageError, match="`with` block"):
        robot.stand()
    with robot:
        robot.stand()
        robot.stand()
    with pytest.raises(UsageError, match="`with` block"):
        robot.stand()


def test_a_dead_wire_is_no_claim_that_torque_is_off() -> None:
    simulation = assembly.simulate("hexapod")
    port = simulation.world.ports["legs"]

    class Dead:
        def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
            return []

    def cut(tick: Tick) -> None:
        if tick.state is State.WALK:
            port.device = Dead()

    def session() -> None:
        with simulation.robot as robot:
            robot.stand()
            robot.observers.append(cut)
            robot.walk(vx=0.10, seconds=5.0)

    with pytest.raises(SafetyStop, match=r"torque may still be on at lf_coxa, .*: cut the power"):
        session()


def test_another_model_at_an_id_is_named() -> None:
    simulation = assembly.simulate("hexapod")
    simulation.world.servos[0].table["model_number"] = 1020
    with simulation.robot as robot, pytest.raises(BusError, match=r"lf_coxa .* should be a xl430-w250 .* 1020"):
        robot.stand()


def test_a_second_interrupt_freezes_the_robot_where_it_is_with_torque_on() -> None:
    simulation = assembly.simulate("hexapod")

    def impatient(tick: Tick) -> None:
        if tick.state is State.SIT:
            raise KeyboardInterrupt

    robot = simulation.robot

    def session() -> None:
        with robot:
            robot.stand()
            robot.observers.append(impatient)
            robot.walk(vx=0.10, seconds=1.0)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        session()
    simulation.world.clock.wait((), simulation.world.clock.now() + 2_000_000_000)
    assert all(servo.table["torque_enable"] == 1 for servo in simulation.world.servos)
    assert simulation.world.truth().base.z == pytest.approx(0.102, abs=0.006)
    assert "freeze" in [event.kind for event in robot.events]


def test_an_observer_that_fails_does_not_keep_the_robot_from_sitting() -> None:
    simulation = assembly.simulate("hexapod")

    def broken(tick: Tick) -> None:
        if tick.state in (State.WALK, State.SIT):
            raise OSError("the terminal is gone")

    def session() -> None:
        with simulation.robot as robot:
            robot.stand()
            robot.observers.append(broken)
            robot.walk(vx=0.10, seconds=1.0)

    with pytest.raises(OSError, match="terminal"):
        session()
    assert simulation.world.truth().base.z < 0.04
    assert all(servo.table["torque_enable"] == 0 for servo in simulation.world.servos)


def test_the_robot_starts_seated_torque_off_well_inside_its_limits() -> None:
    simulation = assembly.simulate("hexapod")
    clock = simulation.world.clock
    clock.wait((), clock.now() + 500_000_000)
    truth = simulation.world.truth()
    for joint, angle in zip(simulation.robot.model.joints, truth.joints, strict=True):
        assert joint.lower + 0.3 <= angle <= joint.upper - 0.3, joint.name
    assert all(servo.table["torque_enable"] == 0 for servo in simulation.world.servos)
    assert all(truth.contacts)
