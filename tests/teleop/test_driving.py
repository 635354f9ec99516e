"""Driving as people and programs do: real keys, a gamepad, a WebSocket; judged by what the body really does."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from websockets.sync.client import ClientConnection, connect

from ..device import COMMAND
from .rig import UNHURRIED, Kitty, Truth, await_that

pytestmark = pytest.mark.xdist_group("real time")

PROGRAM = """
import sys
from websockets.sync.client import connect
with connect(sys.argv[1]) as robot:
    for telemetry in robot:
        robot.send('{"type": "drive", "vx": 0.1}')
"""


@pytest.fixture
def truth(tmp_path: Path) -> Truth:
    return Truth(tmp_path / "truth.jsonl")


@pytest.mark.skipif(shutil.which("tmux") is None, reason="tmux is not installed")
def test_a_person_in_tmux(tmp_path: Path, truth: Truth) -> None:
    def tmux(*words: str) -> str:
        return subprocess.run(
            ["tmux", "-S", str(tmp_path / "tmux"), *words], capture_output=True, text=True, check=True).stdout

    def screen() -> str:
        return tmux("capture-pane", "-p")

    def hold_until(key: str, reached: Any) -> None:
        def press() -> object:
            tmux("send-keys", key)
            return reached()

        await_that(press, f"{key} does it")

    (tmp_path / "rc").write_text("PS1='$ '\n")
    tmux("-f", "/dev/null", "new-session", "-d", "-x", "80", "-y", "24", "-c", str(tmp_path),
        "bash --rcfile rc -i")
    try:
        words = " ".join(f"'{word}'" for word in COMMAND)
        tmux("send-keys", f"{words} teleop hexapod --rate 50 --truth truth.jsonl; echo code $?", "Enter")
        truth.await_standing()
        await_that(lambda: "hottest" in screen(), "the screen tells how warm the servos are")
        picture = screen()
        assert " STAND " in picture
        assert "latched keys" in picture
        assert "Esc STOP" in picture, "all of it fits"
        hold_until("i", lambda: truth.place()[0] > 0.05)
        assert " WALK " in screen()
        assert "keyboard drives" in screen()
        let_go = time.monotonic()
        truth.assert_stops(let_go)
        hold_until("BSpace", lambda: truth.place()[2] < 0.04)
        await_that(lambda: "Enter lets it stand up" in screen(), "torque is off")
        tmux("send-keys", "Enter")
        truth.await_standing()
        tmux("send-keys", "C-c")
        await_that(lambda: "code 130" in screen(), "it ends")
        assert "the robot sat down, torque is off" in screen()
        truth.assert_sits()
        assert tmux("display-message", "-p", "#{alternate_on}").strip() == "0"
        tmux("send-keys", "stty", "Enter")
        await_that(lambda: "speed 38400" in screen(), "the shell hears keys")
        assert "-icanon" not in screen(), "the terminal is as it was"
    except BaseException as error:
        error.add_note(screen())
        raise
    finally:
        tmux("kill-server")


def test_kitty_and_programs_and_a_hang_up(truth: Truth) -> None:
    kitty = Kitty()
    systemd = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    systemd.bind(str(truth.path.with_name("notify")))
    watched = {"NOTIFY_SOCKET": systemd.getsockname(), "WATCHDOG_USEC": "1000000"}
    words = [
        "--input", "keyboard", "--listen", "127.0.0.1:0", "--keys", "wasd", "--rate", "50", "--truth", str(truth.path)]
    teleop = subprocess.Popen(
        [*COMMAND, "teleop", "hexapod", *words], stdin=kitty.slave, stdout=subprocess.DEVNULL, stderr=kitty.slave,
        preexec_fn=lambda: os.login_tty(kitty.slave), env={**os.environ, **watched})
    heard: list[bytes] = []

    def hear() -> None:
        while message := systemd.recv(100):
            heard.append(message)

    listener = threading.Thread(target=hear, daemon=True)
    listener.start()
    try:
        await_that(lambda: b"ws://127.0.0.1:" in kitty.seen, "the address is on the screen")
        url = "ws://127.0.0.1:" + kitty.seen.split(b"ws://127.0.0.1:")[1].split(b" ")[0].decode()
        truth.await_standing()
        await_that(lambda: b" STAND " in kitty.seen, "it stands")
        assert b"READY=1" in heard

        kitty.key(ord("w"))
        truth.await_going()
        truth.assert_going()  # with no byte for long, for the key is held
        kitty.key(ord("w"), 3)
        truth.assert_stops(time.monotonic())

        kitty.key(ord("w"))
        truth.await_going()
        kitty.answers = False  # as if the network were gone
        truth.assert_stops(time.monotonic())
        kitty.answers = True

        with subprocess.Popen([sys.executable, "-c", PROGRAM, url]) as program:
            truth.await_going()
            with connect(url) as watcher:
                assert json.loads(watcher.recv(UNHURRIED))["type"] == "hello"
                watcher.send('{"type": "drive", "vx": -0.1}')
                assert next_of(watcher, "error")["error"] == "socket 1 drives"
                told = next_of(watcher, "telemetry")
                assert (told["state"], told["driver"]) == ("walk", "socket 1")
                program.send_signal(signal.SIGKILL)
                truth.assert_stops(time.monotonic())
                kitty.key(ord("w"))
                truth.await_going()
                watcher.send('{"type": "stop"}')
                truth.assert_stops(time.monotonic())
                assert truth.place()[2] > 0.09, "it is held in place"
                kitty.key(ord("w"), 3)
                kitty.key(27)  # another stop changes nothing
                kitty.key(13)
                await_that(lambda: truth.place()[2] < 0.04, "once that is cleared it sits")
                kitty.key(13)
                truth.await_standing()
                watcher.send('{"type": "drive", "vy": 0.5, "gait": "gallop"}')
                assert "hexapod has no gait 'gallop'" in next_of(watcher, "error")["error"]
        assert b"STOPPING=1" not in heard
        kitty.hang_up()
        assert teleop.wait(UNHURRIED) == 129
        systemd.shutdown(socket.SHUT_RD)
        listener.join()
        told = "".join({b"READY=1": "R", b"WATCHDOG=1": "W", b"STOPPING=1": "S"}[message] for message in heard)
        assert re.fullmatch("W?RWWWWWWW+SW*", told), told
        truth.assert_sits()
    except Exception as error:
        error.add_note(kitty.seen[-3000:].decode(errors="replace"))
        raise
    finally:
        teleop.kill()


def next_of(connection: ClientConnection, kind: str) -> dict[str, Any]:
    """Return the next message of that kind."""
    deadline = time.monotonic() + UNHURRIED
    while time.monotonic() < deadline:
        message = json.loads(connection.recv(UNHURRIED))
        if message["type"] == kind:
            return dict(message)
    raise AssertionError(f"no {kind}")


def test_a_gamepad_drives_while_its_deadman_button_is_held(truth: Truth) -> None:
    words = ["teleop", "hexapod", "--input", "gamepad", "--rate", "50", "--truth", str(truth.path), "--json"]
    with subprocess.Popen(
        [sys.executable, "-m", "tests.teleop.virtual_pad", *words], cwd=Path(__file__).parents[2], text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as teleop:
        pad = teleop.stdin
        assert pad is not None

        def do(line: str) -> None:
            pad.write(f"{line}\n")
            pad.flush()

        truth.await_standing()
        do("axis 1 -32767")  # the left stick ahead
        time.sleep(1.0)
        assert abs(truth.place()[0]) < 0.01, "nobody holds the button"
        do("button 10 1")
        truth.await_going()
        do("button 10 0")
        truth.assert_stops(time.monotonic())
        do("button 10 1")
        truth.await_going()
        do("unplug")
        truth.assert_stops(time.monotonic())
        teleop.terminate()
        out, err = teleop.communicate(timeout=UNHURRIED)
    assert teleop.returncode == 143, err
    assert "the robot sat down, torque is off" in err
    truth.assert_sits()
    first, last = map(json.loads, out.splitlines())
    assert first["ready"]
    assert last["pose"]["x"] > 0.05
