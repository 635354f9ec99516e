"""The exchange, measured: ours against fake servos on wire-timed pseudo terminals, a vendor's SDK beside it."""

import gc
import multiprocessing
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from hal import bus_plan
from hal.protocols import protocol_of
from hal.serial_transport import open_port
from hal.vendor_exchange import VendorLines, vendor_of
from hal.wired import Wired
from robotwalk.assembly.blueprint import Blueprint, load
from robotwalk.assembly.session import bus_of, check_rate
from robotwalk.clock import Grid, WallClock
from robotwalk.errors import BusError, UsageError
from robotwalk.realtime import processors_awake, raise_priority, sharpen_timers

if TYPE_CHECKING:
    from sim_backend.vice import BenchServo

_NS = 1_000_000_000
_STARTED = 20.0  # s within which the fake servos must be there
_AWAY = 250  # an id that no bundled robot has
_PATIENCE = 20  # times the time asked for, until one exchange at least was whole on a computer that stalls


class Pace(NamedTuple):
    """How long exchanges took."""

    p50: float  # s
    p99: float
    cpu: float  # s of this process's processor time, in Python and in the kernel; median


class BusFigures(NamedTuple):
    """What was measured."""

    bauds: dict[str, int]
    servos: int
    wire: float  # s that the bytes take, on the bus that takes longest
    ours: Pace
    silent_extra: float  # s that a tick takes longer in which a silent servo is waited for, median
    fastest_hz: float  # exchanges per second, one straight after the other
    reference: tuple[str, Pace] | None  # the vendor's SDK, if one knows all servos
    first: bool  # whether this ran before ordinary processes, as the loop does where it has the right to
    awake: bool  # whether the processors were kept awake meanwhile


def measure_bus(
    robot: str, *, rate_hz: int, baud: int | None, seconds: float, progress: Callable[[str, float], None]
) -> BusFigures:
    """Measure a robot's exchange, for so many seconds each.

    Raises:
        UsageError: no such robot, or a rate or a time that is impossible.
        ConfigError: a file is wrong, or the servos do not have that baud rate.
        BusError: the bus is too slow for the rate.
    """
    check_rate(rate_hz)
    if not 0.0 < seconds <= 600.0:
        raise UsageError(f"--seconds should be above 0 and at most 600, not {seconds}")
    blueprint = load(robot)
    if baud is not None:
        blueprint = at_baud(blueprint, baud)
    wire = max(
        bus_plan.cycle(protocol_of(wired[0].model), wired, fast=True).whole.seconds(blueprint.bauds[bus])
        for bus, wired in blueprint.wiring.items())
    first = raise_priority()
    sharpen_timers()
    with processors_awake() as awake, _fakes(blueprint) as urls:
        vendor, reference = vendor_of([servo for wired in blueprint.wiring.values() for servo in wired]), None
        ours, silent, fastest = _measure_ours(blueprint, urls, rate_hz, seconds, progress)
        if vendor is not None:
            progress(vendor, 0.75)
            lines = VendorLines(urls, blueprint.bauds, blueprint.wiring)
            try:
                pace = _paced(lines.exchange, rate_hz, seconds)
            finally:
                lines.close()
            reference = None if pace is None else (vendor, pace)
    return BusFigures(
        blueprint.bauds, len(blueprint.model.joints), wire, ours, max(silent - ours.p50, 0.0), fastest, reference,
        first, awake)


def at_baud(blueprint: Blueprint, baud: int) -> Blueprint:
    """Return the robot with another baud rate on all buses.

    Raises:
        UsageError: a servo does not have it.
    """
    for servo in {row.servo for row in blueprint.hardware.joints.values()}:
        try:
            blueprint.servos[servo].baud_value(baud)
        except ValueError as error:
            raise UsageError(str(error)) from None
    buses = {name: bus.model_copy(update={"baud": baud}) for name, bus in blueprint.hardware.buses.items()}
    return replace(blueprint, hardware=blueprint.hardware.model_copy(update={"buses": buses}))


def bench_servos(blueprint: Blueprint) -> "list[BenchServo]":
    """Return a robot's servos, each with its shaft in the middle of its joint's range."""
    from sim_backend.vice import BenchServo  # loads MuJoCo

    return [
        BenchServo(bus, servo.id, servo.model, _shaft(servo))
        for bus, wired in blueprint.wiring.items() for servo in wired]


@contextmanager
def _fakes(blueprint: Blueprint) -> Iterator[Mapping[str, str]]:
    """Run the robot's servos in a process of their own; yield the URLs of their buses."""
    from sim_backend.vice import serve_bench

    servos = bench_servos(blueprint)
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    with tempfile.TemporaryDirectory() as folder:
        process = context.Process(
            target=serve_bench, args=(servos, blueprint.bauds, Path(folder), there), daemon=True)
        process.start()
        there.close()
        try:
            if not here.poll(_STARTED):
                raise BusError("the fake servos do not start")
            yield here.recv()
        finally:
            here.close()
            process.join(_STARTED)


def _shaft(servo: Wired) -> float:
    """Return the shaft's angle where its joint is in the middle of its range."""
    middle = 0.5 * (servo.lower + servo.upper)
    return servo.calibration.direction * (middle - servo.calibration.zero)


def _measure_ours(
    blueprint: Blueprint, urls: Mapping[str, str], rate_hz: int, seconds: float,
    progress: Callable[[str, float], None],
) -> tuple[Pace, float, float]:
    """Return the pace, the median time (s) of a tick that waits for a silent servo, and the largest rate (Hz)."""
    clock = WallClock()
    bus = bus_of(blueprint, clock, {name: open_port(url, blueprint.bauds[name]) for name, url in urls.items()})
    period = _NS // rate_hz
    try:
        progress("arming", 0.0)
        goals = bus.arm(period).position
        progress("exchange", 0.1)
        ours = _paced(lambda: all(bus.exchange(goals, period).valid), rate_hz, seconds)
        if ours is None:
            raise BusError("no exchange was whole: this computer is too busy to measure")
        progress("back to back", 0.3)
        fastest = _back_to_back(lambda: bus.exchange(goals, period // 2), seconds)
        progress("one servo silent", 0.5)
        silent: list[int] = []
        line = bus.lines[0]
        victim = line.servos[len(line.servos) // 2]
        bus.disarm()
        register = victim.model["id"]
        line.write(clock, victim, register.address, bytes((_AWAY,)), "another id")

        def exchange() -> bool:
            lost, began = line.cycle.lost_replies, time.monotonic_ns()
            bus.exchange(goals, period)
            if line.cycle.lost_replies > lost:
                silent.append(time.monotonic_ns() - began)
            return True

        _paced(exchange, rate_hz, seconds)
        line.write(clock, victim._replace(id=_AWAY), register.address, bytes((victim.id,)), "its id")
        line.read_register(clock, victim, "id")  # it is back: the vendor's SDK is to find it
        return ours, statistics.median(silent) / _NS if silent else ours.p50, fastest
    finally:
        bus.close()


def _paced(exchange: Callable[[], bool], rate_hz: int, seconds: float) -> Pace | None:
    """Exchange at a rate; return how long those took in which all answered, None if there was none for long."""
    clock, took, cpu = WallClock(), list[int](), list[int]()
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        grid = Grid(rate_hz, clock.now())
        wanted = max(round(seconds * rate_hz), 1)
        for turn in range(_PATIENCE * wanted):
            if turn >= wanted and took:
                break
            clock.wait((), grid.deadline)
            busy, began = time.process_time_ns(), clock.now()
            good = exchange()
            now = clock.now()
            if good:
                took.append(now - began)
                cpu.append(time.process_time_ns() - busy)
            grid.advance(now)
    finally:
        gc.enable()
        gc.unfreeze()
    if not took:
        return None
    took.sort()
    return Pace(statistics.median(took) / _NS, took[int(0.99 * len(took))] / _NS, statistics.median(cpu) / _NS)


def _back_to_back(exchange: Callable[[], object], seconds: float) -> float:
    """Return how many exchanges a second there were, one straight after the other."""
    began, count = time.monotonic(), 0
    while time.monotonic() - began < seconds:
        exchange()
        count += 1
    return count / (time.monotonic() - began)
