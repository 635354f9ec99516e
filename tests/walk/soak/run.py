"""One sequence on one simulated robot, on flat ground of friction 1."""

from functools import cache
from typing import NamedTuple

from robotwalk import assembly
from robotwalk.errors import SafetyStop

from ..joint_watch import Worst
from .bounds import fastest_target
from .judge import Judge, Slip
from .sequences import SECONDS, Driver, Episode, sequence


class Outcome(NamedTuple):
    """What came of it; times in s since it began."""

    robot: str
    seed: int
    episodes: list[Episode]
    fell: Worst | None
    stopped: str | None  # by itself, and why
    joint: Worst  # rad beyond a joint's limits, the farthest
    speed: Worst  # m/s of a foot's target, the largest
    speed_bound: float  # m/s
    tilt: Worst  # rad
    slips: list[Slip]


@cache
def _blueprint(robot: str) -> assembly.Blueprint:
    return assembly.load(robot)


def run(robot: str, seed: int) -> Outcome:
    """Stand up, do all of it, stop, sit down."""
    blueprint = _blueprint(robot)
    simulation = assembly.simulate(blueprint, seed=seed)
    judge, episodes = Judge(simulation), sequence(blueprint, seed)
    stopped = None
    try:
        with simulation.robot as walker:
            walker.stand()
            judge.begin()
            try:
                walker.follow(Driver(episodes), seconds=SECONDS)
            finally:
                judge.end()
    except SafetyStop as stop:
        stopped = str(stop)
    # Nothing ails it.
    stopped = stopped or next((f"{event.text}, at {event.t:.2f} s of the session" for event in simulation.robot.events
                               if event.kind in ("mend", "legs")), None)
    return Outcome(
        robot, seed, episodes, judge.fell, stopped, judge.joint, judge.speed, fastest_target(blueprint), judge.tilt,
        judge.slips)
