"""`robotwalk bench course`: how a robot gets over the courses, in numbers that can be laid side by side."""

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context
from statistics import median
from typing import Any, NamedTuple

from robotwalk import assembly
from robotwalk.cli.options import Flag, Json, Names, RobotName
from robotwalk.cli.outing import Outing, Plan, require_possible
from robotwalk.cli.output import progress_line, write_json, write_table
from robotwalk.config import library
from robotwalk.errors import SafetyStop, UsageError


class Trial(NamedTuple):
    """One walk over one course."""

    robot: str
    gait: str | None
    terrain: str
    seed: int
    speed: float  # m/s
    seconds: float
    blind: bool


class Result(NamedTuple):
    """What came of it."""

    gait: str
    share: float  # of the commanded distance
    tilt_deg: float  # the largest
    yaw_deg: float  # at the end, either way
    fell: bool
    stopped: bool  # by the safety stop
    barred: bool  # by an edge or by what its feet could not step over
    realtime_factor: float


def course(
    robot: RobotName = "hexapod", /, *, terrain: Names = None, gait: Names = None, speed: float = 0.06,
    seconds: float = 20.0, seeds: int = 10, jobs: int = 2, blind: Flag = False,
    json: Json = False,
) -> None:
    """Walk straight over courses, from several seeds each: share of the commanded distance, tilt, yaw, falls.

    A seed decides how the robot sits, and what chance decides of the ground.

    Parameters
    ----------
    terrain
        A name from `robotwalk list terrains`, or the path of a YAML file; once for each. Default: all that are bundled.
    gait
        A name from `robotwalk list gaits`; once for each. Default: the robot's own.
    speed
        Metres per second, ahead.
    seconds
        How long each walk lasts.
    seeds
        How many walks over each course: with the seeds 0, 1, 2 and so on.
    jobs
        How many at a time, each in a process of its own.
    blind
        Walk each course also without contact, orientation and levelling, to see side by side what they buy.
    """
    if seeds < 1 or jobs < 1:
        raise UsageError("--seeds and --jobs should be at least 1")
    if speed == 0.0 or seconds <= 0.0 or not (math.isfinite(speed) and math.isfinite(seconds)):
        raise UsageError("--speed should not be 0, and --seconds above 0")
    terrains = terrain or library.names("terrains")
    gaits: Sequence[str | None] = gait or [None]
    blueprint = assembly.load(robot)
    for name in gaits:
        require_possible(_plan(speed, seconds, name), blueprint)
    for name in terrains:
        assembly.load_terrain(name)
    ways = (False, True) if blind else (False,)
    trials = [
        Trial(robot, name, ground, seed, speed, seconds, without)
        for name, ground, without, seed in product(gaits, terrains, ways, range(seeds))]
    with progress_line() as progress:
        results = []
        for result in _run(trials, jobs):
            results.append(result)
            trial = trials[len(results) - 1]
            progress(f"{result.gait} {trial.terrain} {trial.seed}", len(results) / len(trials))
    rows = [
        {"terrain": trials[first].terrain, "blind": trials[first].blind, **_summary(results[first:first + seeds])}
        for first in range(0, len(trials), seeds)]
    if json:
        write_json({
            "robot": blueprint.model.name, "speed_mps": speed, "seconds": seconds, "seeds": seeds, "courses": rows})
    else:
        _show(rows)


def _run(trials: Sequence[Trial], jobs: int) -> Iterator[Result]:
    """Yield the results in the order of the trials."""
    if jobs == 1:
        yield from map(walk_course, trials)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        yield from pool.map(walk_course, trials)


def walk_course(trial: Trial) -> Result:
    """Walk one course."""
    robot = assembly.load(trial.robot)
    simulation = assembly.simulate(robot.blind if trial.blind else robot, seed=trial.seed, terrain=trial.terrain)
    outing = Outing(simulation, _plan(trial.speed, trial.seconds, trial.gait))
    stopped = False
    try:
        outing.run(lambda text, share: None)
    except SafetyStop:
        stopped = True
    report = outing.report()
    return Result(
        report["gait"], report["distance_m"] / abs(trial.speed * trial.seconds), report["max_tilt_deg"],
        abs(report["heading_change_deg"]), report["fell"], stopped,
        any(event["kind"] in ("edge", "obstacle") for event in report["events"]), report["realtime_factor"])


def _plan(speed: float, seconds: float, gait: str | None) -> Plan:
    return Plan(abs(speed), 0.0 if speed > 0.0 else math.pi, None, 0.0, None, seconds, gait)


def _summary(results: Sequence[Result]) -> dict[str, Any]:
    """Return the middle and the worst of what came of one course's walks."""
    shares = [result.share for result in results]
    tilts = [result.tilt_deg for result in results]
    yaws = [result.yaw_deg for result in results]
    return {
        "gait": results[0].gait,
        "distance_share": {"median": round(median(shares), 3), "min": round(min(shares), 3)},
        "max_tilt_deg": {"median": round(median(tilts), 1), "max": round(max(tilts), 1)},
        "yaw_deg": {"median": round(median(yaws), 1), "max": round(max(yaws), 1)},
        "falls": sum(result.fell for result in results),
        "safety_stops": sum(result.stopped for result in results),
        "barred": sum(result.barred for result in results),
        "realtime_factor": round(median(result.realtime_factor for result in results), 1),
    }


def _show(rows: Sequence[dict[str, Any]]) -> None:
    write_table(
        "median and worst; degrees",
        ["terrain", "gait", "way", "tilt", "yaw", "fell", "sat", "barred"],
        [[
            f"{row['terrain']}{' blind' if row['blind'] else ''}", row["gait"],
            f"{row['distance_share']['median']:.0%} {row['distance_share']['min']:.0%}",
            f"{row['max_tilt_deg']['median']} {row['max_tilt_deg']['max']}",
            f"{row['yaw_deg']['median']} {row['yaw_deg']['max']}",
            *(str(row[key]) for key in ("falls", "safety_stops", "barred")),
        ] for row in rows])
