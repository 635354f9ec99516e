"""A hexapod of servos without sync read walks all the same, judged by what its body really does."""

import math
from functools import partial

import pytest

from robotwalk import assembly
from robotwalk.assembly.session import engine_of, robot_of
from robotwalk.loop import Tick

from . import rig

walk = partial(rig.walk, "hexapod_ax12")


@pytest.mark.parametrize("degrees", [0, 90])
def test_it_walks_at_the_speed_that_it_is_told(degrees: float) -> None:
    report = walk(speed=0.08, direction=math.radians(degrees), duration=8.0)
    rig.assert_sound(report, tilt_deg=3.0)
    assert report["distance_m"] == pytest.approx(0.64, rel=0.12)
    assert abs(report["lateral_drift_m"]) < 0.03


def test_it_turns_on_the_spot() -> None:
    report = walk(turn=rig.TURN, duration=4.5)
    rig.assert_sound(report, tilt_deg=3.0)
    assert report["heading_change_deg"] == pytest.approx(90.0, rel=0.06)


def test_on_an_adapter_that_is_slow_feedback_is_spread_over_ticks_and_goals_go_in_each() -> None:
    """An adapter with a timer of a millisecond takes that for each of eighteen round trips."""
    blueprint = assembly.load("hexapod_ax12")
    world = assembly.simulated_robot(blueprint, 100, seed=0, adapter="ftdi1")
    robot = robot_of(blueprint, engine_of(blueprint, world.clock, world.ports, 100))
    ticks: list[Tick] = []
    before = world.truth().base.x
    with robot:
        robot.stand()
        robot.observers.append(ticks.append)
        robot.walk(vx=0.08, seconds=5.0)
        walked = world.truth().base.x - before
        asked = [sum(age == 0.0 for age in tick.joints.age) for tick in ticks]
    assert walked == pytest.approx(0.4, rel=0.12)
    assert 5 <= max(asked) < 10, "as many as a tick has time for"
    assert max(max(tick.joints.age) for tick in ticks) < 0.05
    assert all(all(tick.joints.valid) for tick in ticks)
    assert robot.bus_statistics()["legs"].lost_replies == 0
