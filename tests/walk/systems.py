"""What each system buys: the same walk with and without it.

`python -m tests.walk.systems [SYSTEM ...]` prints the figures of docs/systems.md.
"""

import math
import sys
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from robotwalk import assembly
from robotwalk.cli.outing import Outing, Plan
from robotwalk.config import library
from robotwalk.errors import RobotwalkError
from robotwalk.supervisor import State

from . import rig

Keys = Mapping[str, Any]  # by their paths in the file


class Trial(NamedTuple):
    """One walk, with a system and without it."""

    system: str
    robot: str
    off: Keys
    on: Keys | None = None
    gait: str | None = None
    terrain: str = "flat"
    speed: float = 0.06
    seconds: float = 20.0
    seed: int = 0
    servos_off_by: float = 0.0  # share
    shove: float = 0.0  # N to the left, for half a second while it stands


TRIALS = (
    Trial("feed_forward.lag", "quadruped", {"locomotion.feed_forward.lag": False}, speed=0.15, seconds=8.0),
    Trial("feed_forward.lag", "hexapod", {"locomotion.feed_forward.lag": False}, speed=0.1, seconds=8.0),
    Trial("feed_forward.load", "quadruped", {"locomotion.feed_forward.load": False}, speed=0.15, seconds=8.0),
    Trial("feed_forward.load", "hexapod", {"locomotion.feed_forward.load": False}, speed=0.1, seconds=8.0),
    Trial("hold_course", "quadruped", {"locomotion.hold_course": False}, speed=0.15, seconds=15.0, servos_off_by=0.15),
    Trial("hold_course", "hexapod", {"locomotion.hold_course": False}, terrain="rough_30"),
    Trial("contact.caution_mm", "hexapod", {"locomotion.contact.caution_mm": 0}, terrain="stairs_40"),
    Trial("contact.early_touchdown", "hexapod", {"locomotion.contact.early_touchdown": False}, terrain="rough_30"),
    Trial("contact.step_over", "hexapod", {"locomotion.contact.step_over": False}, terrain="stairs_40"),
    Trial("contact.reach_down_mm", "hexapod", {"locomotion.contact.reach_down_mm": 0}, terrain="drop_50"),
    Trial("contact.search", "hexapod", {"locomotion.contact.search": False}, terrain="gap_60"),
    Trial("contact.slip", "hexapod", {"locomotion.contact.slip": False}, terrain="loose"),
    Trial("contact", "hexapod", {"locomotion.contact": None, "locomotion.orientation": None}, terrain="stairs_40"),
    Trial("contact.share_load", "quadruped", {"locomotion.contact.share_load": False}, gait="crawl",
          terrain="rough_15", speed=0.04),
    Trial("orientation.plumb", "quadruped", {"locomotion.orientation.plumb": False}, gait="crawl",
          terrain="ramp_8", speed=0.04),
    Trial("contact.wait_for_footing", "hexapod", {"locomotion.contact.wait_for_footing": False}, terrain="blocks_60"),
    Trial("contact.out_of_turn", "hexapod", {"locomotion.contact.out_of_turn": False}, terrain="stairs_40"),
    Trial("stance_reflex", "hexapod", {"locomotion.stance_reflex": False}, speed=0.0, seconds=8.0, shove=20.0),
    Trial("orientation", "hexapod", {"locomotion.orientation": None}, terrain="ramp_15"),
    Trial("reaction", "hexapod", {}, {"locomotion.reaction": {"bob": 0.3, "turn": 0.5}}, speed=0.1, seconds=6.0),
    Trial(
        "reaction.height", "quadruped", {}, {"locomotion.reaction": {"height": 0.05, "weights": {"lf": 2, "rr": 2}}},
        gait="trot", speed=0.1, seconds=6.0),
    Trial("balance", "quadruped", {"gait.balance": None}, gait="crawl", speed=0.04, seconds=10.0),
    Trial("rocking", "quadruped", {"gait.rocking": 0.0}, gait="amble", speed=0.1, seconds=8.0),
)


def _set(document: dict[str, Any], keys: Keys) -> None:
    for path, value in keys.items():
        *sections, last = path.split(".")
        section = document
        for name in sections:
            section = section.setdefault(name, {})
        if value is None:
            section.pop(last, None)
        else:
            section[last] = value


def _files(trial: Trial, keys: Keys, folder: Path) -> str:
    """Write the robot's file, and its gait's beside it, with these keys set."""
    robot = yaml.safe_load(library.open_document("robots", trial.robot).text)
    _set(robot, {path: value for path, value in keys.items() if not path.startswith("gait.")})
    path = folder / f"{trial.robot}.yaml"
    path.write_text(yaml.safe_dump(robot, sort_keys=False))
    if trial.gait is not None:
        gait = yaml.safe_load(library.open_document("gaits", trial.gait).text)
        _set(gait, {path.removeprefix("gait."): value for path, value in keys.items() if path.startswith("gait.")})
        (folder / "gaits").mkdir()
        (folder / "gaits" / f"{trial.gait}.yaml").write_text(yaml.safe_dump(gait, sort_keys=False))
    return str(path)


def _walk(trial: Trial, keys: Keys) -> str:
    with tempfile.TemporaryDirectory() as folder:
        robot: str | assembly.Blueprint = _files(trial, keys, Path(folder))
        if trial.servos_off_by:
            robot = rig.varied(str(robot), trial.seed, trial.servos_off_by)
        shove = {"at": 5.0, "for": 0.5, "fault": "push", "force_n": trial.shove, "direction_deg": 90}
        simulation = assembly.simulate(
            robot, terrain=trial.terrain, seed=trial.seed, faults=[shove] if trial.shove else [])
    heights: list[float] = []
    yaws: list[float] = []
    off: list[float] = []  # mm that the farthest foot is from rest, by its joints

    def watch(tick: Any) -> None:
        if tick.state is State.WALK:
            base = simulation.world.truth().base
            heights.append(base.z)
            yaws.append(math.degrees(base.yaw))
            off.append(1e3 * max(
                math.dist(foot[:2], leg.rest_foot[:2]) if foot is not None else 0.0
                for leg, foot in zip(simulation.blueprint.model.legs, tick.estimate.feet, strict=True)))

    simulation.robot.observers.append(watch)
    outing = Outing(simulation, Plan(trial.speed, 0.0, None, 0.0, None, trial.seconds, trial.gait))
    ended = ""
    try:
        outing.run(lambda text, share: None)
    except RobotwalkError as error:
        ended = f"; {error}"
    report = outing.report()
    later = slice(len(heights) // 3, 2 * len(heights) // 3)
    share = report["distance_m"] / (trial.speed * trial.seconds) if trial.speed else math.nan
    if trial.shove:
        mended = any(event["kind"] == "mend" for event in report["events"])
        ended += f"; a foot {max(off):.0f} mm off rest, at last {off[-1]:.0f}{'; a servo let go' if mended else ''}"
    return (
        f"share {share:.2f}, tilt {report['max_tilt_deg']:.1f}, "
        f"yaw {report['heading_change_deg']:+.1f} deg, lowest {1e3 * report['min_height_m']:.0f} mm, "
        f"height +-{500 * (max(heights[later]) - min(heights[later])):.1f} mm, "
        f"yaw +-{0.5 * (max(yaws[later]) - min(yaws[later])):.1f} deg"
        f"{', fell' if report['fell'] else ''}{ended}")


def measure(trial: Trial) -> tuple[str, str]:
    """Walk with the system and without."""
    return _walk(trial, trial.on or {}), _walk(trial, trial.off)


def main(wanted: Sequence[str]) -> None:
    """Print all figures, or those of some systems."""
    trials = [trial for trial in TRIALS if not wanted or trial.system in wanted]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        for trial, (on, off) in zip(trials, pool.map(measure, trials), strict=True):
            where = f"{trial.robot} {trial.terrain} {trial.speed} m/s, {trial.seconds:g} s"
            sys.stdout.write(f"{trial.system} ({where})\n  on:  {on}\n  off: {off}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
