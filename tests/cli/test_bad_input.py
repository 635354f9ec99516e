"""Bad input: one clear sentence on stderr, the documented exit code, no traceback."""

import os
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest

from robotwalk.config import library

from .conftest import COMMAND, Run

HEXAPOD = (library.root() / "robots" / "hexapod.yaml").read_text()


@pytest.mark.parametrize(("words", "code", "sentence"), [
    (["walk", "hexpod"], 2, "no robot is named 'hexpod'; did you mean 'hexapod'?"),
    (["walk", "missing.yaml"], 3, "missing.yaml: cannot be read: No such file or directory"),
    (["walk", "hexapod", "--gait", "trot"], 2, "hexapod has no gait 'trot'; it has free, limp, ripple, stroll"),
    (["walk", "hexapod", "--speed", "nan"], 2, "--speed should be a finite number, not nan"),
    (["walk", "hexapod", "--turn", "inf"], 2, "--turn should be a finite number, not inf"),
    (["walk", "hexapod", "--duration", "-1"], 2, "a walk lasts 0 to 86400 s, not -1.0"),
    (["walk", "hexapod", "--duration", "1e308"], 2, "a walk lasts 0 to 86400 s, not 1e+308"),
    (["walk", "hexapod", "--seed", "-1"], 2, "a seed is a whole number from 0 on, not -1"),
    (["walk", "hexapod", "--port", "legs"], 2, "--port should be BUS=URL"),
    (["walk", "hexapod", "--port", "arms=/dev/null"], 2, "hexapod has no bus 'arms'; it has legs"),
    (["walk", "hexapod", "--port", "legs=socket://[::1:5000"], 2, "may be a physical robot: say --real"),
    (["walk", "hexapod", "--port", "legs=/dev/nosuch"], 4, "cannot open /dev/nosuch: there is no such port"),
    (["walk", "hexapod", "--port", "legs=socket://localhost"], 4, "this is no address of a port"),
    (["walk", "hexapod", "--port", "legs=/dev/null", "--gif", "a.gif"], 2, "--gif is for a simulation"),
    (["walk", "hexapod", "--port", "legs=/dev/null", "--faults", "a.yaml"], 2, "--faults is for a simulation"),
    (["walk", "hexapod", "--faults", "missing.yaml"], 3, "missing.yaml: cannot be read: No such file or directory"),
    (["check", "hexapod", "--rate", "0"], 2, "the rate should be 10 to 1000 Hz, not 0"),
    (["bench", "sim", "--seconds", "0"], 2, "--seconds should be above 0"),
    (["bench", "tick", "--seconds", "nan"], 2, "--seconds should be above 0"),
    (["walk", "hexapod", "--height", "0.5"], 2, "height 0.5 m is outside 0.095 to 0.135 m of hexapod"),
    (["walk", "hexapod", "--turn", "5", "--heading", "5"], 2, "--turn and --heading exclude each other"),
    (["walk", "hexapod", "--goto", "1"], 2, "--goto should be X,Y in metres, such as 1.5,-0.3, not '1'"),
    (["walk", "hexapod", "--goto", "-0,0"], 2, "somewhere else than the start"),
    (["walk", "hexapod", "--goto", "1,nan"], 2, "--goto should be finite"),
    (["walk", "hexapod", "--goto", "1,0", "--turn", "5"], 2, "leave out --direction and --turn"),
    (["walk", "hexapod", "--goto", "1,0", "--path", "a.yaml"], 2, "--goto and --path exclude each other"),
    (["walk", "hexapod", "--goto", "1,0", "--speed", "0"], 2, "--speed should be above 0"),
    (["walk", "hexapod", "--path", "missing.yaml"], 3, "missing.yaml: cannot be read: No such file or directory"),
    (["walk", "hexapod", "--rate", "5"], 2, "the rate should be 10 to 1000 Hz, not 5"),
    (["walk", "hexapod", "--gif", "no/such/folder/walk.gif"], 2, "no/such/folder"),
    (["walk", "hexapod", "--log", "no/such/folder/walk.mcap"], 2, "no/such/folder/walk.mcap"),
    (["walk", "hexapod", "--sped", "1"], 2, "--sped"),
    (["walk", "hexapod", "--speed", "fast"], 2, "fast"),
    (["walk"], 2, "ROBOT"),
    (["wander", "hexapod"], 2, "wander"),
])
def test_a_wrong_command_line(run: Run, words: list[str], code: int, sentence: str) -> None:
    result = run(*words)
    assert result.code == code
    assert sentence in result.err
    assert result.out == ""
    assert result.err.startswith("missing.yaml: " if code == 3 else "robotwalk: ")
    assert result.err.count("\n") == 1, "one sentence"


@pytest.mark.parametrize(("old", "new", "message"), [
    # An unknown key names the nearest valid one.
    ("yaw_deg: 45", "yaw_dg: 45", r"^robot.yaml:16:7: skeleton.legs.lf: unknown key .yaw_dg.*did you mean 'yaw_deg'\?"),
    # A length that is no number.
    ("link_mm: [66, 0, 0]", "link_mm: [.nan, 0, 0]", r"robot.yaml:\d+:\d+: .*femur\.link_mm\.0: .*finite.*nan"),
    ("lf_femur: {bus: legs, id: 2,", "lf_femur: {bus: legs, id: 300,",
     r"robot.yaml:\d+:\d+: hardware\.joints\.lf_femur\.id: .*252.*\(got 300\)"),
    ("lf_femur: {bus: legs, id: 2,", "lf_femur: {bus: legs, id: 1,",
     r"robot.yaml:\d+:\d+: hardware\.joints\.lf_femur\.id: already the id of lf_coxa on bus 'legs' \(got 1\)"),
    ("rest_mm: [135, 0]", "rest_mm: [290, 0]",
     r"robot.yaml:\d+:\d+: locomotion\.feet\.lf\.rest_mm: unreachable stance"),
    ("servo: xl430-w250, direction: 1,  zero_deg: 0", "servo: xl431, direction: 1,  zero_deg: 0",
     r"hardware\.joints\.lf_coxa\.servo: no such servo; there are .*xl430-w250.* \(got 'xl431'\)"),
    ("zero_deg: 90", "zero_deg: -90", r"hardware\.joints\.lf_tibia\.zero_deg: .*leave the servo's range"),
    ("schema: 1", "schema: 2", r"robot.yaml:3:9: schema: .*1.*\(got 2\)"),
    ("sit: 30", "sit: 130", r"locomotion\.height_mm: expected sit < lowest"),
    ("lm: *foot", "", r"locomotion\.feet: leg 'lm' is missing"),
    ("skeleton:", "skeleton: [", r"robot.yaml:\d+:\d+: "),
    ("mass_g: 1150", "mass_g: heavy", r"skeleton\.body\.mass_g: .*number.*heavy"),
])
def test_a_broken_robot_file(run: Run, tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in HEXAPOD
    (tmp_path / "robot.yaml").write_text(HEXAPOD.replace(old, new, 1))
    result = run("walk", "robot.yaml")
    assert result.code == 3
    assert result.out == ""
    assert re.search(message, result.err, re.MULTILINE), result.err


@pytest.mark.parametrize(("text", "message"), [
    ("schema: 1\nwaypoints_m: [[0.5, 0], [500, zero]]", r"^path.yaml:2:31: waypoints_m\.1\.1: .*number.*'zero'"),
    ("schema: 1\nwaypoint_m: [[0.5, 0]]", r"path.yaml:2:1: unknown key 'waypoint_m': did you mean 'waypoints_m'\?"),
    ("schema: 1\nwaypoints_m:\n  - [1, 0]\n  - [1, 0]", r"path.yaml:4:5: waypoints_m\.1: .*than waypoint 0"),
    ("schema: 1\nfacing: left\nwaypoints_m: [[1, 0]]", r"path.yaml:2:9: facing: .*'kept' or 'ahead'.*'left'"),
])
def test_a_broken_path_file(run: Run, tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "path.yaml").write_text(text)
    result = run("walk", "hexapod", "--path", "path.yaml")
    assert (result.code, result.out) == (3, "")
    assert re.search(message, result.err, re.MULTILINE), result.err


def test_a_wrong_word_costs_no_log_of_yesterday(run: Run, tmp_path: Path) -> None:
    (tmp_path / "keep.mcap").write_text("yesterday")
    assert run("walk", "hexapod", "--gait", "nosuch", "--log", "keep.mcap").code == 2
    assert (tmp_path / "keep.mcap").read_text() == "yesterday"


def test_several_mistakes_are_told_at_once_in_order(run: Run, tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(HEXAPOD.replace("mass_g: 3}", "mass_g: -3}").replace("sit: 30", "sit: low"))
    err = run("check", "robot.yaml").err
    assert err.index("skeleton.foot.mass_g") < err.index("locomotion.height_mm.sit")


def interrupted(robot: list[str], *signals: int, tmp_path: Path) -> tuple[int, str]:
    """Start a long walk, signal it in mid-stride, return its exit code and stderr."""
    process = subprocess.Popen(
        [*COMMAND, "walk", "hexapod", "--duration", "900", "--log", "walk.mcap", *robot], cwd=tmp_path,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    log = tmp_path / "walk.mcap"
    deadline = time.monotonic() + 60.0
    while not (log.exists() and log.stat().st_size > 0):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    time.sleep(1.0)
    for number in signals:
        os.kill(process.pid, number)
        time.sleep(0.02)
    _, err = process.communicate(timeout=60)
    assert "Traceback" not in err
    return process.returncode, err


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_signal_in_mid_stride_seats_the_robot(tmp_path: Path, number: int, code: int) -> None:
    returned, err = interrupted([], number, tmp_path=tmp_path)
    assert returned == code
    assert "the robot sat down, torque is off" in err


def test_a_second_ctrl_c_freezes_it(tmp_path: Path) -> None:
    returned, err = interrupted([], signal.SIGINT, signal.SIGINT, tmp_path=tmp_path)
    assert returned == 130
    assert "the robot is frozen in place, torque is on" in err
