"""What play between the teeth, and friction that grows with the load, do to a shaft."""

import math

import pytest

from hal.register_map import ServoModel
from robotwalk.assembly import load_servo

from .rig import Rig

XL330, XL430, XM430, MX28 = (load_servo(name) for name in ("xl330-m288", "xl430-w250", "xm430-w350", "mx-28"))

BALL = 0.6  # kg on the lever: 2.6e-4 kg m^2, a small limb


def with_backlash(model: ServoModel, degrees: float) -> ServoModel:
    return model.model_copy(update={"motor": model.motor.model_copy(update={"backlash_deg": degrees})})


def free_play(rig: Rig, torque: float) -> float:
    """Push a shaft to and fro, gently; return how far it goes, degrees."""
    ends = []
    for sign in (1, -1, 1):
        rig.hinge.load(sign * torque)
        rig.run(0.5)
        ends.append(math.degrees(rig.angle))
    assert ends[0] == pytest.approx(ends[2], abs=0.002)
    return ends[0] - ends[1]


@pytest.mark.parametrize(("model", "play"), [(XM430, 0.25), (MX28, 20 / 60), (with_backlash(XM430, 0.0), 0.0)])
@pytest.mark.parametrize("torque_enable", [0, 1])
def test_a_shaft_turns_freely_within_the_data_sheets_play_and_no_further(
    model: ServoModel, play: float, torque_enable: int,
) -> None:
    rig = Rig(model, ball=BALL)
    rig.write(torque_enable=torque_enable)
    assert free_play(rig, 0.01) == pytest.approx(play, abs=0.02)  # half a step of 1 ms at 0.6 rad/s


def test_the_encoder_sits_on_the_shaft_and_sees_the_play() -> None:
    rig = Rig(XM430, ball=BALL)
    counts = []
    for torque in (0.01, -0.01):
        rig.hinge.load(torque)
        rig.run(0.5)
        counts.append(rig.read("present_position"))
    assert counts[0] - counts[1] == pytest.approx(0.25 / 360 * 4096, abs=1)


@pytest.mark.parametrize(("degrees", "ms"), [(0.0, 1), (0.33, 9)])
def test_a_motor_that_turns_back_crosses_the_play_before_its_shaft_follows(degrees: float, ms: int) -> None:
    """At 1.4 N m on 0.010 kg m^2 the play takes sqrt(2 x 0.00576 / 140) s."""
    rig = Rig(with_backlash(XL430, degrees), ball=BALL, operating_mode=16)
    rig.hinge.load(0.01)  # against the far side of the teeth
    rig.run(0.5)
    rig.hinge.load(0.0)
    rig.run(0.01)
    before = rig.angle
    rig.write(torque_enable=1, goal_pwm=885)
    waited = 0
    while rig.angle - before < 1e-4:
        rig.run(0.001)
        waited += 1
    assert waited == pytest.approx(ms, abs=2)


def test_a_load_that_changes_sides_moves_the_held_joint_by_the_play_and_by_what_the_loop_gives_way() -> None:
    def moved(degrees: float) -> float:
        rig = Rig(with_backlash(XL430, degrees), ball=BALL)
        rig.write(torque_enable=1)
        ends = []
        for torque in (0.03, -0.03):  # less than friction holds
            rig.hinge.load(torque)
            rig.run(1.0)
            ends.append(math.degrees(rig.angle))
        return ends[0] - ends[1]

    assert moved(0.0) < 0.01
    assert moved(0.33) == pytest.approx(0.33, abs=0.03)


@pytest.mark.parametrize(("load", "direction"), [(0.125, 1), (0.150, 0), (0.250, 0), (0.285, -1)])
def test_m4_holds_a_load_by_friction_that_the_load_itself_makes(load: float, direction: int) -> None:
    """0.5 A is 0.193 N m: it lifts (0.193 (1 - c) - Kc) / (1 + c) = 0.138 N m, and gives way to 0.267; c = Kl + Kls.

    M1 would lift 0.18 and give way to 0.21.
    """
    rig = Rig(with_backlash(XL330, 0.0), operating_mode=0)
    for percent in range(1, 101):  # both at once, so that the shaft does not gather speed
        rig.hinge.load(-load * percent / 100)
        rig.write(goal_current=5 * percent, torque_enable=1)
        rig.run(0.005)
    rig.run(0.3)
    assert (abs(rig.angle) > 0.02) * math.copysign(1, rig.angle) == direction
