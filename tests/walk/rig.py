"""A walk in MuJoCo through real servo bytes, judged by what the body really does."""

import math
import random
from dataclasses import replace
from typing import Any

from hal.register_map import PositionLoop, ServoModel
from robotwalk import assembly
from robotwalk.cli.outing import Outing, Plan

TURN = math.radians(20)
_STILL = Plan(speed=0.0, direction=0.0, heading=None, turn=0.0, height=None, duration=10.0, gait=None)


def walk(
    robot: str | assembly.Blueprint, *, rate_hz: int = 100, seed: int = 0, faults: assembly.Script = (),
    terrain: str = "flat", **plan: Any,
) -> dict[str, Any]:
    """Walk by a plan (SI, radians) and return the report."""
    simulation = assembly.simulate(robot, rate_hz=rate_hz, seed=seed, faults=faults, terrain=terrain)
    outing = Outing(simulation, _STILL._replace(**plan))
    outing.run(lambda text, share: None)
    return outing.report()


def varied(robot: str, seed: int, by: float) -> assembly.Blueprint:
    """Return the robot with other servos than its files say, and than its controller goes by.

    Friction, armature and gain are off by up to the share `by`: all servos alike for odd seeds, each for itself for
    even ones.
    """
    nominal = assembly.load(robot)
    rng = random.Random(seed)
    common = [rng.uniform(1.0 - by, 1.0 + by) for _ in range(3)]
    servos, rows = {}, {}
    for joint, row in nominal.hardware.joints.items():
        factors = common if seed % 2 else [rng.uniform(1.0 - by, 1.0 + by) for _ in range(3)]
        servos[joint] = changed(nominal.servos[row.servo], *factors)
        rows[joint] = row.model_copy(update={"servo": joint})
    hardware = nominal.hardware.model_copy(update={"joints": rows})
    real = replace(nominal, hardware=hardware, servos=servos)
    vars(real)["drives"] = nominal.drives
    return real


def changed(servo: ServoModel, friction: float, armature: float, gain: float) -> ServoModel:
    motor, loop = servo.motor, servo.position_loop
    assert isinstance(loop, PositionLoop)
    return servo.model_copy(update={
        "motor": motor.model_copy(update={
            "friction": motor.friction.model_copy(update={
                "coulomb_nm": friction * motor.friction.coulomb_nm,
                "viscous_nms": friction * motor.friction.viscous_nms}),
            "armature_kgm2": armature * motor.armature_kgm2}),
        "position_loop": loop.model_copy(update={"divisor": loop.divisor / gain})})


def assert_sound(report: dict[str, Any], tilt_deg: float) -> None:
    """Nothing may go wrong on flat ground."""
    assert not report["fell"]
    assert report["max_tilt_deg"] < tilt_deg
    for bus in report["bus"].values():
        assert bus["lost_replies"] == 0
        assert bus["bad_frames"] == 0
    assert report["timing"]["missed_deadlines"] == 0
