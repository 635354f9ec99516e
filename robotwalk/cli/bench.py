"""`robotwalk bench`: measured here and now, beside a named reference."""

import time
from typing import Annotated, Any

from cyclopts import App, Parameter

from robotwalk import assembly
from robotwalk.cli.output import progress_line, say, write_json
from robotwalk.errors import UsageError
from robotwalk.loop import Tick
from robotwalk.robot import LONGEST_WALK, Robot

app = App(name="bench", help="Measure the tick or the simulation on this computer.")

_STANDING_UP_S = 3.0  # roughly; only the progress line relies on it
Json = Annotated[bool, Parameter(name="--json", negative="", help="one JSON object on stdout")]


@app.command
def tick(robot: str = "hexapod", /, *, rate: int = assembly.RATE_HZ, seconds: float = 10.0, json: Json = False) -> None:
    """Time the whole tick, command in and goals out, while the robot walks in simulation.

    Parameters
    ----------
    robot
        A bundled name or a YAML file.
    rate
        Ticks per second.
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
def sim(robot: str = "hexapod", /, *, rate: int = 200, seconds: float = 10.0, json: Json = False) -> None:
    """Time the whole simulated robot, bytes and servos included, beside MuJoCo's bare mj_step on the same model.

    Parameters
    ----------
    robot
        A bundled name or a YAML file.
    rate
        Ticks per second.
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
