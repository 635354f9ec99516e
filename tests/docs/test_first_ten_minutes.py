"""The page for the first ten minutes: its commands are run as they stand there, on a robot served as it says."""

import os
import re
import shlex
import subprocess
from pathlib import Path

import pytest

from ..device import COMMAND, served
from ..teleop.rig import UNHURRIED, Kitty, await_that

pytestmark = pytest.mark.xdist_group("real time")

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "first-ten-minutes.md").read_text()
SHOWN = [
    (shlex.split(command)[1:], out.splitlines())
    for block in re.findall(r"```console\n(.*?)```", PAGE, re.DOTALL)
    for command, out in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", block, re.MULTILINE)]


def shape(line: str) -> str:
    """Return a line without what differs from run to run."""
    return re.sub(r"[-+]?\d+(\.\d+)?", "#", line.rstrip())


def assert_shows(out: str, lines: list[str]) -> None:
    """Assert that an output has those lines in their order; `...` stands for any."""
    left = iter(map(shape, out.splitlines()))
    anywhere = False
    for line in lines:
        if line == "...":
            anywhere = True
            continue
        wanted = shape(line)
        assert (wanted in left) if anywhere else (next(left) == wanted), (line, out)
        anywhere = False


def test_all_of_it_is_true(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    for place in ("CONFIG_HOME", "RUNTIME_DIR", "STATE_HOME"):
        monkeypatch.setenv(f"XDG_{place}", str(tmp_path))
    (sim, ready), *rest, (teleop, screen) = SHOWN
    assert [words[:2] for words, _ in rest] == [
        ["servo", "scan"], ["servo", "set-id"], ["servo", "set-id"], ["servo", "wiggle"], ["calibrate", "hexapod"],
        ["check", "hexapod"], ["walk", "hexapod"]]
    with served(*sim[1:]) as buses:
        assert f'"buses": {{"legs": "{buses["legs"]}"}}' in ready[0]
        for words, lines in rest:
            done = subprocess.run([*COMMAND, *words], input="q\n", capture_output=True, text=True, check=False)
            assert done.returncode == (words[0] == "calibrate"), done.stderr  # nobody's hands moved the joint
            assert_shows(done.stdout, lines)
        drive(teleop, screen)


def drive(words: list[str], lines: list[str]) -> None:
    """Run it in a terminal, and end it as the page says."""
    kitty = Kitty()
    with subprocess.Popen(
        [*COMMAND, *words], stdin=kitty.slave, stdout=kitty.slave, stderr=kitty.slave,
        env={name: value for name, value in os.environ.items() if name != "COLUMNS"},
        preexec_fn=lambda: os.login_tty(kitty.slave),
    ) as teleop:
        await_that(lambda: b"STAND" in kitty.seen, "it stands")
        kitty.key(ord("d"), modifiers=5)
        assert teleop.wait(UNHURRIED) == 0
    plain = re.sub(r"\x1b\[[0-9;?<>]*[A-Za-z]", "\n", kitty.seen.decode())
    for line in lines:
        words_of_it = line.strip("│╭╮─ ")
        assert line == "..." or re.sub(r"\s+", " ", words_of_it)[6:40] in re.sub(r"\s+", " ", plain), line
