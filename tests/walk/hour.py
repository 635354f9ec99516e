"""An hour of walking in lock-step, faults coming and going: `python -m tests.walk.hour [--seconds S] [--seed N]`.

Each minute the robot does two of the soak's random command sequences and a straight way, while something goes wrong
every seven seconds; then it stands, nothing ails it, and is measured. The black box runs, as it does on a real robot.
The exit code is 1 if memory grew by more than 1 MB after the first five minutes, if the height of the standing body
drifted, if a joint was beyond its limits, or one, limp even, deep in its stop, or if the robot fell or stopped for its
safety.
"""

import argparse
import gc
import itertools
import math
import resource
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

from robotwalk import assembly
from robotwalk.errors import SafetyStop

from .joint_watch import JointWatch, Worst
from .soak.sequences import SECONDS, Driver, sequence

WARM = 300.0  # s until whatever fills, such as the black box, is full
MOST_GROWTH = 1e6  # bytes
MOST_DRIFT = 2e-3  # m
_EVERY = 7.0  # s from one fault to the next
_FIRST = 3.0  # s into the minute
_FAULTS = 6  # a minute; the rest of it is quiet
_STRAIGHT, _STAND = 9.0, 3.0  # s
_FALLEN = 0.7  # rad


class Minute(NamedTuple):
    """How it stood after one."""

    t: float  # s
    height: float  # m, of the body
    resident: int  # bytes
    objects: int  # of Python


class Ended(NamedTuple):
    """What came of all of it."""

    minutes: list[Minute]
    faults: Counter[str]
    events: Counter[str]
    fell: int
    stopped: str | None
    joint: Worst  # rad beyond its limits, the farthest; below 0 within
    beyond: dict[str, tuple[float, float]]  # deg and s, by joints whose servos held or moved them
    past_stops: dict[str, tuple[float, float]]  # the same, by limp joints too
    distance: float  # m, the body's way over the ground
    wall: float  # s


def one_of(kind: str, at: float, chance: Random, joint: str) -> dict[str, Any]:
    """Return a fault of that kind; `joint` is whose turn it is where a servo may be brought back only so often."""
    keys: dict[str, dict[str, Any]] = {
        "drop_reply": {"rate": 0.05, "for": 5.0},  # of each; those behind it on the bus are lost with it
        "corrupt_frame": {"rate": 0.02, "for": 5.0},
        "delay_reply": {"rate": 0.05, "delay_ms": 3.0, "for": 5.0},
        "noise": {"for": 3.0},
        "unplug": {"bus": "legs", "for": 0.2},
        "brown_out": {"joint": joint},
        "overload": {"joint": joint, "for": 2.2},  # it takes two seconds to trip
        "overheat": {"joint": joint, "temperature_c": 63.0, "for": 4.0},
        "voltage_drop": {"supply_v": 6.5, "for": 3.0},
        "stuck_joint": {"joint": joint, "for": 0.3},
        "push": {"force_n": chance.uniform(4.0, 10.0), "direction_deg": chance.uniform(0.0, 360.0), "for": 0.2},
    }
    return {"at": at, "fault": kind, **keys[kind]}


# Those that lay the robot down come once in three minutes each: every servo may be brought back three times.
_ROUND = (
    "drop_reply", "unplug", "brown_out", "corrupt_frame", "push", "noise",
    "delay_reply", "overheat", "stuck_joint", "unplug", "overload", "drop_reply",
    "push", "voltage_drop", "corrupt_frame", "stuck_joint", "delay_reply", "noise",
)


class Hour:
    """One run."""

    def __init__(self, robot: str, seed: int, folder: Path) -> None:
        """Simulate a robot, its black box in a folder."""
        self._simulation = assembly.simulate(robot, seed=seed)
        assembly.add_black_box(self._simulation, folder)
        self._chance, self._seed = Random(f"{robot} {seed}"), seed
        self._kinds = itertools.cycle(_ROUND)
        joints = list(self._simulation.blueprint.model.joint_names)
        self._chance.shuffle(joints)
        self._joints = itertools.cycle(joints)
        self._watch = JointWatch(self._simulation)
        self._minutes: list[Minute] = []
        self._faults: Counter[str] = Counter()
        self._falls, self._down, self._told = 0, False, 0
        self._way, self._at = 0.0, (0.0, 0.0)
        self._simulation.robot.observers.append(lambda tick: self._look())

    @property
    def now(self) -> float:
        """The simulated time, s."""
        return self._simulation.clock.now() * 1e-9

    def run(self, seconds: float) -> Ended:
        """Walk for at least so long."""
        began, stopped = time.perf_counter(), None
        robot = self._simulation.robot
        try:
            with robot:
                robot.stand()
                for number in itertools.count():
                    if self.now >= seconds:
                        break
                    self._minute(number)
        except SafetyStop as error:
            stopped = f"{error}, at {self.now:.1f} s"
        joints = self._watch
        return Ended(
            self._minutes, self._faults, Counter(event.kind for event in robot.events), self._falls, stopped,
            joints.worst, joints.beyond, joints.past_stops, self._way, time.perf_counter() - began)

    def _minute(self, number: int) -> None:
        robot, blueprint = self._simulation.robot, self._simulation.blueprint
        script = []
        for index in range(_FAULTS):
            kind = next(self._kinds)
            self._faults[kind] += 1
            lays_down = kind in ("brown_out", "overload")
            joint = next(self._joints) if lays_down else self._chance.choice(robot.model.joint_names)
            script.append(one_of(kind, self.now + _FIRST + _EVERY * index, self._chance, joint))
        assembly.befall(self._simulation, script, f"{self._seed} {number}")
        for part in range(2):
            seed = self._seed * 100_000 + 2 * number + part
            robot.follow(Driver(sequence(blueprint, seed)), seconds=SECONDS)
        robot.walk(vx=0.1, seconds=_STRAIGHT)
        robot.walk(seconds=_STAND)
        self._measure()

    def _measure(self) -> None:
        gc.collect()
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        truth = self._simulation.world.truth()
        self._minutes.append(Minute(
            self.now, truth.base.z - truth.ground, pages * resource.getpagesize(), len(gc.get_objects())))
        last = self._minutes[-1]
        for event in self._simulation.robot.events[self._told:]:
            if event.kind not in ("state", "governor"):
                sys.stderr.write(f"  {event.t:7.1f} s: {event.kind}: {event.text}\n")
        self._told = len(self._simulation.robot.events)
        sys.stderr.write(
            f"{last.t:7.1f} s: {1e3 * last.height:.2f} mm, {last.resident / 1e6:.2f} MB, {last.objects} objects, "
            f"{self._falls} falls, {self._way:.1f} m; {self._watch.beyond}\n")

    def _look(self) -> None:
        base = self._simulation.world.truth().base
        self._way += ((base.x - self._at[0]) ** 2 + (base.y - self._at[1]) ** 2) ** 0.5
        self._at = base.x, base.y
        tilt = max(abs(base.roll), abs(base.pitch))
        if tilt > _FALLEN and not self._down:
            self._falls += 1
        self._down = tilt > _FALLEN


def complaints(ended: Ended) -> list[str]:
    """Return what should not have been, in words."""
    found = []
    if ended.stopped is not None:
        found.append(f"stopped: {ended.stopped}")
    if ended.fell:
        found.append(f"fell {ended.fell} times")
    if ended.beyond:
        found.append(f"joints beyond their limits, deg and s: {ended.beyond}")
    if ended.past_stops:
        found.append(f"joints pressed into their stops, deg beyond their limits and s: {ended.past_stops}")
    warm = [minute for minute in ended.minutes if minute.t >= WARM]
    if warm and max(minute.resident for minute in warm) - warm[0].resident > MOST_GROWTH:
        found.append(f"memory grew by more than {MOST_GROWTH / 1e6:.0f} MB")
    heights = [minute.height for minute in ended.minutes]
    if heights and max(heights) - min(heights) > MOST_DRIFT:
        found.append(f"the height while standing varies by more than {1e3 * MOST_DRIFT:.0f} mm")
    return found


def summary(ended: Ended) -> str:
    """Return the figures, in words."""
    minutes = ended.minutes
    warm = [minute for minute in minutes if minute.t >= WARM] or minutes
    heights = [1e3 * minute.height for minute in minutes]
    first, last = warm[0], warm[-1]
    return (
        f"{minutes[-1].t:.0f} s simulated in {ended.wall:.0f} s, {ended.distance:.0f} m; "
        f"{ended.faults.total()} faults ({', '.join(f'{kind} {n}' for kind, n in sorted(ended.faults.items()))})\n"
        f"  events: {', '.join(f'{kind} {n}' for kind, n in sorted(ended.events.items()))}; {ended.fell} falls\n"
        f"  resident memory: {first.resident / 1e6:.2f} MB at {first.t:.0f} s, {last.resident / 1e6:.2f} at the end, "
        f"largest {max(minute.resident for minute in warm) / 1e6:.2f}; objects {first.objects} and {last.objects}\n"
        f"  height standing, once a minute: {min(heights):.2f} to {max(heights):.2f} mm, first {heights[0]:.2f}, "
        f"last {heights[-1]:.2f}\n"
        f"  farthest beyond a joint's limit: {math.degrees(ended.joint.value):.2f} deg ({ended.joint.where})")


def main() -> int:
    """Run, report, and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.walk.hour", description=__doc__)
    parser.add_argument("--robot", default="hexapod")
    parser.add_argument("--seconds", type=float, default=3600.0, metavar="S", help="simulated (3600)")
    parser.add_argument("--seed", type=int, default=0, metavar="N")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        ended = Hour(arguments.robot, arguments.seed, Path(folder)).run(arguments.seconds)
    found = complaints(ended)
    for text in (summary(ended), *found):
        sys.stdout.write(f"{text}\n")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
