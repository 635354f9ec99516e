"""A stop button on a board, pressed in a walk: the robot is still, stays so, and ends as after `robotwalk stop`."""

import json
import math
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest

from robotwalk.config import library

from ..device import COMMAND, served
from .test_loop_process import await_that, command, motion, tilt

LASTS = 4.0  # s that it is pressed


def test_the_button_holds_the_robot_until_it_is_released_and_cleared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    robot, faults, truth = tmp_path / "hexapod.yaml", tmp_path / "faults.yaml", tmp_path / "truth.jsonl"
    began = time.monotonic()
    command("--version")
    pressed = 8.0 + 4.0 * (time.monotonic() - began)  # s of simulated time; by then it walks, on a slow computer, too
    # A second of patience with the board: computers that test stall.
    button = "  stop_input: {port: /dev/ttyUSB1, input: 3, stale_after_s: 1}\n"
    text = library.open_document("robots", "hexapod").text
    robot.write_text(text.replace("\nhardware:\n", f"\nhardware:\n{button}"))
    faults.write_text(f"- {{at: {pressed}, for: {LASTS}, fault: press_stop}}\n")

    def lines(begin: float, end: float) -> list[dict[str, Any]]:
        whole = [json.loads(line) for line in truth.read_text().splitlines()[:-1]]
        return [line for line in whole if begin < line["sim_t"] < end]

    with served(str(robot), "--pty", str(tmp_path), "--truth", str(truth), "--faults", str(faults)) as ports:
        lines_of = [f"--port={name}={url}" for name, url in ports.items()]
        assert sorted(ports) == ["legs", "stop"]
        walk = subprocess.Popen(
            [*COMMAND, "walk", str(robot), *lines_of, "--duration", "600", "--black-box", str(tmp_path), "--json"],
            text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        await_that(lambda: lines(pressed + 1.5, math.inf), "time passes")
        stays = command("clear").stdout
        await_that(lambda: lines(pressed + LASTS + 1.0, math.inf), "time passes")
        assert walk.poll() is None, "the command guards a robot that is held"
        assert "sits down" in command("clear").stdout
        out, err = walk.communicate(timeout=60)
        assert walk.returncode == 5, err
    told = "told to stop by the stop input (its input 3 is open)"
    assert f"stays held, for it is {told}" in stays
    assert [event["text"] for event in json.loads(out)["events"] if event["kind"] == "stop_input"] == [told]
    assert "told to stop, and was held in place" in err
    assert motion(lines(pressed - 0.5, pressed)) > 0.05, "it walked"
    held = lines(pressed + 0.5, pressed + LASTS + 0.5)
    assert motion(held) < 0.02, "still, and for longer than it is pressed"
    assert held[0]["base"]["pos"][2] > 0.08, "and up"
    end = lines(pressed, math.inf)
    assert max(map(tilt, end)) < 10.0
    assert end[-1]["base"]["pos"][2] < 0.08
