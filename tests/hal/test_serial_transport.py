"""Serial lines by URL, on real pseudo-terminals and sockets."""

import os
import pty
import socket
import time
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial

from hal.serial_transport import names_hardware, open_port
from robotwalk.clock import WallClock
from robotwalk.errors import BusError

PING, STATUS = b"\xff\xff\x01\x02\x01\xfb", b"\xff\xff\x01\x02\x00\xfc"


@pytest.fixture
def line() -> Iterator[tuple[int, str]]:
    """A raw pseudo-terminal: its far end's descriptor, and the name of the near end."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    yield master, os.ttyname(slave)
    os.close(master)
    os.close(slave)


def test_bytes_go_both_ways_and_wake_the_clock(line: tuple[int, str]) -> None:
    master, name = line
    port, clock = open_port(name, 1_000_000), WallClock()
    port.write(PING)
    assert os.read(master, 100) == PING
    assert port.read() == b""
    os.write(master, STATUS)
    before = clock.now()
    clock.wait((port,), before + 5_000_000_000)
    assert clock.now() - before < 2_000_000_000
    assert port.waiting() == 6
    assert port.read() == STATUS
    port.close()


def test_an_echoing_line_is_read_without_its_echo(line: tuple[int, str]) -> None:
    master, name = line
    port = open_port(name, 1_000_000)
    port.write(PING)
    os.write(master, os.read(master, 100) + STATUS)
    time.sleep(0.05)
    assert port.read() == STATUS
    port.close()


def test_bytes_from_before_are_thrown_away(line: tuple[int, str]) -> None:
    master, name = line
    os.write(master, b"old")
    time.sleep(0.05)
    port = open_port(name, 1_000_000)
    assert port.read() == b""
    port.close()


def test_a_line_is_ours_alone_and_free_again_afterwards(line: tuple[int, str]) -> None:
    _, name = line
    port = open_port(name, 1_000_000)
    with pytest.raises(BusError, match="another program has it open"):
        open_port(name, 1_000_000)
    port.close()
    open_port(name, 1_000_000).close()


def test_a_socket_is_a_line_too() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = open_port(f"socket://127.0.0.1:{server.getsockname()[1]}", 1_000_000)
        far, _ = server.accept()
        with far:
            port.write(PING)
            assert far.recv(100) == PING
            far.sendall(STATUS)
            clock = WallClock()
            clock.wait((port,), clock.now() + 5_000_000_000)
            assert port.read() == STATUS
        port.close()


def test_a_socket_whose_far_end_has_gone_is_an_error() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = open_port(f"socket://127.0.0.1:{server.getsockname()[1]}", 1_000_000)
        server.accept()[0].close()
        time.sleep(0.05)
        with pytest.raises(BusError, match="gone"):
            port.read()
        port.close()


@pytest.mark.parametrize(("url", "reason"), [
    ("/dev/ttyNOSUCH0", "no such port; is the adapter plugged in"),
    ("socket://127.0.0.1:1", "nobody listens there"),
    ("/dev", "."),
    ("nonsense://x", "."),
])
def test_a_port_that_does_not_open_says_why(url: str, reason: str) -> None:
    with pytest.raises(BusError, match=f"cannot open {url}: .*{reason}"):
        open_port(url, 1_000_000)


def test_what_may_be_a_physical_robot(line: tuple[int, str], tmp_path: Path) -> None:
    _, name = line
    (tmp_path / "legs").symlink_to(name)
    assert not names_hardware(name)
    assert not names_hardware(str(tmp_path / "legs"))
    assert not names_hardware("socket://127.0.0.1:5000")
    assert not names_hardware("socket://localhost:5000")
    assert names_hardware("socket://192.168.1.7:5000")
    assert names_hardware("rfc2217://127.0.0.1:5000")
    assert names_hardware("/dev/tty")
    (tmp_path / "usb").symlink_to("/dev/null")
    assert names_hardware(str(tmp_path / "usb"))


def test_a_line_that_takes_no_bytes_is_an_error_and_not_a_wait(line: tuple[int, str]) -> None:
    _, name = line
    port = open_port(name, 1_000_000)

    def fill() -> None:
        for _ in range(10_000):
            port.write(bytes(1000))

    with pytest.raises(BusError, match="takes no more bytes"):
        fill()
    port.close()


def test_the_adapters_latency_is_asked_to_be_low(line: tuple[int, str], monkeypatch: pytest.MonkeyPatch) -> None:
    """No pseudo-terminal has one to set: so it is only seen that it is asked for, and that a no is no error."""
    asked: list[bool] = []

    def refuse(self: serial.Serial, low: bool) -> None:
        asked.append(low)
        raise ValueError("no")

    monkeypatch.setattr(serial.Serial, "set_low_latency_mode", refuse)
    open_port(line[1], 1_000_000).close()
    assert asked == [True]
