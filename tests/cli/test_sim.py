"""`robotwalk sim` as clients meet it: another process behind a serial port or a socket, in real time."""

import itertools
import json
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import serial
from dynamixel_sdk import COMM_RX_TIMEOUT, COMM_SUCCESS, GroupSyncRead, PacketHandler, PortHandler

from .conftest import COMMAND, Run

pytestmark = pytest.mark.xdist_group("sim")

ALL = range(1, 19)
TORQUE_ENABLE, GOAL_POSITION, PRESENT_CURRENT, PRESENT_POSITION = 64, 116, 126, 132
PROTOCOL = PacketHandler(2.0)
# The frames of the e-Manual, Protocol 2.0.
PING = bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E")
PING_STATUS = bytes.fromhex("FF FF FD 00 01 07 00 55 00 24 04")  # of model 1060; then firmware and CRC
UNHURRIED = 5.0  # s; on a shared machine an answer may take that long
SILENCE = 0.3  # s


class Device(NamedTuple):
    """A running `robotwalk sim`."""

    process: "subprocess.Popen[str]"
    urls: dict[str, str]

    def end(self, number: int = signal.SIGTERM) -> int:
        """Send a signal; return the exit code."""
        self.process.send_signal(number)
        return self.process.wait(10.0)


@contextmanager
def serving(*words: str) -> Iterator[Device]:
    with subprocess.Popen([*COMMAND, "sim", "hexapod", *words], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = json.loads(process.stdout.readline())
        assert set(line) == {"ready", "buses"}
        assert line["ready"] is True
        try:
            yield Device(process, line["buses"])
        finally:
            process.terminate()
            assert process.stdout.read() == "", "one line and no more"


def open_serial(path: str, baud: int = 1_000_000, timeout: float = UNHURRIED, **options: Any) -> serial.Serial:
    return serial.serial_for_url(path, baud, timeout=timeout, **options)


def assert_answers_ping(port: serial.Serial) -> None:
    port.write(PING)
    assert port.read(14)[:11] == PING_STATUS


@contextmanager
def sdk(path: str) -> Iterator[PortHandler]:
    port = PortHandler(path)
    assert port.setBaudRate(1_000_000)
    with pytest.MonkeyPatch.context() as patch:
        # It waits 34 ms for an answer, which a shared machine may steal: let it wait 0.4 s.
        patch.setattr("dynamixel_sdk.port_handler.LATENCY_TIMER", 200)
        yield port
    port.closePort()


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("sim")


@pytest.fixture(scope="module")
def legs(place: Path) -> Iterator[str]:
    """A device that all tests of this module share, and its truth in `place`."""
    with serving("--pty", str(place / "dev"), "--truth", str(place / "truth")) as device:
        assert device.urls == {"legs": str(place / "dev" / "legs")}
        yield device.urls["legs"]


def truth(place: Path) -> list[dict[str, Any]]:
    """Return all whole lines so far."""
    text = (place / "truth").read_text()
    return [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]


def test_the_sdk_pings_reads_and_writes(legs: str) -> None:
    with sdk(legs) as port:
        assert PROTOCOL.ping(port, 1) == (1060, COMM_SUCCESS, 0)
        assert PROTOCOL.ping(port, 19)[1] == COMM_RX_TIMEOUT
        assert PROTOCOL.write2ByteTxRx(port, 5, 84, 640) == (COMM_SUCCESS, 0)
        assert PROTOCOL.read2ByteTxRx(port, 5, 84) == (640, COMM_SUCCESS, 0)
        found, result = PROTOCOL.broadcastPing(port)
        assert (sorted(found), result) == (list(ALL), COMM_SUCCESS)


@pytest.mark.parametrize("way", ["txRxPacket", "fastSyncRead"])
def test_the_sdk_reads_all_servos_at_once(legs: str, way: str) -> None:
    with sdk(legs) as port:
        group = GroupSyncRead(port, PROTOCOL, PRESENT_CURRENT, 10)
        for servo in ALL:
            group.addParam(servo)
        assert getattr(group, way)() == COMM_SUCCESS
        coxas = [group.getData(servo, PRESENT_POSITION, 4) for servo in (1, 4, 7, 10, 13, 16)]
        assert coxas == pytest.approx([2048] * 6, abs=100)


def test_return_delay_and_baud_are_as_the_interface_says(legs: str) -> None:
    with sdk(legs) as port:
        assert PROTOCOL.read1ByteTxRx(port, 1, 9) == (0, COMM_SUCCESS, 0)
        assert PROTOCOL.read1ByteTxRx(port, 1, 8) == (3, COMM_SUCCESS, 0)


def test_a_joint_moves_to_its_goal_and_the_truth_says_so(legs: str, place: Path) -> None:
    before = truth(place)[-1]
    assert before["joints"]["rm_coxa"] == pytest.approx(0.0, abs=0.1)
    with sdk(legs) as port:
        assert PROTOCOL.write1ByteTxRx(port, 13, TORQUE_ENABLE, 1) == (COMM_SUCCESS, 0)
        assert PROTOCOL.write4ByteTxRx(port, 13, GOAL_POSITION, 2300) == (COMM_SUCCESS, 0)
        time.sleep(1.0)
        position, result, _ = PROTOCOL.read4ByteTxRx(port, 13, PRESENT_POSITION)
        PROTOCOL.write1ByteTxRx(port, 13, TORQUE_ENABLE, 0)
    assert result == COMM_SUCCESS
    assert position == pytest.approx(2300, abs=40)
    # 252 ticks of 2 pi / 4096.
    assert truth(place)[-1]["joints"]["rm_coxa"] == pytest.approx(0.387, abs=0.06)


def test_the_truth_has_its_fields_and_its_rate(legs: str, place: Path) -> None:
    time.sleep(0.5)
    lines, now = truth(place)[-20:], time.monotonic()
    for line in lines:
        assert set(line) == {"t", "sim_t", "base", "joints", "contacts", "distance_m", "fell", "dropped_s"}
        assert set(line["base"]) == {"pos", "quat_wxyz"}
        assert list(line["contacts"]) == ["lf", "lm", "lr", "rf", "rm", "rr"]
        assert len(line["joints"]) == 18
        assert line["fell"] is False
    last = lines[-1]
    assert last["base"]["pos"] == pytest.approx([0.0, 0.0, 0.025], abs=0.005)
    assert last["base"]["quat_wxyz"] == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=0.01)
    assert last["distance_m"] == pytest.approx(0.0, abs=0.005)
    assert [b["sim_t"] - a["sim_t"] for a, b in itertools.pairwise(lines)] == pytest.approx([0.02] * 19)
    wall = lines[-1]["t"] - lines[0]["t"] - (lines[-1]["dropped_s"] - lines[0]["dropped_s"])
    assert wall == pytest.approx(0.38, abs=1e-5)
    assert now - 2.0 < last["t"] <= now


def test_an_exchange_takes_the_time_of_the_wire(legs: str) -> None:
    with sdk(legs) as port:
        group = GroupSyncRead(port, PROTOCOL, PRESENT_CURRENT, 10)
        for servo in ALL:
            group.addParam(servo)
        spent = []
        for _ in range(30):
            began = time.monotonic()
            assert group.fastSyncRead() == COMM_SUCCESS
            spent.append(time.monotonic() - began)
    # 32 bytes there and 260 back, 10 us each.
    assert min(spent) >= 2.92e-3
    assert statistics.median(spent) < 50e-3


@pytest.mark.parametrize("baud", [57_600, 4_000_000, 1_234_567])
def test_servos_are_deaf_to_another_baud_rate(legs: str, baud: int) -> None:
    with open_serial(legs, baud, timeout=SILENCE) as port:
        port.write(PING)
        assert port.read(14) == b""
        port.baudrate = 1_000_000
        port.timeout = UNHURRIED
        assert_answers_ping(port)


@pytest.mark.parametrize(("baud", "index"), [(57_600, 1), (4_000_000, 6)])
def test_a_servo_set_to_another_baud_rate_is_found_there_and_nowhere_else(legs: str, baud: int, index: int) -> None:
    with sdk(legs) as port:
        assert PROTOCOL.write1ByteTxRx(port, 18, 8, index) == (COMM_SUCCESS, 0)
        assert PROTOCOL.ping(port, 18)[1] == COMM_RX_TIMEOUT
        assert port.setBaudRate(baud)
        assert PROTOCOL.ping(port, 18) == (1060, COMM_SUCCESS, 0)
        assert PROTOCOL.ping(port, 17)[1] == COMM_RX_TIMEOUT
        assert PROTOCOL.write1ByteTxRx(port, 18, 8, 3) == (COMM_SUCCESS, 0)
        assert port.setBaudRate(1_000_000)
        assert PROTOCOL.ping(port, 18) == (1060, COMM_SUCCESS, 0)


def test_slow_bytes_take_their_time(legs: str) -> None:
    with sdk(legs) as port:
        assert PROTOCOL.write1ByteTxRx(port, 18, 8, 0) == (COMM_SUCCESS, 0)
        assert port.setBaudRate(9_600)
        began = time.monotonic()
        assert PROTOCOL.write1ByteTxRx(port, 18, 8, 3) == (COMM_SUCCESS, 0)
        # 13 bytes there and 11 back, 1.04 ms each.
        assert time.monotonic() - began >= 24 * 1.0416e-3


def test_a_client_killed_in_mid_exchange_does_no_harm_to_the_next(legs: str) -> None:
    for _ in range(3):
        script = (
            "import serial, sys, time\n"
            "port = serial.Serial(sys.argv[1], 9600, exclusive=True)\n"
            f"port.baudrate = 1000000; port.write({PING * 5!r}); port.write({PING[:6]!r})\n"
            "print('sent', flush=True)\n"
            "time.sleep(60)\n")
        with subprocess.Popen([sys.executable, "-c", script, legs], stdout=subprocess.PIPE) as client:
            assert client.stdout is not None
            assert client.stdout.readline() == b"sent\n"
            client.kill()
        time.sleep(0.05)
        with open_serial(legs, exclusive=True) as port:
            assert_answers_ping(port)


def test_a_client_may_close_and_open_at_once(legs: str) -> None:
    for _ in range(20):
        with open_serial(legs) as port:
            assert_answers_ping(port)


def test_a_second_server_is_refused_and_the_first_goes_on(legs: str, place: Path, robotwalk: Run) -> None:
    result = robotwalk("sim", "hexapod", "--pty", str(place / "dev"))
    assert result.code == 4
    assert result.out == ""
    assert "legs is served by another robotwalk sim" in result.err
    with open_serial(legs) as port:
        assert_answers_ping(port)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130), (signal.SIGHUP, 129)])
def test_a_signal_ends_it_and_nothing_is_left(tmp_path: Path, number: int, code: int) -> None:
    with serving("--pty", str(tmp_path / "dev")) as device, open_serial(device.urls["legs"]) as port:
        assert_answers_ping(port)
        assert device.end(number) == code
    assert list((tmp_path / "dev").iterdir()) == []


def test_what_a_killed_server_left_is_replaced(tmp_path: Path) -> None:
    with serving("--pty", str(tmp_path)) as device:
        device.end(signal.SIGKILL)
    assert (tmp_path / "legs").is_symlink()
    with serving("--pty", str(tmp_path)) as device, open_serial(device.urls["legs"]) as port:
        assert_answers_ping(port)


def test_it_ends_by_itself_after_its_duration(tmp_path: Path, robotwalk: Run) -> None:
    began = time.monotonic()
    result = robotwalk("sim", "hexapod", "--pty", "dev", "--duration", "0.5", "--truth", "truth")
    assert result.code == 0
    assert result.json == {"ready": True, "buses": {"legs": "dev/legs"}}
    assert time.monotonic() - began > 0.5
    assert list((tmp_path / "dev").iterdir()) == []
    assert 10 <= len((tmp_path / "truth").read_text().splitlines()) <= 28


def test_time_lost_in_a_long_stall_is_dropped_and_said(tmp_path: Path) -> None:
    words = [*COMMAND, "sim", "hexapod", "--pty", str(tmp_path), "--truth", str(tmp_path / "truth")]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        for _ in range(2):
            process.send_signal(signal.SIGSTOP)
            time.sleep(0.4)
            process.send_signal(signal.SIGCONT)
            time.sleep(0.1)
        with open_serial(str(tmp_path / "legs")) as port:
            assert_answers_ping(port)
        process.terminate()
        assert process.stderr.read().count("simulated time was dropped") == 1
    first, *_, last = truth(tmp_path)
    assert last["dropped_s"] >= 0.7
    assert last["t"] - first["t"] == pytest.approx(last["sim_t"] - first["sim_t"] + last["dropped_s"], abs=1e-5)


def test_sockets_instead_of_terminals() -> None:
    with serving("--tcp", "127.0.0.1:0") as device:
        url = device.urls["legs"]
        assert url.startswith("socket://127.0.0.1:")
        for _ in range(2):
            with open_serial(url) as port:
                assert_answers_ping(port)
        assert device.end() == 143


def test_a_latency_timer_holds_back_every_short_reply(tmp_path: Path) -> None:
    with serving("--pty", str(tmp_path), "--adapter", "ftdi16") as device, open_serial(device.urls["legs"]) as port:
        for _ in range(5):
            began = time.monotonic()
            assert_answers_ping(port)
            assert time.monotonic() - began >= 16.1e-3


def test_a_bare_uart_hears_itself_first(tmp_path: Path) -> None:
    with serving("--pty", str(tmp_path), "--adapter", "uart-echo") as device, open_serial(device.urls["legs"]) as port:
        port.write(PING)
        heard = port.read(24)
        assert heard[:10] == PING
        assert heard[10:21] == PING_STATUS


@pytest.mark.parametrize(("words", "sentence"), [
    ((), "either --pty DIR or --tcp HOST:PORT"),
    (("--pty", "dev", "--tcp", "localhost:0"), "either --pty DIR or --tcp HOST:PORT"),
    (("--tcp", "0.0.0.0:7000"), "this computer alone"),
    (("--pty", "dev", "--duration", "0"), "--duration"),
    (("--pty", "dev", "--adapter", "usb"), "ftdi16"),
    (("--pty", "dev", "--truth", "no/such/folder"), "cannot write"),
    (("--pty", "/proc/dev"), "cannot make"),
])
def test_wrong_usage(robotwalk: Run, tmp_path: Path, words: tuple[str, ...], sentence: str) -> None:
    result = robotwalk("sim", "hexapod", *words)
    assert result.code == 2
    assert result.out == ""
    assert sentence in result.err
    assert not list(tmp_path.glob("dev/*"))
