"""A stop button on a board, pressed in a walk: the robot is still, stays so, and ends as after `robotwalk stop`."""

import json
import os
import pty
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from robotwalk import assembly
from robotwalk.config import library
from robotwalk.errors import ConfigError

from ..device import COMMAND, assert_seated, devices
from ..hal.foot_switches.test_frames import framed
from .test_loop_process import await_that, between, command, motion, tilt

pytestmark = pytest.mark.xdist_group("real time")

INPUT = 3
TOLD = "told to stop by the stop input (its input 3 is open)"


class Board:
    """A board at a terminal, in the test's hands: 100 reports a second."""

    def __init__(self) -> None:
        self.pressed = False
        self._over = threading.Event()
        self._far, self._near = pty.openpty()
        self.port = os.ttyname(self._near)
        self._thread = threading.Thread(target=self._talk)
        self._thread.start()

    def _talk(self) -> None:
        while not self._over.wait(0.01):
            os.write(self._far, framed(0 if self.pressed else 1 << INPUT))

    def close(self) -> None:
        self._over.set()
        self._thread.join()
        os.close(self._far)
        os.close(self._near)


@pytest.fixture
def board() -> Iterator[Board]:
    made = Board()
    yield made
    made.close()


def fitted(folder: Path) -> str:
    """Write a hexapod with the button, and a second of patience with its board: computers that test stall."""
    text = library.open_document("robots", "hexapod").text
    button = f"  stop_input: {{port: /dev/ttyUSB1, input: {INPUT}, stale_after_s: 1}}\n"
    robot = folder / "hexapod.yaml"
    robot.write_text(text.replace("\nhardware:\n", f"\nhardware:\n{button}"))
    return str(robot)


def test_the_button_holds_the_robot_until_it_is_released_and_cleared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, board: Board
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    for device in devices(fitted(tmp_path), tmp_path):
        walk = subprocess.Popen(
            [*COMMAND, "walk", device.robot, "--port", device.port, "--port", f"stop={board.port}", "--duration", "600",
             "--black-box", str(tmp_path), "--json"], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        device.await_motion()
        time.sleep(0.5)
        pressed = time.monotonic()
        board.pressed = True
        time.sleep(1.0)
        stays = command("clear").stdout
        assert walk.poll() is None, "the command guards a robot that is held"
        board.pressed = False
        time.sleep(0.5)
        held = between(device, pressed + 0.7, time.monotonic())
        await_that(lambda: "sits down" in command("clear").stdout, "it may be cleared")
        out, err = walk.communicate(timeout=60)
        assert walk.returncode == 5, err
        assert f"stays held, for it is {TOLD}" in stays
        assert [event["text"] for event in json.loads(out)["events"] if event["kind"] == "stop_input"] == [TOLD]
        assert "told to stop, and was held in place" in err
        assert motion(between(device, pressed - 0.4, pressed)) > 0.05, "it walked"
        assert motion(held) < 0.02, "still, and longer than it is pressed"
        assert held[0]["base"]["pos"][2] > 0.08, "and up"
        assert max(map(tilt, between(device, pressed, time.monotonic()))) < 10.0
        assert_seated(device)


def test_a_fault_presses_the_button_of_a_robot_that_is_served_and_of_no_other(tmp_path: Path) -> None:
    blueprint, faults = assembly.load(fitted(tmp_path)), [{"at": 0.1, "for": 0.1, "fault": "press_stop"}]
    world = assembly.simulated_robot(blueprint, 100, 0, faults=faults, served=True)
    port, said = world.ports["stop"], []
    for tick in range(1, 31):
        world.clock.wait((), tick * 10_000_000)
        said.append(port.read())
    assert said[5] == said[25] == framed(1 << INPUT)
    assert said[15] == framed(0)
    with pytest.raises(ConfigError, match="nobody reads a button here"):
        assembly.simulated_robot(blueprint, 100, 0, faults=faults)
