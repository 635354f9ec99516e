"""Robots find their way in MuJoCo by leg odometry, judged by where their bodies really are."""

import math
from pathlib import Path

import pytest

from robotwalk import assembly
from robotwalk.assembly.replay import replay
from robotwalk.behaviours import Arrive, Wander
from robotwalk.config.route import Route
from robotwalk.errors import UsageError
from robotwalk.estimator import Estimate
from robotwalk.testing import FakeRobot
from robotwalk.types import Command, Twist

from . import rig


@pytest.mark.parametrize(("robot", "goal", "heading", "miss"), [
    ("hexapod", (0.5, 0.25), None, 0.015), ("hexapod", (-0.2, -0.3), math.radians(40), 0.015),
    ("quadruped", (0.5, 0.2), None, 0.04)])
def test_a_goal_is_reached_with_the_heading_that_was_wanted(
    robot: str, goal: tuple[float, float], heading: float | None, miss: float
) -> None:
    report = rig.walk(robot, route=Route((goal,)), speed=0.1, heading=heading, duration=20.0)
    rig.assert_sound(report, tilt_deg=6.0)
    assert report["goal"]["reached"]
    assert report["goal"]["miss_m"] < miss
    assert math.dist((report["displacement"]["x"], report["displacement"]["y"]), goal) < miss
    assert report["heading_change_deg"] == pytest.approx(math.degrees(heading or 0.0), abs=3.0)
    assert report["duration_s"] < 15.0, "it ends when it is there"
    assert report["distance_m"] == pytest.approx(math.hypot(*goal), abs=miss)


def test_a_path_around_corners_leads_back_to_the_start() -> None:
    route = Route(((0.3, 0.0), (0.3, 0.3), (0.0, 0.0)), ahead=True)
    report = rig.walk("hexapod", route=route, speed=0.1, duration=40.0)
    rig.assert_sound(report, tilt_deg=4.0)
    assert report["goal"]["reached"]
    assert report["goal"]["miss_m"] < 0.03
    assert report["heading_change_deg"] == pytest.approx(225.0, abs=8.0)
    assert report["distance_m"] == pytest.approx(0.6 + 0.3 * math.sqrt(2.0), abs=0.03)


def test_python_follows_one_behaviour_after_the_other() -> None:
    with FakeRobot("hexapod") as fake:
        with pytest.raises(UsageError, match=r"before stand\(\)"):
            fake.robot.follow(Arrive(0.1, 0.0, speed=0.1), seconds=1.0)
        fake.robot.stand()
        start = fake.base
        assert not fake.robot.follow(Wander(speed=0.08, turn=0.4, within=0.3, seed=3), seconds=4.0)
        assert math.dist(fake.base[:2], start[:2]) > 0.1
        assert fake.robot.follow(Arrive(0.0, 0.0, speed=0.1), seconds=20.0)
        assert math.dist(fake.base[:2], start[:2]) < 0.03


class Mad:
    """Knows no bounds after a second."""

    done = False

    def __init__(self) -> None:
        self.seconds = 0.0

    def step(self, estimate: Estimate, dt: float) -> Command:
        self.seconds += dt
        return Command(Twist(0.05 if self.seconds < 1.0 else math.nan, 0.0, 0.0))


def test_a_behaviour_that_goes_mad_ends_the_walk_and_the_log_of_it_replays(tmp_path: Path) -> None:
    log = tmp_path / "walk.mcap"
    simulation = assembly.simulate("hexapod", log=log)
    robot = simulation.robot
    with robot:
        robot.stand()
        with pytest.raises(UsageError, match="finite numbers"):
            robot.follow(Mad(), seconds=5.0)
    assert simulation.world.truth().base.z < simulation.robot.model.heights.lowest, "it sat down"
    assert robot.events[-1].text == "stop"
    assert replay(log).difference is None
