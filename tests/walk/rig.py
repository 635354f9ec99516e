"""A walk in MuJoCo through real servo bytes, judged by what the body really does."""

import math
from typing import Any

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


def assert_sound(report: dict[str, Any], tilt_deg: float) -> None:
    """Nothing may go wrong on flat ground."""
    assert not report["fell"]
    assert report["max_tilt_deg"] < tilt_deg
    for bus in report["bus"].values():
        assert bus["lost_replies"] == 0
        assert bus["bad_frames"] == 0
    assert report["timing"]["missed_deadlines"] == 0
