"""The page about IMUs: its example is run as it stands there."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

from robotwalk.config import library

PAGE = Path(__file__).resolve().parents[2] / "docs" / "imu.md"
ROBOTWALK = [sys.executable, "-c", "from robotwalk.cli.main import main; main()"]


def test_the_example_walks_level_on_the_slope(tmp_path: Path) -> None:
    page, robot = PAGE.read_text(), library.open_document("robots", "hexapod").text
    blocks = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    assert len(blocks) == 2
    assert "take its line `orientation` out" in page
    robot, count = re.subn(r"^  orientation:.*\n", "", robot, flags=re.MULTILINE)
    assert count == 1
    for block in blocks:
        section, _, rest = block.partition("\n")
        assert robot.count(f"\n{section}\n") == 1
        robot = robot.replace(f"\n{section}\n", f"\n{section}\n{rest}")
    (tmp_path / "my_robot.yaml").write_text(robot)
    check = [*ROBOTWALK, "check", "my_robot.yaml"]
    told = subprocess.run(check, cwd=tmp_path, capture_output=True, text=True, check=False).stdout
    assert "mounted at roll 180, pitch 0, yaw 90 deg; the body is kept level by it" in told
    (command,) = re.findall(r"^\$ robotwalk (.*)$", page, re.MULTILINE)
    done = subprocess.run(
        [*ROBOTWALK, *shlex.split(command), "--json"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["max_tilt_deg"] < 5.0
    assert report["imu"]["max_tilt_deg"] < 5.0
    assert report["imu"]["max_age_ms"] < 30.0


def test_the_page_tells_of_every_kind() -> None:
    assert set(library.names("imus")) <= set(re.findall(r"`([a-z0-9-]+)`", PAGE.read_text()))
