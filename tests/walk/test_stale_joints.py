"""Joints that do not answer: coast, hold, sit; and how they go on when they are back."""

import math
from pathlib import Path

import pytest

from robotwalk import assembly
from robotwalk.errors import ConfigError, SafetyStop
from robotwalk.loop import Tick
from robotwalk.supervisor import State
from robotwalk.types import STILL

from .bystander import Bystander

AT = 5.0  # s


def test_a_wire_cut_for_a_moment_holds_the_robot_and_it_goes_on_without_a_jump() -> None:
    """The servos hear nothing either, and stop by their own watchdogs."""
    broken = {"at": AT, "fault": "unplug", "bus": "legs", "for": 0.4}
    simulation = assembly.simulate("hexapod", faults=[broken])
    ticks: list[Tick] = []
    bystander = Bystander(simulation)
    with simulation.robot as robot:
        robot.stand()
        robot.observers.append(ticks.append)
        robot.walk(vx=0.10, seconds=4.0)
        walked = simulation.world.truth().base.x
    cut = [tick for tick in ticks if AT + 0.01 <= tick.time * 1e-9 < AT + 0.4]
    # For some ticks it goes on by its goals: replies may be lost. Then the gait waits, for nobody hears of it.
    speeds = [tick.wanted.twist.vx for tick in cut]
    assert speeds[2] == pytest.approx(0.10)
    waiting = cut[15:]
    assert all(tick.wanted.twist == STILL and tick.wanted.angles == waiting[0].wanted.angles for tick in waiting)
    # Back, every joint is slower than in the walk: none leaps to where the gait is by now.
    usual = max(look.speed for look in bystander.seen if 4.0 < look.t < AT)
    assert max(look.speed for look in bystander.after(AT + 0.4) if look.t < AT + 0.5) < 0.7 * usual
    assert bystander.largest_tilt() < 6.0
    assert bystander.joints.beyond == bystander.joints.past_stops == {}
    assert walked > 0.25
    assert bystander.sees_it_down()


@pytest.mark.parametrize(("robot", "gait", "ahead", "aside", "every"), [
    ("hexapod", "stroll", 0.11, -0.19, 1.13),
    ("hexapod", "tripod", 0.20, 0.0, 0.97),
    ("quadruped", "amble", 0.15, 0.0, 1.07),
    ("quadruped", "trot", 0.25, 0.0, 1.07),
])
def test_wherever_in_its_stride_a_wire_is_cut_the_robot_keeps_its_feet(
    robot: str, gait: str, ahead: float, aside: float, every: float
) -> None:
    """A gait that went on meanwhile would take feet for standing that are still in the air, and lift the others."""
    moments = [4.0 + every * number for number in range(6)]
    simulation = assembly.simulate(robot, faults=[
        {"at": at, "fault": "unplug", "bus": "legs", "for": 0.2} for at in moments])
    bystander = Bystander(simulation)
    with simulation.robot as walker:
        walker.stand()
        stands = bystander.seen[-1].height
        walker.walk(vx=ahead, vy=aside, gait=gait, seconds=moments[-1] + 1.0 - bystander.seen[-1].t)
        walking = bystander.after(moments[0])
    assert bystander.joints.beyond == bystander.joints.past_stops == {}
    assert min(look.height for look in walking) > stands - 0.01
    assert math.degrees(max(look.tilt for look in walking)) < 9.0
    assert math.hypot(*simulation.world.truth().base[:2]) > 0.4  # m: it goes on each time


def test_joints_that_stay_silent_make_the_robot_sit_at_the_times_of_its_file(tmp_path: Path) -> None:
    own = tmp_path / "own.yaml"
    text = assembly.load("quadruped").document.text
    own.write_text(text + "\nsafety: {stale: {hold_after_s: 0.1, sit_after_s: 0.3}, recovery: {tries: 0}}\n")
    # It hears and does not answer: it follows to the end.
    silent = {"at": AT, "fault": "drop_reply", "joint": "lf_calf"}
    simulation = assembly.simulate(str(own), faults=[silent])
    ticks: list[Tick] = []
    bystander = Bystander(simulation)
    with simulation.robot as robot:
        robot.stand()
        robot.observers.append(ticks.append)
        with pytest.raises(SafetyStop, match=r"joint lf_calf has not answered for 0\.3\d s"):
            robot.walk(vx=0.10, seconds=9.0)
    first = next(tick for tick in ticks if tick.state is State.FAULT)
    assert first.time * 1e-9 - AT < 0.4
    slot = simulation.blueprint.model.joint_names.index("lf_calf")
    held = [tick.goals[slot] for tick in ticks if AT + 0.25 < tick.time * 1e-9 < AT + 0.3]
    assert max(held) - min(held) < 1e-3
    assert bystander.sees_it_down()
    assert bystander.joints.beyond == bystander.joints.past_stops == {}
    assert bystander.safe_after(AT) < 6.0


def test_times_that_make_no_sense_are_refused(tmp_path: Path) -> None:
    own = tmp_path / "own.yaml"
    text = assembly.load("hexapod").document.text
    own.write_text(text + "\nsafety: {stale: {hold_after_s: 0.6}}\n")
    with pytest.raises(ConfigError, match=r"own\.yaml:\d+:\d+: safety\.stale: hold_after_s should be below sit"):
        assembly.load(str(own))
