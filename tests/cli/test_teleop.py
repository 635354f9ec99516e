"""What `robotwalk teleop` refuses, before anything moves. Driving itself: tests/teleop."""

import subprocess
import sys
from pathlib import Path

import pytest

from .conftest import Run


@pytest.mark.parametrize(("words", "says"), [
    ([], "the keyboard's input is no terminal"),
    (["--listen", "0.0.0.0:8765"], "put a token into ROBOTWALK_TOKEN"),
])
def test_a_wrong_command_line(run: Run, words: list[str], says: str) -> None:
    result = run("teleop", "hexapod", *words)
    assert result.code == 2
    assert says in result.err
    assert result.out == ""


def test_a_gamepad_without_its_extra(tmp_path: Path) -> None:
    program = "import sys; sys.modules['pygame'] = None; from robotwalk.cli.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", program, "teleop", "hexapod", "--input", "gamepad"], capture_output=True, text=True,
        check=False)
    assert done.returncode == 2
    assert done.stderr == "robotwalk: a gamepad needs the extra: pip install 'robotwalk[gamepad]'\n"
