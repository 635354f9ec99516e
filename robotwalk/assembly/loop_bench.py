"""The whole loop, measured: against a simulated robot in another process, beside cyclictest and a bare exchange."""

import contextlib
import multiprocessing
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from robotwalk.assembly.bare_exchange import Bare, serve_bare
from robotwalk.assembly.blueprint import Blueprint, load
from robotwalk.assembly.connected import connect
from robotwalk.assembly.own_device import own_device
from robotwalk.assembly.session import check_rate
from robotwalk.errors import BusError, UsageError
from robotwalk.realtime import LOOP_PRIORITY, own_processor
from robotwalk.timing import Percentiles

_ARMED = 30.0  # s within which a bare exchange begins
_OVERFLOW = 100_000  # us, the largest latency that cyclictest's histogram has a row for

Progress = Callable[[str, float], None]


class Wakes(NamedTuple):
    """What cyclictest measured, us."""

    p50: float
    p99: float
    max: float


class LoopFigures(NamedTuple):
    """What was measured."""

    ticks: int
    missed: int
    wake: Percentiles  # us
    compute: Percentiles
    exchange: Percentiles
    lost_replies: int
    cyclictest: Wakes | None  # None: not installed, or without the right to FIFO
    bare: Bare
    lacking: tuple[str, ...]  # what the loop was not given, in words
    load: float  # processes that wanted to run, over the last minute


def measure_loop(
    robot: str, *, rate_hz: int, seconds: float, busy: bool, progress: Progress
) -> LoopFigures:
    """Walk for so many seconds, and run cyclictest and a bare exchange, half before and half after that.

    Args:
        robot: name or path.
        rate_hz: ticks per second.
        seconds: of each.
        busy: have another process of ordinary priority compute all the time.
        progress: told what goes on, and the share that is done.

    Raises:
        UsageError: no such robot, or a rate or a time that is impossible.
        BusError: a bus is too slow for the rate, or the simulated robot does not start.
    """
    check_rate(rate_hz)
    if not 1.0 <= seconds <= 3600.0:
        raise UsageError(f"--seconds should be 1 to 3600, not {seconds}")
    blueprint = load(robot)
    with own_device(robot, {}) as device, _kept_busy(busy):
        progress("cyclictest", 0.0)
        wakes = [_cyclictest(rate_hz, seconds / 2.0)]
        progress("a bare exchange", 0.15)
        bares = [_bare(blueprint, device.ports, rate_hz, seconds / 2.0)]
        session = connect(blueprint, device.ports, rate_hz=rate_hz)
        with session.robot as walker:
            progress("it stands up", 0.35)
            walker.stand()
            loop = walker.loop
            before = walker.bus_statistics()
            missed = loop.missed
            for histogram in (loop.wake, loop.exchange, loop.compute):
                histogram.clear()
            progress("it walks", 0.4)
            walker.walk(0.5 * walker.model.motion.speed, seconds=seconds)
            wake, compute, exchange = (
                histogram.percentiles() for histogram in (loop.wake, loop.compute, loop.exchange))
            counted, missed = loop.wake.count, loop.missed - missed
            after = walker.bus_statistics()
        lacking = tuple(event.text for event in walker.events if event.kind == "real_time")
        progress("a bare exchange", 0.75)
        bares.append(_bare(blueprint, device.ports, rate_hz, seconds / 2.0))
        progress("cyclictest", 0.9)
        wakes.append(_cyclictest(rate_hz, seconds / 2.0))
    lost = sum(after[bus].lost_replies - before[bus].lost_replies for bus in after)
    return LoopFigures(
        counted, missed, wake, compute, exchange, lost, _joined(wakes),
        Bare(sum(bare.ticks for bare in bares), sum(bare.missed for bare in bares), bares[-1].wake), lacking,
        os.getloadavg()[0])


@contextlib.contextmanager
def _kept_busy(busy: bool) -> Iterator[None]:
    """Have a process compute all the time, on whatever processor Linux gives it."""
    process = subprocess.Popen([sys.executable, "-c", "while True: pass"]) if busy else None
    try:
        yield
    finally:
        if process is not None:
            process.kill()
            process.wait()


def _bare(blueprint: Blueprint, urls: Mapping[str, str], rate_hz: int, seconds: float) -> Bare:
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(
        target=serve_bare, args=(blueprint.files.texts(), urls, rate_hz, seconds, there), daemon=True)
    process.start()
    there.close()
    try:
        if not here.poll(_ARMED + 2.0 * seconds):
            raise BusError("the bare exchange does not end")
        bare: Bare = here.recv()
    except EOFError:
        raise BusError("the bare exchange failed") from None
    finally:
        process.kill()
        process.join()
    return bare


def _cyclictest(rate_hz: int, seconds: float) -> list[int] | None:
    """Return how often each latency came, by whole us; None if there is no cyclictest, or it may not run."""
    if shutil.which("cyclictest") is None:
        return None
    loops = max(round(rate_hz * seconds), 1)
    done = subprocess.run(
        ["cyclictest", "-q", "-m", "-t1", f"-p{LOOP_PRIORITY}", f"-a{own_processor()}", f"-i{1_000_000 // rate_hz}",
         f"-l{loops}", f"-h{_OVERFLOW}"], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        return None
    counts = [0] * (_OVERFLOW + 1)
    for line in done.stdout.splitlines():
        words = line.split()
        if len(words) == 2 and all(word.isdigit() for word in words):
            counts[int(words[0])] += int(words[1])
    counts[_OVERFLOW] += loops - sum(counts)  # those beyond the histogram
    return counts


def _joined(runs: list[list[int] | None]) -> Wakes | None:
    """Return the percentiles of all runs; None if there is none."""
    there = [run for run in runs if run is not None]
    counts = [sum(column) for column in zip(*there, strict=True)]
    if not any(counts):
        return None

    def quantile(share: float) -> float:
        seen, wanted = 0, share * sum(counts)
        for latency, count in enumerate(counts):
            seen += count
            if count and seen >= wanted:
                return float(latency)
        return float(_OVERFLOW)

    return Wakes(quantile(0.5), quantile(0.99), quantile(1.0))
