"""`robotwalk servo decode`: a log's traffic, and a line's, in words."""

import json
import os
import pty
import select
import subprocess
import tty
from pathlib import Path

import pytest

from hal import feetech_protocol

from .conftest import COMMAND, Run


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("log") / "walk.mcap"
    subprocess.run([*COMMAND, "walk", "hexapod", "--duration", "0.3", "--log", str(path)], check=True)
    return path


def test_a_log_is_told_from_its_first_question_to_torque_off(robotwalk: Run, log: Path) -> None:
    lines = robotwalk("servo", "decode", str(log)).out.splitlines()
    assert lines[0] == "    0.000000  legs  ->  ping 1"
    assert lines[1].endswith("legs  <-  1 is there: model 1060, firmware 45")
    assert any("fast sync read 1, 2, 3" in line for line in lines)
    assert any("sync write: 1 goal_position = " in line for line in lines)
    assert any(line.endswith("write everyone: torque_enable = 0") for line in lines[-100:])
    assert not any("??" in line for line in lines)


def test_what_one_servo_says_can_be_picked_out_for_scripts(robotwalk: Run, log: Path) -> None:
    told = robotwalk("servo", "decode", str(log), "--id", "7", "--json").out
    found = [json.loads(line) for line in told.splitlines()]
    assert {row["id"] for row in found} == {7}
    assert {row["kind"] for row in found} == {"instruction", "status"}
    assert found[0]["words"] == "ping 7"
    assert bytes.fromhex(found[0]["bytes"])[:5] == b"\xff\xff\xfd\x00\x07"


def test_it_listens_to_a_line_and_sends_nothing() -> None:
    master, slave = pty.openpty()
    tty.setraw(slave)
    listener = subprocess.Popen(
        [*COMMAND, "servo", "decode", "--port", os.ttyname(slave), "--robot", "quadruped", "--seconds", "3"],
        stdout=subprocess.PIPE)
    assert listener.stdout is not None
    told = b""
    while not told:  # what is there when it opens the line, it throws away
        assert listener.poll() is None
        os.write(master, feetech_protocol.read(1, 56, 2))
        if select.select([listener.stdout], [], [], 0.1)[0]:
            told = os.read(listener.stdout.fileno(), 4096)
    os.write(master, bytes.fromhex("FF FF 01 04 00 00 08 F2"))
    told += listener.stdout.read()
    os.set_blocking(master, False)
    with pytest.raises(BlockingIOError):
        os.read(master, 1)
    lines = told.decode().splitlines()
    assert lines[0].endswith("->  read 1: present_position")
    assert lines[-1].endswith("<-  1 present_position = 2048 step")
    os.close(master)
    os.close(slave)


@pytest.mark.parametrize(("words", "complaint"), [
    ([], "say what to decode: either a log or --port URL"),
    (["--port", "/dev/null"], "say what is spoken there"),
    (["--port", "/dev/null", "--robot", "octopod"], "octopod has several buses: say --bus left or --bus right"),
    (["missing.mcap"], "cannot read the log missing.mcap: No such file or directory"),
])
def test_what_cannot_be_decoded(robotwalk: Run, words: list[str], complaint: str) -> None:
    result = robotwalk("servo", "decode", *words)
    assert result.code == 2
    assert complaint in result.err
