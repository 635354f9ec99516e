"""The quadruped crawls over ground that is not level, without an IMU: its feet's loads tell which way is down."""

import math
import re
from pathlib import Path

import pytest

from robotwalk import assembly
from robotwalk.config import library
from robotwalk.testing import FakeRobot

from . import rig

_PAGE = Path(__file__).parents[2] / "docs" / "contact.md"


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """Return the quadruped's file with the lines of the page."""
    lines = re.search(r"## The quadruped.*?```yaml\nlocomotion:\n(.*?)```", _PAGE.read_text(), re.DOTALL)
    assert lines is not None
    path = tmp_path / "quadruped_uneven.yaml"
    text = library.open_document("robots", "quadruped").text
    path.write_text(text.replace("\nlocomotion:\n", f"\nlocomotion:\n{lines[1]}"))
    return path


def test_up_a_ramp_it_keeps_its_body_level(robot: Path) -> None:
    with FakeRobot(robot, terrain="ramp_8") as fake:
        pitches: list[float] = []
        fake.robot.stand()
        fake.robot.observers.append(lambda tick: pitches.append(math.degrees(fake.base.pitch)))
        fake.robot.walk(vx=0.04, seconds=15.0, gait="crawl")
        assert fake.base.x > 0.9 * 0.6
        assert fake.base.z > 0.18  # all feet are on it
        assert not fake.fell
    assert max(map(abs, pitches)) < 6.0  # 11 blind: 8 of the ramp, and it tips off its rear feet
    assert abs(sum(pitches[-300:]) / 300.0) < 2.5


def test_on_uneven_ground_all_its_feet_bear(robot: Path) -> None:
    report = rig.walk(
        assembly.load(str(robot)), terrain="rough_15", speed=0.04, duration=24.0, gait="crawl", seed=1)
    assert not report["fell"]
    assert report["distance_m"] > 0.9 * 0.96
    assert report["max_tilt_deg"] < 6.0
