"""Robots step without a clock in MuJoCo, through real servo bytes, judged by what their bodies really do."""

import itertools
import math
from typing import Any

import pytest

from robotwalk.chain import foot_position
from robotwalk.estimator import Estimate
from robotwalk.loop import Tick
from robotwalk.supervisor import State
from robotwalk.testing import FakeRobot
from robotwalk.types import Command, Twist

from . import rig

TILT = {"hexapod": 4.0, "quadruped": 8.0}


@pytest.mark.parametrize(("robot", "speed", "degrees", "tolerance"), [
    ("hexapod", 0.10, 0, 0.12), ("hexapod", 0.10, 90, 0.12),
    ("quadruped", 0.10, 0, 0.18), ("quadruped", 0.05, 90, 0.18)])
def test_the_speed_is_held_ahead_and_sideways(robot: str, speed: float, degrees: int, tolerance: float) -> None:
    report = rig.walk(robot, gait="free", speed=speed, direction=math.radians(degrees), duration=5.0)
    rig.assert_sound(report, tilt_deg=TILT[robot])
    assert report["gait"] == "free"
    assert report["distance_m"] == pytest.approx(5.0 * speed, rel=tolerance)
    assert abs(report["lateral_drift_m"]) < 0.06
    assert abs(report["heading_change_deg"]) < 6.0


class Dance:
    """Turns on the spot, and back at once; goes ahead, back, to the left and to the right, all in mid-step."""

    done = False
    moves = (
        Twist(0.0, 0.0, 0.6), Twist(0.0, 0.0, -0.6), Twist(0.12, 0.0, 0.0), Twist(-0.12, 0.0, 0.0),
        Twist(0.0, 0.08, 0.4), Twist(0.0, -0.08, -0.4))

    def __init__(self) -> None:
        self.seconds = 0.0

    def step(self, estimate: Estimate, dt: float) -> Command:
        self.seconds += dt
        return Command(self.moves[int(self.seconds / 0.7) % len(self.moves)])


@pytest.mark.parametrize("name", TILT)
def test_fast_reversals_tangle_no_legs(name: str) -> None:
    with FakeRobot(name) as fake:
        model = fake.robot.model
        feet: list[Any] = []

        def watch(tick: Tick) -> None:
            joints = zip(model.joints, fake.joints.values(), strict=True)
            assert all(joint.lower < angle < joint.upper for joint, angle in joints)
            if tick.state is State.WALK:
                feet.append(tick.estimate.feet)

        fake.robot.observers.append(watch)
        fake.robot.stand()
        fake.robot.follow(Dance(), seconds=6 * 0.7, gait="free")
        rest = [leg.rest_foot for leg in model.legs]
        nearest = min(math.dist(a[:2], b[:2]) for a, b in itertools.combinations(rest, 2))
        assert min(math.dist(a[:2], b[:2]) for row in feet for a, b in itertools.combinations(row, 2)) > 0.55 * nearest
        # Measured, the robot standing: the joints give by some millimetres.
        for (x, y, _), (rx, ry, _) in zip(feet_now(fake), rest, strict=True):
            assert math.hypot(x - rx, y - ry) < 0.012
        assert not fake.fell
        assert fake.max_tilt_deg < TILT[name]
        assert math.hypot(fake.displacement.x, fake.displacement.y) < 0.08
        assert all(fake.contacts.values())


def feet_now(fake: FakeRobot) -> list[Any]:
    """Return where the feet really are in the base frame."""
    return [
        foot_position(leg, [fake.joints[joint.name] for joint in leg.joints]) for leg in fake.robot.model.legs]


@pytest.mark.parametrize(("robot", "tolerance"), [("hexapod", 0.12), ("quadruped", 0.18)])
def test_turning_on_the_spot(robot: str, tolerance: float) -> None:
    report = rig.walk(robot, gait="free", turn=rig.TURN, duration=6.0)
    rig.assert_sound(report, tilt_deg=TILT[robot])
    assert report["heading_change_deg"] == pytest.approx(120.0, rel=tolerance)
    assert math.hypot(report["displacement"]["x"], report["displacement"]["y"]) < 0.03
