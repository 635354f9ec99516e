"""`robotwalk calibrate` as a user runs it, with a hand on the shafts of servos behind a pseudo terminal."""

import math
import re
import subprocess
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml

from robotwalk import assembly
from robotwalk.config import library
from sim_backend.pty_endpoint import open_ptys
from sim_backend.real_time import RealTime
from sim_backend.server import Server
from sim_backend.vice import Bench, BenchServo

from .conftest import COMMAND, Run

COUNT = math.tau / 4096


class Hands:
    """Turn the shafts of the hexapod's servos, while a program listens to these."""

    def __init__(self, folder: Path) -> None:
        blueprint = assembly.load("hexapod")
        self._names = list(blueprint.model.joint_names)
        servos = [BenchServo("legs", wired.id, wired.model, 0.0) for wired in blueprint.wiring["legs"]]
        self._bench = Bench(servos, blueprint.bauds)
        self._stop = threading.Event()
        self._folder = folder
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self.ready = threading.Event()

    def turn(self, joint: str, counts: int) -> None:
        self._bench.turn(self._names.index(joint), (counts - 2048) * COUNT)

    def _serve(self) -> None:
        def check() -> None:
            if self._stop.is_set():
                raise EOFError

        with open_ptys(self._folder, {"legs": 1_000_000}) as endpoints:
            self.ready.set()
            server = Server(self._bench, endpoints, RealTime(self._bench.clock.now()), lambda text: None)
            try:
                server.run(check, None)
            except EOFError:
                return

    def __enter__(self) -> "Hands":
        self._thread.start()
        assert self.ready.wait(10)
        return self

    def __exit__(self, *error: object) -> None:
        self._stop.set()
        self._thread.join(10)


@pytest.fixture
def hands(tmp_path: Path) -> Iterator[Hands]:
    with Hands(tmp_path / "bus") as both:
        yield both


def converse(folder: Path, words: list[str], answers: list[tuple[str, Callable[[], None], str]]) -> tuple[int, str]:
    """Run the command; at each prompt that matches, do something and answer. Return exit code and all that was said."""
    program = subprocess.Popen(
        [*COMMAND, "calibrate", str(folder / "mine.yaml"), *words, "--port", f"legs={folder / 'bus' / 'legs'}"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert program.stdin is not None
    assert program.stdout is not None
    said = ""
    for prompt, act, answer in answers:
        while not re.search(prompt, said.splitlines()[-1] if said else ""):
            line = program.stdout.readline()
            assert line, said
            said += line
        act()
        program.stdin.write(f"{answer}\n")
        program.stdin.flush()
        said += "\n"
    program.stdin.close()
    said += program.stdout.read()
    return program.wait(20), said


def pause(act: Callable[[], None]) -> Callable[[], None]:
    """Do something, and give a program that looks fifty times a second time to see it."""
    def slowly() -> None:
        act()
        threading.Event().wait(0.3)
    return slowly


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    path = tmp_path / "mine.yaml"
    path.write_text(library.open_document("robots", "hexapod").text)
    return path


def steps(hands: Hands, joint: str, last: str = "s") -> list[tuple[str, Callable[[], None], str]]:
    """Zero at 2100; the positive way is up; from 1700 to 2500."""
    def sweep() -> None:
        for counts in (2300, 2500, 2300, 2100, 1900, 1700, 1900, 2100):
            pause(lambda counts=counts: hands.turn(joint, counts))()

    return [
        ("put it to 0 deg", pause(lambda: hands.turn(joint, 2100)), ""),
        ("positive way", pause(lambda: hands.turn(joint, 2300)), ""),
        ("one end of its range", sweep, ""),
        ("hands off", lambda: None, last)]


def test_a_joint_is_calibrated_saved_and_taken_into_account(tmp_path: Path, mine: Path, hands: Hands) -> None:
    code, said = converse(tmp_path, ["lf_coxa"], steps(hands, "lf_coxa"))
    assert code == 0, said
    file = tmp_path / "mine.calibration.yaml"
    row = yaml.safe_load(file.read_text())["joints"]["lf_coxa"]
    assert (row["servo"], row["direction"], row["verified"]) == ("xl430-w250", 1, False)
    assert row["zero_deg"] == pytest.approx(-52 * 360 / 4096, abs=0.2)
    assert row["range_deg"] == pytest.approx([-400 * 360 / 4096, 400 * 360 / 4096], abs=0.5)
    assert f"there was no calibration before; to undo: rm {file}" in said
    exact = assembly.load(str(mine), calibrated=True)
    assert exact.hardware.joints["lf_coxa"].zero_deg == row["zero_deg"]
    assert math.degrees(exact.model.joints[0].lower) == pytest.approx(row["range_deg"][0])


def test_comments_and_other_joints_stay_and_the_file_before_is_kept(tmp_path: Path, mine: Path, hands: Hands) -> None:
    file = tmp_path / "mine.calibration.yaml"
    before = (
        "# my robot, after the crash\nschema: 1\nrobot: hexapod\njoints:\n"
        "  lm_coxa: {servo: xl430-w250, direction: 1, zero_deg: 2.5, time: then}  # this one is bent\n"
        "  lf_coxa: {servo: xl430-w250, direction: -1, zero_deg: 9, time: then}\n")
    file.write_text(before)
    code, said = converse(tmp_path, ["lf_coxa"], steps(hands, "lf_coxa"))
    assert code == 0, said
    text = file.read_text()
    assert "# my robot, after the crash" in text
    assert "# this one is bent" in text
    rows = yaml.safe_load(text)["joints"]
    assert rows["lm_coxa"]["zero_deg"] == 2.5
    assert rows["lf_coxa"]["direction"] == 1
    (saved,) = tmp_path.glob("mine.calibration.yaml.*")
    assert saved.read_text() == before
    assert f"to undo: mv {saved} {file}" in said


def test_a_joint_that_does_not_come_back_by_itself_is_saved_but_not_called_verified(
    tmp_path: Path, mine: Path, hands: Hands
) -> None:
    """The hand is still on it."""
    moved = [*steps(hands, "lf_coxa")[:3], (
        "hands off", pause(lambda: hands.turn("lf_coxa", 2300)), "")]
    code, said = converse(tmp_path, ["lf_coxa"], moved)
    assert code == 0, said
    assert re.search(r"it stopped \+1[678]\.\d deg from where it began: saved, but not verified", said)
    assert not yaml.safe_load((tmp_path / "mine.calibration.yaml").read_text())["joints"]["lf_coxa"]["verified"]


def test_an_end_in_the_middle_keeps_what_was_done_and_says_so(tmp_path: Path, mine: Path, hands: Hands) -> None:
    answers = [*steps(hands, "lf_coxa"), ("put it to", lambda: None, "q")]
    code, said = converse(tmp_path, ["lf_coxa", "lm_coxa"], answers)
    assert code == 1
    assert "1 of 2 joints calibrated" in said
    assert list(yaml.safe_load((tmp_path / "mine.calibration.yaml").read_text())["joints"]) == ["lf_coxa"]


@pytest.mark.parametrize(("words", "code", "complaint"), [
    (["nosuch"], 2, "no robot is named 'nosuch'"),
    (["hexapod", "lf_hip", "--real"], 2, "hexapod has no joint 'lf_hip'"),
    (["hexapod", "--port", "arms=/dev/x"], 2, "hexapod has no bus 'arms'; it has legs"),
    (["hexapod", "--torque", "90"], 2, "--torque should be 5 to 50, not 90"),
    (["hexapod", "lf_coxa", "--real"], 4, "cannot open /dev/ttyUSB0"),
])
def test_what_cannot_be_calibrated(robotwalk: Run, words: list[str], code: int, complaint: str) -> None:
    result = robotwalk("calibrate", *words)
    assert (result.code, complaint in result.err) == (code, True), result.err
