"""The page about the ground: its example is run as it stands there."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

from PIL import Image

from robotwalk.config import library

PAGE = Path(__file__).resolve().parents[2] / "docs" / "terrains.md"
ROBOTWALK = [sys.executable, "-c", "from robotwalk.cli.main import main; main()"]


def test_the_commands_of_the_example_run_on_its_file(tmp_path: Path) -> None:
    page = PAGE.read_text()
    (file,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    (tmp_path / "garden.yaml").write_text(file)
    walk, bench = (shlex.split(line) for line in re.findall(r"^\$ robotwalk (.*)$", page, re.MULTILINE))
    told = []
    for command in (walk, bench):
        done = subprocess.run(
            [*ROBOTWALK, *command, "--json"], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        told.append(json.loads(done.stdout))
    assert 0.25 < told[0]["distance_m"] < 0.5
    assert told[1]["courses"][0]["terrain"] == "garden.yaml"
    with Image.open(tmp_path / "garden.gif") as film:
        assert film.n_frames > 50


def test_the_page_tells_of_every_bundled_terrain() -> None:
    told = set(re.findall(r"`([a-z]+(?:_\d+)?)`", PAGE.read_text()))
    assert set(library.names("terrains")) <= told
