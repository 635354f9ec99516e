"""Legs with a joint to spare, which no closed form solves: they load, check and walk in MuJoCo through their bytes."""

import math
from pathlib import Path

import pytest

from robotwalk import assembly, checks
from robotwalk.ccd import CyclicDescent
from robotwalk.kinematics import solver_for

from . import rig

ROBOT = str(Path(__file__).with_name("four_joints.yaml"))


def test_it_loads_and_its_joints_keep_clear_of_their_limits() -> None:
    blueprint = assembly.load(ROBOT)
    assert all(isinstance(solver_for(leg), CyclicDescent) and len(leg.joints) == 4 for leg in blueprint.model.legs)
    reach = checks.gait_reach(blueprint.model, blueprint.gaits["tripod"])
    assert reach.miss == 0.0
    # Descent alone bends the joint next to the foot up to its limit.
    assert math.degrees(reach.tightest.margin) > 20.0


def test_it_walks() -> None:
    report = rig.walk(ROBOT, speed=0.1, turn=math.radians(5.0), duration=5.0)
    rig.assert_sound(report, tilt_deg=2.0)
    assert report["distance_m"] == pytest.approx(0.5, rel=0.12)
    assert "limits" not in [event["kind"] for event in report["events"]]
