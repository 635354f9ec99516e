"""Servos that let go: the robot lies down, they are brought back, it gets up and goes on. Or it stays down."""

import math
from dataclasses import replace
from itertools import groupby
from typing import Any

import pytest

from robotwalk import assembly
from robotwalk.config.safety import RecoveryConfig, SafetyConfig
from robotwalk.errors import SafetyStop
from robotwalk.loop import Tick

from .bystander import Bystander

AT = 5.0  # s
BROWN_OUT = {"at": AT, "fault": "brown_out", "for": 0.05}
OVERLOAD = {"at": AT - 2.0, "fault": "overload", "for": 2.2}  # it takes two seconds to trip


@pytest.mark.parametrize(("robot", "fault", "joint", "tilt_deg"), [
    ("hexapod", BROWN_OUT, "lm_femur", 4.0),  # Dynamixel 2.0; it takes its leg out of a tripod
    ("hexapod", OVERLOAD, "lf_tibia", 4.0),  # and is restarted
    ("hexapod_ax12", OVERLOAD, "rr_femur", 14.0),  # Dynamixel 1.0: by its torque limit
    ("quadruped", OVERLOAD, "rr_thigh", 8.0),  # Feetech: torque off and on
    ("quadruped", BROWN_OUT, "lf_calf", 40.0),  # in a trot it goes down on that corner
])
def test_a_servo_that_lets_go_is_brought_back_and_the_walk_goes_on(
    robot: str, fault: dict[str, Any], joint: str, tilt_deg: float
) -> None:
    simulation = assembly.simulate(robot, faults=[{**fault, "joint": joint}])
    bystander = Bystander(simulation)
    ticks: list[Tick] = []
    with simulation.robot as walker:
        walker.stand()
        walker.observers.append(ticks.append)
        before = simulation.world.truth().base.x
        walker.walk(vx=0.10, seconds=11.0)
        gone = simulation.world.truth().base.x - before
        assert simulation.bus.alerts == {}
        servo = simulation.world.servos[simulation.blueprint.model.joint_names.index(joint)]
        assert servo.table["torque_enable"] == 1
        for name, counts in servo.model.arming.set.items():
            assert servo.table[name] == counts, name
    assert [state for state, _ in groupby(tick.state.value for tick in ticks)][:4] == ["walk", "mend", "stand", "walk"]
    down = next(tick.time * 1e-9 for tick in ticks if tick.state.value == "mend")
    assert down - AT < 1.2
    told = [event.text for event in walker.events if event.kind == "mend"]
    assert len(told) == 2
    assert f"the servo of {joint}" in told[0]
    assert told[1] == f"the servo of {joint} holds again"
    assert gone > 0.45
    assert bystander.largest_tilt() < tilt_deg
    assert bystander.fastest_drop() < 0.2
    assert bystander.sees_it_down()
    assert bystander.joints.beyond == bystander.joints.past_stops == {}


def test_a_limp_leg_that_is_shaken_is_taken_over_once_it_is_still() -> None:
    simulation = assembly.simulate("hexapod", faults=[{**BROWN_OUT, "at": 3.5, "joint": "lm_coxa"}])
    world = simulation.world.world
    leg = world.model.body("lm_coxa").id
    slot = simulation.blueprint.model.joint_names.index("lm_coxa")
    shaken: list[float] = []

    def shake() -> None:
        """Turn it to and fro for some seconds, as a person would who looks what is wrong with it."""
        now = simulation.clock.now() * 1e-9
        world.data.xfrc_applied[leg, 5] = math.copysign(0.8, math.sin(12.0 * now)) if 5.0 < now < 7.4 else 0.0
        shaken.append(float(world.data.qvel[6 + slot]))

    simulation.world.observers.append(shake)
    with simulation.robot as walker:
        walker.stand()
        walker.walk(vx=0.05, seconds=7.0)
    assert max(shaken) > 1.0
    assert [event.text for event in walker.events if event.kind in ("mend", "legs")][1:] == [
        "the servo of lm_coxa holds again"]


def test_a_servo_that_stays_overloaded_is_given_up_after_so_many_tries() -> None:
    hexapod = assembly.load("hexapod")
    safety = SafetyConfig(recovery=RecoveryConfig(tries=1, walk_on_with_legs=None))
    stubborn = replace(hexapod, model=replace(hexapod.model, safety=safety))
    simulation = assembly.simulate(stubborn, faults=[{"at": 3.0, "fault": "overload", "joint": "lm_femur"}])
    bystander = Bystander(simulation)
    with simulation.robot as walker:
        walker.stand()
        with pytest.raises(SafetyStop, match="the servo of lm_femur reports overload, after 1 try"):
            walker.walk(vx=0.10, seconds=20.0)
    assert bystander.largest_tilt() < 6.0
    assert bystander.joints.beyond == bystander.joints.past_stops == {}
    assert bystander.sees_it_down()


def test_a_quadruped_goes_down_for_good_when_a_joint_is_stuck_and_tells_the_current_that_takes() -> None:
    simulation = assembly.simulate("quadruped", faults=[{"at": AT, "fault": "stuck_joint", "joint": "lf_calf"}])
    bystander = Bystander(simulation)
    with simulation.robot as walker:
        walker.stand()
        with pytest.raises(SafetyStop, match="joint lf_calf is stuck: it does not move as it is sent; torque is off"):
            walker.walk(vx=0.10, seconds=20.0)
    assert [event.text for event in walker.events if event.kind == "governor"] == [
        "slower and lower, for the servo of lf_calf draws 1.5 A rms, of 3.3 at most"]
    assert walker.torque_doubt is None
    assert bystander.largest_tilt() < 15.0
    assert bystander.fastest_drop() < 0.12
    simulation.clock.wait((), simulation.clock.now() + 2_000_000_000)  # its leg, limp, sinks on round the jammed joint
    assert bystander.sees_it_down()
    assert bystander.joints.beyond == bystander.joints.past_stops == {}
    assert bystander.safe_after(AT) < 8.0


def test_a_quadruped_goes_down_for_good_when_a_servo_is_dead() -> None:
    simulation = assembly.simulate("quadruped", faults=[{"at": AT, "fault": "dead_servo", "joint": "rr_thigh"}])
    bystander = Bystander(simulation)
    with simulation.robot as walker:
        walker.stand()
        with pytest.raises(SafetyStop, match=r"joint rr_thigh has not answered for .* cannot be brought back: it does"):
            walker.walk(vx=0.10, seconds=20.0)
    # Of the one that nobody hears nothing is claimed, and of the others what is so.
    assert walker.torque_doubt == "torque may still be on at rr_thigh: cut the power"
    assert bystander.largest_tilt() < 10.0
    assert bystander.joints.beyond == bystander.joints.past_stops == {}
    assert bystander.sees_it_down()
    assert bystander.safe_after(AT) < 6.0
