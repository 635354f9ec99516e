"""What the bus plan says a tick takes, against what it takes on the simulated wire, in simulated time."""

import statistics
from collections.abc import Iterator
from typing import NamedTuple

import pytest

from hal import bus_plan
from hal.protocols import protocol_of
from robotwalk import assembly
from robotwalk.assembly.bus_bench import at_baud, bench_servos
from robotwalk.assembly.session import bus_of
from robotwalk.clock import Grid
from robotwalk.config import library
from sim_backend.adapter import AdapterName
from sim_backend.vice import Bench

NS = 1_000_000_000
SLOWEST = 20  # Hz, below which a robot's bus is of no use
BLUEPRINTS = {name: assembly.load(name) for name in library.names("robots")}
TIMERS = {"ftdi1": 1e-3, "ftdi16": 16e-3}


class Times(NamedTuple):
    """Of one tick's exchange, s."""

    planned: float
    measured: float


def times(
    robot: str, baud: int | None = None, *, adapter: AdapterName = "none", old_firmware: bool = False,
    return_delay: float = 0.0,
) -> Times | None:
    """Plan and measure a robot's exchange at 100 Hz or the rate that its buses can carry; None if that is too slow."""
    blueprint = BLUEPRINTS[robot] if baud is None else at_baud(BLUEPRINTS[robot], baud)
    plans = {
        bus: bus_plan.cycle(protocol_of(wired[0].model), wired, fast=not old_firmware)
        for bus, wired in blueprint.wiring.items()}
    waits = {
        bus: {
            "return_delay": return_delay,
            "latency": plan.held_back(blueprint.bauds[bus], TIMERS[adapter]) if adapter in TIMERS else 0.0}
        for bus, plan in plans.items()}
    rate = min(100, *(plan.largest_rate(blueprint.bauds[bus], 0.8, **waits[bus]) for bus, plan in plans.items()))
    if rate < SLOWEST:
        return None
    bench = Bench(bench_servos(blueprint), blueprint.bauds, adapter)
    if old_firmware:
        for fake in bench.servos:
            if fake.model.fast_sync_read_firmware is not None:
                fake.run_firmware(fake.model.fast_sync_read_firmware - 1)
    bus = bus_of(blueprint, bench.clock, bench.ports)
    period = NS // rate
    goals = bus.arm(period).position
    if return_delay:
        for fake in bench.servos:
            fake.table["return_delay_time"] = round(return_delay / fake.model["return_delay_time"].si_scale)
            fake._configure()
        bus.arm(period)  # finds them with torque on: it leaves the delay, and reckons with it
    grid = Grid(rate, bench.clock.now())
    took = []
    for _ in range(5):
        bench.clock.wait((), grid.deadline)
        began = bench.clock.now()
        assert all(bus.exchange(goals, period).valid)
        took.append((bench.clock.now() - began) / NS)
        grid.advance(bench.clock.now())
    planned = max(plan.taken(blueprint.bauds[name], rate, **waits[name]) for name, plan in plans.items())
    return Times(planned, statistics.median(took))


def robots_and_bauds() -> Iterator[tuple[str, int]]:
    """Each robot at the fastest baud that all its servos have, and at two slower ones."""
    for robot, blueprint in BLUEPRINTS.items():
        common = set.intersection(
            *({*blueprint.servos[row.servo].baud_rates} for row in blueprint.hardware.joints.values()))
        yield from ((robot, baud) for baud in sorted(common, reverse=True)[:6:2])


@pytest.mark.parametrize(("robot", "baud"), list(robots_and_bauds()))
def test_every_robot_takes_its_planned_time_at_every_baud(robot: str, baud: int) -> None:
    found = times(robot, baud)
    if found is not None:
        assert found.measured == pytest.approx(found.planned, rel=0.02)


@pytest.mark.parametrize("robot", library.names("robots"))
def test_so_it_does_when_servos_wait_before_they_answer(robot: str) -> None:
    found = times(robot, return_delay=500e-6)
    assert found is not None
    assert found.measured == pytest.approx(found.planned, rel=0.02)


@pytest.mark.parametrize("robot", ["hexapod", "hexapod_xl330"])
def test_so_it_does_with_firmware_that_has_no_fast_read(robot: str) -> None:
    found = times(robot, old_firmware=True)
    assert found is not None
    assert found.measured == pytest.approx(found.planned, rel=0.02)


@pytest.mark.parametrize("robot", library.names("robots"))
@pytest.mark.parametrize("adapter", ["ftdi1", "ftdi16"])
def test_so_it_does_behind_an_adapter_that_holds_replies_back(robot: str, adapter: AdapterName) -> None:
    found = times(robot, adapter=adapter)
    if found is not None:
        assert found.measured == pytest.approx(found.planned, rel=0.05)
