"""Every servo model on the bench: full duty by its registers, and what its registers then tell."""

import pytest

from robotwalk.assembly import load_servo
from robotwalk.config import library

from .rig import Rig

MODELS = {name: load_servo(name) for name in library.names("servos")}
# What makes each brand turn without end, and never let go; the register that drives it, and all it can take.
FREE = {
    "dynamixel-x": ({"operating_mode": 16, "shutdown": 0}, "goal_pwm", 885),
    "dynamixel-ax": ({"cw_angle_limit": 0, "ccw_angle_limit": 0, "shutdown": 0}, "moving_speed", 1023),
    "feetech-sts": ({"operating_mode": 2, "unloading_condition": 0}, "goal_pwm", 1000),
    "feetech-scs": ({"min_position_limit": 0, "max_position_limit": 0, "unloading_condition": 0}, "goal_time", 1000),
}
# Fits, which we keep where they and the data sheet disagree: their files say so. kt V / R less friction, by hand:
# XL330-M288: (0.5675 x (1 - 0.1418) - 0.0088) / (1 + 0.1418); STS3215: 1.2116 x 7.4 x 0.97 / 2.676 - 0.0524.
FITTED_STALL_NM = {"xl330-m288": 0.4189, "sts3215": 3.197}

every_model = pytest.mark.parametrize("name", MODELS)


@every_model
def test_no_load_speed_is_the_data_sheets(name: str) -> None:
    model = MODELS[name]
    velocity = model.cyclic.velocity
    factory, goal, full = FREE[model.firmware.kind]
    rig = Rig(model, **factory)
    rig.write(torque_enable=1, **{goal: full})
    rig.run(1.2)
    shown = rig.read(velocity) * model[velocity].si_scale
    assert shown == pytest.approx(model.specification.rated.no_load_speed, rel=0.1)
    if name not in FITTED_STALL_NM:
        assert shown == pytest.approx(model.specification.rated.no_load_speed, rel=0.01)  # it derives from it


@every_model
def test_stall_torque_is_the_data_sheets_or_the_fits(name: str) -> None:
    """Its duty grows step by step, so that the shaft creeps up a spring, and friction opposes it to the end."""
    model = MODELS[name]
    factory, goal, full = FREE[model.firmware.kind]
    torque = FITTED_STALL_NM.get(name, model.specification.rated.stall_torque_nm)
    spring, position = torque / 0.35, model.cyclic.position
    rig = Rig(model, spring=spring, **factory)
    rig.write(torque_enable=1)
    centre = rig.read(position)
    for step in range(1, 41):
        rig.write(**{goal: step * full // 40})
        rig.run(0.04)
    before = centre
    while (now := rig.read(position)) != before:
        before = now
        rig.run(0.2)
    turned = (now - centre) * model.encoder.radians_per_tick
    assert spring * turned == pytest.approx(torque, rel=0.03)


def test_there_is_a_figure_for_every_fit() -> None:
    assert {name for name, model in MODELS.items() if model.motor.source.startswith("BAM")} == set(FITTED_STALL_NM)
