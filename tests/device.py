"""The simulated robot as a device in a process of its own."""

import contextlib
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

COMMAND = [sys.executable, "-c", "from robotwalk.cli.main import main; main()"]


@contextlib.contextmanager
def served(robot: str, *where: str) -> Iterator[dict[str, str]]:
    """Run `robotwalk sim`; yield the URLs of its buses. It must end by SIGTERM, and in good order."""
    device = subprocess.Popen([*COMMAND, "sim", robot, *where], stdout=subprocess.PIPE, text=True)
    try:
        assert device.stdout is not None
        yield json.loads(device.stdout.readline())["buses"]
    finally:
        device.terminate()
        assert device.wait(20) == 143


def last_truth(path: Path) -> dict[str, Any]:
    """Return the newest whole line of a truth file, into which somebody is writing."""
    whole, _, _ = path.read_text().rpartition("\n")
    return dict(json.loads(whole.rpartition("\n")[2]))


class Device(NamedTuple):
    """A simulated robot behind a port."""

    robot: str
    port: str  # BUS=URL
    truth_file: Path

    def truth(self) -> dict[str, Any]:
        """Return what is the case now."""
        time.sleep(0.1)
        return last_truth(self.truth_file)

    def walk(self, *words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [*COMMAND, "walk", self.robot, "--port", self.port, *words], capture_output=True, text=True, check=False)

    def start_walking(self) -> subprocess.Popen[str]:
        """Start a long walk; return once the robot is under way."""
        walk = subprocess.Popen(
            [*COMMAND, "walk", self.robot, "--port", self.port, "--duration", "600"], text=True,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.await_motion()
        return walk

    def await_motion(self) -> None:
        deadline = time.monotonic() + 60.0
        start = self.truth()["distance_m"]
        while self.truth()["distance_m"] < start + 0.05:
            assert time.monotonic() < deadline, "it does not walk"


def devices(robot: str, folder: Path, *words: str) -> Iterator[Device]:
    truth = folder / "truth.jsonl"
    with served(robot, "--pty", str(folder), "--truth", str(truth), *words) as buses:
        yield Device(robot, f"legs={buses['legs']}", truth)


def assert_seated(device: Device) -> None:
    truth = device.truth()
    assert truth["base"]["pos"][2] < 0.08
    assert not truth["fell"]


def loop_of(walk: subprocess.Popen[str]) -> int:
    """Return the process id of a command's loop: it is its one child."""
    children = Path(f"/proc/{walk.pid}/task/{walk.pid}/children").read_text().split()
    assert [Path(f"/proc/{child}/comm").read_text() for child in children] == ["robotwalk-loop\n"]
    return int(children[0])
