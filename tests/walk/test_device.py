"""Walking a robot in another process, over a pseudo-terminal, in real time; judged by what its body really does."""

import json
import os
import pty
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from ..device import COMMAND, Device, assert_seated, devices, loop_of

pytestmark = pytest.mark.xdist_group("real time")


@pytest.fixture(params=["hexapod", "quadruped"])
def device(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Device]:
    yield from devices(request.param, tmp_path)


@pytest.fixture
def hexapod(tmp_path: Path) -> Iterator[Device]:
    yield from devices("hexapod", tmp_path)


def test_it_walks_the_device(device: Device) -> None:
    done = device.walk("--speed", "0.08", "--duration", "5", "--json")
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["backend"] == "bus"
    assert report["max_tilt_deg"] is None
    assert report["energy_j"] is None
    truth = device.truth()
    assert not truth["fell"]
    assert truth["distance_m"] > 0.3
    assert report["distance_m"] == pytest.approx(truth["distance_m"], rel=0.25)
    assert_seated(device)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_killed_walk_sits_first_and_leaves_the_port_free(hexapod: Device, number: int, code: int) -> None:
    walk = hexapod.start_walking()
    walk.send_signal(number)
    _, err = walk.communicate(timeout=60)
    assert walk.returncode == code, err
    assert "the robot sat down, torque is off" in err
    assert_seated(hexapod)
    ping = subprocess.run(
        [*COMMAND, "servo", "ping", "1", "--port", hexapod.port.partition("=")[2]], capture_output=True, check=False)
    assert ping.returncode == 0, "and the next one may have it"


def test_a_closed_terminal_seats_the_robot(hexapod: Device) -> None:
    child, terminal = pty.fork()
    if child == 0:
        os.execv(COMMAND[0], [*COMMAND, "walk", "hexapod", "--port", hexapod.port, "--duration", "600"])
    hexapod.await_motion()
    os.close(terminal)
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 129
    assert_seated(hexapod)


def register(device: Device, number: int, name: str) -> int:
    done = subprocess.run(
        [*COMMAND, "servo", "read", str(number), name, "--port", device.port.partition("=")[2], "--json"],
        capture_output=True, text=True, check=True)
    return int(json.loads(done.stdout)["registers"][name]["raw"])


def test_a_walk_of_which_all_is_killed_in_mid_stride_leaves_a_robot_that_holds(hexapod: Device) -> None:
    """Nobody can seat it any more. Its servos hear nothing, stop where they are, keep their torque, refuse goals."""
    walk = hexapod.start_walking()
    loop = loop_of(walk)
    walk.send_signal(signal.SIGSTOP)  # or it would save the robot
    os.kill(loop, signal.SIGKILL)
    walk.kill()
    killed = time.monotonic()
    walk.wait(20)
    time.sleep(1.5)
    lines = [json.loads(line) for line in hexapod.truth_file.read_text().splitlines()[:-1]]
    within = killed + 0.2 + 0.3  # the watchdog's time, and the leeway of a busy machine
    still = [line["joints"] for line in lines if line["t"] > within]
    moving = [line["joints"] for line in lines if killed - 0.5 < line["t"] < killed]
    assert len(still) > 20
    assert max(abs(a - b) for a, b in zip(moving[0].values(), moving[-1].values(), strict=True)) > 0.05
    assert max(abs(each[joint] - still[0][joint]) for each in still for joint in each) < 0.02
    truth = hexapod.truth()
    assert not truth["fell"]
    assert truth["base"]["pos"][2] > 0.08, "it stands"
    for number in (1, 9, 18):
        assert register(hexapod, number, "bus_watchdog") == 0xFF
        assert register(hexapod, number, "torque_enable") == 1
    # The next one takes it over as it stands, and walks on.
    done = hexapod.walk("--speed", "0.08", "--duration", "3", "--json")
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert "it heard nothing any more" in str([event["text"] for event in report["events"] if event["kind"] == "audit"])
    assert_seated(hexapod)


def test_a_slow_adapter_is_told_with_the_rate_at_which_it_can_walk(tmp_path: Path) -> None:
    for device in devices("hexapod", tmp_path, "--adapter", "ftdi16"):
        refused = device.walk("--duration", "1")
        assert refused.returncode == 4
        assert "latency_timer" in refused.stderr
        rate = int(refused.stderr.rsplit("--rate ", 1)[1].split()[0])
        assert 25 <= rate <= 52
        walked = device.walk("--speed", "0.05", "--duration", "3", "--rate", str(rate - 10), "--json")
        assert walked.returncode == 0, walked.stderr
        assert device.truth()["distance_m"] > 0.08


def test_the_first_motion_on_a_stand_is_weak(hexapod: Device) -> None:
    done = hexapod.walk("--hang", "--speed", "0.03", "--duration", "1", "--json")
    # On the ground a third of the torque may not do; in any case the robot ends seated, torque off.
    assert done.returncode in (0, 5), done.stderr
    assert_seated(hexapod)


def test_a_stuck_far_end_ends_in_a_safety_stop_that_makes_no_claim(tmp_path: Path) -> None:
    """The process behind the port is stopped, as a wedged adapter is: nothing is read, nothing answered."""
    truth = tmp_path / "truth.jsonl"
    sim = subprocess.Popen(
        [*COMMAND, "sim", "hexapod", "--pty", str(tmp_path), "--truth", str(truth)], stdout=subprocess.PIPE, text=True)
    try:
        assert sim.stdout is not None
        sim.stdout.readline()
        walk = Device("hexapod", f"legs={tmp_path / 'legs'}", truth).start_walking()
        sim.send_signal(signal.SIGSTOP)
        _, err = walk.communicate(timeout=60)
        assert walk.returncode == 5
        assert "has not answered" in err
        assert "torque may still be on" in err
    finally:
        sim.send_signal(signal.SIGCONT)
        sim.terminate()
        sim.wait(20)


def test_a_port_that_dies_under_the_walk_is_a_safety_stop_with_a_report(tmp_path: Path) -> None:
    truth = tmp_path / "truth.jsonl"
    sim = subprocess.Popen(
        [*COMMAND, "sim", "hexapod", "--pty", str(tmp_path), "--truth", str(truth)], stdout=subprocess.PIPE, text=True)
    assert sim.stdout is not None
    sim.stdout.readline()
    device = Device("hexapod", f"legs={tmp_path / 'legs'}", truth)
    walk = subprocess.Popen(
        [*COMMAND, "walk", "hexapod", "--port", device.port, "--duration", "600", "--json"], text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    device.await_motion()
    sim.kill()
    sim.wait(20)
    out, err = walk.communicate(timeout=60)
    assert walk.returncode == 5
    assert "torque may still be on" in err
    report = json.loads(out)
    assert report["distance_m"] > 0.0
    assert "torque" in [event["kind"] for event in report["events"]]
