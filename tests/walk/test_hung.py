"""On a stand, feet in the air: the first motion of every robot."""

import math

from robotwalk import assembly
from robotwalk.loop import Tick
from robotwalk.supervisor import State


def test_on_a_stand_the_legs_step_as_on_the_ground_gently_and_feel_for_none() -> None:
    simulation = assembly.simulate(assembly.load("hexapod").hang())
    joints = simulation.blueprint.model.joint_names
    coxae = [index for index, name in enumerate(joints) if name.endswith("coxa")]
    angles: list[list[float]] = [[] for _ in coxae]
    touched, walking = False, False

    def look() -> None:
        nonlocal touched
        truth = simulation.world.truth()
        touched = touched or any(truth.contacts)
        if walking:
            for series, coxa in zip(angles, coxae, strict=True):
                series.append(truth.joints[coxa])

    def follow(tick: Tick) -> None:
        nonlocal walking
        walking = tick.state is State.WALK

    simulation.world.observers.append(look)
    simulation.robot.observers.append(follow)
    with simulation.robot as robot:
        robot.stand()
        robot.walk(vx=0.06, seconds=3.0)
        shares = [servo.table["goal_pwm"] / servo.table["pwm_limit"] for servo in simulation.world.servos]
    assert not touched
    assert [event.text for event in robot.events if event.kind != "state"] == []
    assert all(math.degrees(max(series) - min(series)) > 10.0 for series in angles)
    assert all(0.3 < share < 0.4 for share in shares), shares
