"""The page about testing one's own robot: its example is run as it stands there."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from robotwalk.config import library
from robotwalk.errors import ConfigError
from robotwalk.testing import FakeRobot

PAGE = Path(__file__).resolve().parents[2] / "docs" / "testing-your-robot.md"


def test_the_examples_tests_pass_with_the_fixture_of_the_package(tmp_path: Path) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (tmp_path / "test_my_robot.py").write_text(code)
    (tmp_path / "my_robot.yaml").write_text(library.open_document("robots", "hexapod").text)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_my_robot.py"],
        cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "4 passed" in done.stdout, done.stdout + done.stderr


def test_a_fault_that_befalls_it_now_begins_now() -> None:
    with FakeRobot("hexapod") as fake:
        fake.robot.stand()
        fake.befall("drop_reply", joint="rr_tibia", for_=0.1)
        before = fake.seconds
        fake.robot.walk(vx=0.05, seconds=0.5)
        assert fake.seconds - before > 0.5
        assert 3 <= fake.robot.bus_statistics()["legs"].lost_replies <= 6


def test_a_fault_that_does_not_fit_is_refused() -> None:
    with FakeRobot("hexapod") as fake, pytest.raises(ConfigError, match="joint"):
        fake.befall("dead_servo", joint="nose")


def test_measuring_begins_anew() -> None:
    with FakeRobot("hexapod") as fake:
        fake.robot.stand()
        assert fake.distance_m == 0.0
        fake.robot.walk(vx=0.1, seconds=1.0)
        first = fake.distance_m
        fake.restart_measuring()
        assert fake.distance_m == 0.0
        fake.robot.walk(vx=0.1, seconds=1.0)
        assert fake.distance_m == pytest.approx(first, rel=0.15)
        assert fake.energy_j > 0.0
        assert fake.displacement.x == pytest.approx(first, rel=0.2)
        assert abs(fake.heading_change_deg) < 2.0
        assert fake.min_height_m > 0.09
