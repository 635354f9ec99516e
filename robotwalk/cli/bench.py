"""`robotwalk bench`: measured here and now, beside a named reference."""

import time
from typing import Any

from cyclopts import App

from robotwalk import assembly
from robotwalk.cli.course import course
from robotwalk.cli.options import Flag, Json, Rate, RobotName
from robotwalk.cli.output import progress_line, say, write_json
from robotwalk.command_check import LONGEST_WALK
from robotwalk.errors import UsageError
from robotwalk.loop import Tick
from robotwalk.robot import Robot

app = App(name="bench", help="Measure the tick, the loop, the bus, the simulation or a robot on the courses.")
app.command(course)

_STANDING_UP_S = 3.0  # roughly; only the progress line relies on it


@app.command
def tick(
    robot: RobotName = "hexapod", /, *, rate: Rate = assembly.RATE_HZ, seconds: float = 10.0, json: Json = False
) -> None:
    """Time the whole tick, command in and goals out, while the robot walks in simulation.

    Parameters
    ----------
    seconds
        How long to walk.
    """
    simulation = assembly.simulate(robot, rate_hz=rate)
    _walk(simulation.robot, seconds)
    us = simulation.robot.loop.compute.percentiles()
    joints = len(simulation.robot.model.joints)
    fields: dict[str, Any] = {"robot": robot, "joints": joints, "tick_us": {"p50": us.p50, "p99": us.p99}}
    if json:
        write_json(fields)
    else:
        say(f"{robot}: a tick takes {us.p50:.0f} us (p99 {us.p99:.0f} us) for {joints} joints")


@app.command
def sim(robot: RobotName = "hexapod", /, *, rate: Rate = 200, seconds: float = 10.0, json: Json = False) -> None:
    """Time the whole simulated robot, bytes and servos included, beside MuJoCo's bare mj_step on the same model.

    Parameters
    ----------
    seconds
        How long to walk.
    """
    simulation = assembly.simulate(robot, rate_hz=rate)
    wall, ticks = _walk(simulation.robot, seconds)
    factor = ticks / rate / wall
    bare = assembly.bare_physics(simulation.world, seconds)
    if json:
        write_json({
            "robot": robot, "rate_hz": rate, "realtime_factor": round(factor, 2),
            "bare_mj_step_factor": round(bare, 2), "ratio": round(factor / bare, 4)})
    else:
        say(f"{robot} at {rate} Hz: {factor:.1f} x real time; bare mj_step {bare:.1f} x (ratio {factor / bare:.2f})")


@app.command
def bus(
    robot: RobotName = "hexapod", /, *, rate: Rate = assembly.RATE_HZ, baud: int | None = None, seconds: float = 5.0,
    json: Json = False,
) -> None:
    """Time the exchange with fake servos on wire-timed pseudo terminals, beside the vendor's SDK.

    Goals to all servos, position, velocity and effort back. Then again with a servo silent. cpu_us is the processor
    time of this process in one exchange, system calls included; the fake servos run in a process of their own. Where
    it has the right to, it runs at FIFO priority and keeps the processors awake, as the loop should.

    Parameters
    ----------
    baud
        Of all buses, in place of the robot's own.
    seconds
        How long to measure each.
    """
    with progress_line() as progress:
        figures = assembly.measure_bus(robot, rate_hz=rate, baud=baud, seconds=seconds, progress=progress)
    ours, wire = figures.ours, figures.wire
    bauds = sorted(set(figures.bauds.values()))
    if json:
        write_json({
            "robot": robot, "baud": bauds[0] if len(bauds) == 1 else figures.bauds, "servos": figures.servos,
            "buses": len(figures.bauds), "rate_hz": rate,
            "exchange_ms": {"p50": round(1e3 * ours.p50, 3), "p99": round(1e3 * ours.p99, 3)},
            "wire_ms": round(1e3 * wire, 3), "ratio": round(ours.p50 / wire, 3), "cpu_us": round(1e6 * ours.cpu, 1),
            "real_time": {"fifo": figures.first, "awake": figures.awake},
            "silent_servo_extra_ms": round(1e3 * figures.silent_extra, 3),
            "back_to_back_hz": round(figures.fastest_hz, 1),
            "reference": {
                name: {"exchange_ms": round(1e3 * pace.p50, 3), "cpu_us": round(1e6 * pace.cpu, 1)}
                for name, pace in ([figures.reference] if figures.reference else [])}})
        return
    say(
        f"{robot}: {figures.servos} servos on {len(figures.bauds)} bus(es) at {', '.join(map(str, bauds))} baud: an "
        f"exchange takes {1e3 * ours.p50:.2f} ms (p99 {1e3 * ours.p99:.2f} ms), {ours.p50 / wire:.2f} x the "
        f"{1e3 * wire:.2f} ms of its bytes, and {1e6 * ours.cpu:.0f} us of processor time")
    say(
        f"  a silent servo adds {1e3 * figures.silent_extra:.2f} ms to a tick that waits for it; back to back "
        f"{figures.fastest_hz:.0f} Hz")
    if not (figures.first and figures.awake):
        say("  no right to FIFO priority and to keep the processors awake: as root it is quicker")
    if figures.reference:
        name, pace = figures.reference
        say(f"  {name}: {1e3 * pace.p50:.2f} ms, and {1e6 * pace.cpu:.0f} us of processor time")


@app.command
def loop(
    robot: RobotName = "hexapod", /, *, rate: Rate = assembly.RATE_HZ, seconds: float = 20.0,
    busy: Flag = False, json: Json = False,
) -> None:
    """Time the whole loop, walking a simulated robot in another process over terminals with the wire's timing.

    Beside it, half before and half after, a bare exchange of the same bytes, and cyclictest where it is installed
    (Debian: rt-tests), both at the loop's priority on its processor.

    Parameters
    ----------
    seconds
        How long to walk, and how long to measure each of the others.
    busy
        Have another process compute all the time meanwhile.
    """
    with progress_line() as progress:
        figures = assembly.measure_loop(robot, rate_hz=rate, seconds=seconds, busy=busy, progress=progress)
    cyclic, bare = figures.cyclictest, figures.bare
    share, bare_share = figures.missed / figures.ticks, bare.missed / bare.ticks
    if json:
        write_json({
            "robot": robot, "rate_hz": rate, "seconds": seconds, "busy": busy, "ticks": figures.ticks,
            "missed": figures.missed, "missed_fraction": round(share, 6), "lost_replies": figures.lost_replies,
            "wake_us": figures.wake._asdict(), "tick_us": figures.compute._asdict(),
            "bus_us": figures.exchange._asdict(),
            "reference": {
                "cyclictest": None if cyclic is None else cyclic._asdict(),
                "bare_exchange": {
                    "missed": bare.missed, "ticks": bare.ticks, "missed_fraction": round(bare_share, 6),
                    "wake_us": bare.wake._asdict()}},
            "lacking": list(figures.lacking), "load": round(figures.load, 2)})
        return
    wake = figures.wake
    say(f"{robot} at {rate} Hz: {figures.missed} of {figures.ticks} ticks missed ({share:.2%}); a bare exchange misses "
        f"{bare_share:.2%}")
    say(f"  awake {wake.p50:.0f} us late (p99 {wake.p99:.0f} us, p99.9 {wake.p999:.0f} us, at most {wake.max:.0f} us)")
    if cyclic is not None:
        say(f"  cyclictest: {cyclic.p50:.0f} us (p99 {cyclic.p99:.0f} us, at most {cyclic.max:.0f} us)")
    bus, rest = figures.exchange, figures.compute
    say(f"  bus {bus.p50:.0f} us (p99 {bus.p99:.0f} us), all else {rest.p50:.0f} us (p99 {rest.p99:.0f} us), "
        f"{figures.lost_replies} replies lost; load {figures.load:.1f}")
    for sentence in figures.lacking:
        say(f"  {sentence}")


def _walk(robot: Robot, seconds: float) -> tuple[float, int]:
    """Stand up and walk; return the wall seconds and the ticks that it took."""
    if not 0.0 < seconds <= LONGEST_WALK:
        raise UsageError(f"--seconds should be above 0 and at most {LONGEST_WALK:.0f}, not {seconds}")
    ticks = 0
    expected = (seconds + _STANDING_UP_S) * robot.loop.rate_hz
    with progress_line() as progress, robot:

        def watch(tick: Tick) -> None:
            nonlocal ticks
            ticks += 1
            if ticks % robot.loop.rate_hz == 0:
                progress(tick.state.value, min(ticks / expected, 1.0))

        robot.observers.append(watch)
        began = time.perf_counter()
        robot.stand()
        robot.walk(0.5 * robot.model.motion.speed, seconds=seconds)
        return time.perf_counter() - began, ticks
