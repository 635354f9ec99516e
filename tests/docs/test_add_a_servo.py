"""The page about adding a servo: its file is written and its commands are run as they stand there."""

import re
import shlex
import subprocess
from pathlib import Path

import pytest

from ..device import COMMAND, served
from ..robots import hexapod_that_does_not_feel

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "add-a-servo.md").read_text()
COMMANDS = [shlex.split(line)[1:] for line in re.findall(r"^\$ (robotwalk .*)$", PAGE, re.MULTILINE)]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a robot's file, and the new servo's beside it, as the page has it."""
    (text,) = re.findall(r"```yaml\n(# (?:servos/xl430-w500\.yaml)\n.*?)```", PAGE, re.DOTALL)
    (tmp_path / "servos").mkdir()
    (tmp_path / "servos" / "xl430-w500.yaml").write_text(text)
    robot = hexapod_that_does_not_feel().replace("servo: xl430-w250", "servo: xl430-w500")
    (tmp_path / "my_robot.yaml").write_text(robot)
    return tmp_path


def run(folder: Path, words: list[str]) -> str:
    done = subprocess.run([*COMMAND, *words], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_robot_is_checked_and_walks(folder: Path) -> None:
    check, walk = COMMANDS[:2]
    assert "all checks passed" in run(folder, check)
    out = run(folder, walk)
    assert re.search(r"0\.2[3-7]\d m in 5\.0 s", out), out
    assert "no fall" in out


def test_the_tools_know_it(folder: Path) -> None:
    with served(str(folder / "my_robot.yaml"), "--pty", str(folder / "device")) as buses:
        scan, info, wiggle = (
            [buses["legs"] if word == "/dev/ttyUSB0" else word for word in words] for words in COMMANDS[2:])
        assert run(folder, [*scan, "--baud", "1000000", "--json"]).count('"xl430-w500"') == 18
        assert "model number 1061" in run(folder, info)
        assert "id 1 (xl430-w500): turned +" in run(folder, wiggle)
        words = ["servo", "ping", "7", "--port", buses["legs"], "--servos", "servos"]
        assert "id 7: xl430-w500" in run(folder, words)
        assert "id 7: unknown (model number 1061)" in run(folder, words[:-2]), "without it, it is nobody's"


def test_a_servo_that_is_nowhere_is_named_with_its_place(folder: Path) -> None:
    (folder / "servos" / "xl430-w500.yaml").unlink()
    done = subprocess.run([*COMMAND, "check", "my_robot.yaml"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 3
    assert re.match(r"my_robot\.yaml:\d+:\d+: hardware\.joints\.lf_coxa\.servo: no such servo", done.stderr)
