"""The loop in its process, and who stands behind it: killed, stopped, abandoned, told to stop; judged by the truth."""

import json
import math
import os
import re
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from robotwalk.config import library

from ..device import COMMAND, Device, assert_seated, devices, loop_of

pytestmark = pytest.mark.xdist_group("real time")


@pytest.fixture(autouse=True)
def own_runtime_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`robotwalk stop` is for all loops of a user: those of other tests lie elsewhere."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))


def lines(device: Device) -> list[dict[str, Any]]:
    return [json.loads(line) for line in device.truth_file.read_text().splitlines()[:-1]]


def tilt(line: dict[str, Any]) -> float:
    _, x, y, _ = line["base"]["quat_wxyz"]
    return math.degrees(math.acos(1.0 - 2.0 * (x * x + y * y)))


def motion(some: list[dict[str, Any]]) -> float:
    """Return how far the farthest joint went between the first and any other line, rad."""
    first = some[0]["joints"]
    return max(abs(line["joints"][joint] - first[joint]) for line in some for joint in first)


def between(device: Device, begin: float, end: float) -> list[dict[str, Any]]:
    return [line for line in lines(device) if begin < line["t"] < end]


def await_that(condition: Callable[[], object], what: str, seconds: float = 40.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, what
        time.sleep(0.05)


def has_ended(process: int) -> bool:
    """Tell whether a process is gone, or waits for its parent to reap it."""
    status = Path(f"/proc/{process}/stat")
    return not status.exists() or status.read_text().split()[2] == "Z"


def command(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, *words], capture_output=True, text=True, check=False)


# Run as any Python begins: a signal gets the loop stuck, in Python, for good.
STUCK = """
import signal, sys
def stuck(number, frame):
    while True:
        pass
if "robotwalk.assembly.loop_process" in sys.orig_argv:
    signal.signal(signal.SIGUSR1, stuck)
"""


@pytest.mark.parametrize(("robot", "number", "words"), [
    ("hexapod", signal.SIGKILL, r"was killed \(SIGKILL\)"),
    ("quadruped", signal.SIGSTOP, r"gave no sign of life for 0\.\d s"),
    ("hexapod", signal.SIGUSR1, r"gave no sign of life for 0\.\d s"),
])
def test_the_guardian_takes_over_a_robot_whose_loop_is_gone_in_mid_stride(
    robot: str, number: int, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sitecustomize.py").write_text(STUCK)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    for device in devices(robot, tmp_path):
        walk = device.start_walking()
        loop = loop_of(walk)
        mapped = Path(f"/proc/{loop}/maps").read_text()
        assert "yaml" in mapped
        assert not re.search("numpy|mujoco", mapped), "it locks only what it needs into memory"
        gone = time.monotonic()
        os.kill(loop, number)
        _, err = walk.communicate(timeout=60)
        assert walk.returncode == 5
        assert re.search(f"process {words}: the robot was held where it was, then lowered; torque is off", err)
        assert motion(between(device, gone - 0.4, gone)) > 0.05, "it was in mid-stride"
        held = between(device, gone + 1.0, gone + 1.3)  # it holds for a second, from when it was found out
        assert motion(held) < 0.02, "still within a second"
        assert held[0]["base"]["pos"][2] > 0.08, "and up"
        after = between(device, gone, time.monotonic())
        assert max(map(tilt, after)) < 20.0
        assert_seated(device)
        assert not os.path.exists(f"/proc/{loop}")
        assert list((tmp_path / "robotwalk").iterdir()) == []
        ping = command("servo", "ping", "1", "--port", device.port.partition("=")[2])
        assert ping.returncode == 0, "the port is free"


def test_a_silent_driver_has_the_robot_stand_then_sit_and_a_killed_one_sit(tmp_path: Path) -> None:
    robot = tmp_path / "hexapod.yaml"
    text = library.open_document("robots", "hexapod").text
    robot.write_text(text + "\nsafety:\n  driver: {sit_after_s: 2.5}\n")
    for device in devices(str(robot), tmp_path):
        walk = device.start_walking()
        loop = loop_of(walk)
        walk.send_signal(signal.SIGSTOP)
        silent = time.monotonic()
        await_that(lambda loop=loop: has_ended(loop), "the loop ends")
        standing = between(device, silent + 1.9, silent + 2.3)
        assert standing[0]["base"]["pos"][2] > 0.08, "it stands"
        assert abs(standing[-1]["distance_m"] - standing[0]["distance_m"]) < 0.005, "and does not walk"
        assert_seated(device)
        walk.send_signal(signal.SIGCONT)
        _, err = walk.communicate(timeout=60)
        assert walk.returncode == 5
        assert "nobody drove the robot for 2.5 s: it sat down; torque is off" in err
        walk = device.start_walking()
        walk.kill()
        walk.wait(20)
        await_that(lambda device=device: device.truth()["base"]["pos"][2] < 0.04, "it sits")
        assert_seated(device)


def test_anybody_can_stop_a_robot(tmp_path: Path) -> None:
    for device in devices("hexapod", tmp_path):
        assert command("stop").returncode == 4, "there is none yet"
        walk = device.start_walking()
        told = time.monotonic()
        stopped = command("stop", "--json")
        assert stopped.returncode == 0, stopped.stderr
        report = json.loads(stopped.stdout)
        assert report["stop"] == "hold"
        assert [loop["heeded"] for loop in report["loops"]] == [True]
        still = between(device, told, told + 30.0)[-1]["t"]
        time.sleep(1.0)
        assert motion(between(device, still + 0.3, still + 1.0)) < 0.02
        assert device.truth()["base"]["pos"][2] > 0.08, "it holds, up"
        assert walk.poll() is None
        assert "sits down" in command("clear").stdout
        _, err = walk.communicate(timeout=60)
        assert walk.returncode == 5
        assert "told to stop, and was held in place" in err
        assert_seated(device)

        walk = device.start_walking()
        walk.send_signal(signal.SIGSTOP)  # so that it does not know yet that it is held when it is told to end
        assert command("stop").returncode == 0
        walk.send_signal(signal.SIGTERM)
        walk.send_signal(signal.SIGCONT)
        time.sleep(1.0)
        ended = time.monotonic()
        if walk.poll() is None:  # it heeded the signal first, could not sit, and waits
            walk.send_signal(signal.SIGTERM)
        _, err = walk.communicate(timeout=60)
        assert walk.returncode == 143, err
        assert "told to end; the robot is frozen in place, torque is on" in err
        registers = command(
            "servo", "read", "1", "torque_enable", "bus_watchdog", "--port", device.port.partition("=")[2], "--json")
        assert [register["raw"] for register in json.loads(registers.stdout)["registers"].values()] == [1, 0]
        assert motion(between(device, ended - 0.3, time.monotonic())) < 0.02
        assert device.truth()["base"]["pos"][2] > 0.08, "it stands, and the next one takes it over"

        walk = device.start_walking()
        assert "sits down" in command("stop", "--sit").stdout
        _, err = walk.communicate(timeout=60)
        assert walk.returncode == 5
        assert "told to stop: the robot sat down; torque is off" in err
        assert_seated(device)

        walk = device.start_walking()
        assert "has its torque off" in command("stop", "--limp").stdout
        _, err = walk.communicate(timeout=60)
        assert walk.returncode == 5
        assert "torque was switched off at once; torque is off" in err
        await_that(lambda device=device: device.truth()["base"]["pos"][2] < 0.06, "it sinks")
