"""How near to tipping over the robot says it is, and how near it is in MuJoCo."""

import math
from itertools import pairwise
from typing import Any

import pytest

from robotwalk import assembly
from robotwalk.loop import Tick
from robotwalk.supervisor import State

from . import rig


def true_margin(simulation: Any, tick: Tick) -> float:
    """The margin by MuJoCo's own centre of mass and feet, of the feet taken to stand, seen from above."""
    data, model = simulation.world.world.data, simulation.world.world.model
    centre = data.subtree_com[model.body("base").id]
    names = [leg.name for leg in simulation.robot.model.legs]
    feet = sorted(
        (tuple(data.geom(f"{name}_foot").xpos[:2]) for name, stands in zip(names, tick.wanted.planted, strict=True)
         if stands), key=lambda foot: math.atan2(foot[1] - centre[1], foot[0] - centre[0]))
    return min(  # of the sides of a polygon around the centre
        ((bx - ax) * (centre[1] - ay) - (by - ay) * (centre[0] - ax)) / math.hypot(bx - ax, by - ay)
        for (ax, ay), (bx, by) in pairwise([*feet, feet[0]]))


def test_a_crawl_keeps_its_margin_and_tells_it_truly() -> None:
    simulation = assembly.simulate("quadruped")
    wanted = simulation.blueprint.gaits["crawl"].balance
    told: list[float] = []
    true: list[float] = []

    def watch(tick: Tick) -> None:
        assert tick.stability is not None
        if tick.state is State.WALK and tick.stability.margin is not None and tick.stability.standing:
            told.append(tick.stability.margin)
            true.append(true_margin(simulation, tick))

    with simulation.robot as robot:
        robot.stand()
        robot.observers.append(watch)
        robot.walk(vx=0.04, seconds=8.0, gait="crawl")
    assert wanted is not None
    assert len(told) > 700
    apart = sorted(abs(a - b) for a, b in zip(told, true, strict=True))
    assert apart[len(apart) // 2] < 0.002
    # Apart for a tick where a foot has just been lifted or set down.
    assert apart[int(0.95 * len(apart))] < 0.006
    # A shift is planned to the set margin; the joints give, and the body rocks.
    assert min(told) > 0.75 * wanted.margin
    assert min(true) > 0.75 * wanted.margin


@pytest.mark.parametrize(("robot", "gait"), [("hexapod", "tripod"), ("quadruped", "trot")])
def test_the_report_has_the_least_margin_of_a_walk_that_always_had_one(robot: str, gait: str) -> None:
    report = rig.walk(robot, speed=0.08, duration=3.0, gait=gait)
    least = report["min_stability_margin_m"]
    if gait == "trot":  # two feet at a time span no polygon
        assert least is None
    else:
        assert 0.03 < least < 0.11
