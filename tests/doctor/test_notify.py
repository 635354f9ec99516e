"""What systemd hears, at a socket that is bound here in its place. A whole session: tests/teleop/test_driving.py."""

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from robotwalk.doctor.notify import Notify


@pytest.fixture(params=["path", "abstract"])
def systemd(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[socket.socket, dict[str, str]]]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as heard:
        name = str(tmp_path / "notify") if request.param == "path" else f"@robotwalk-test-{os.getpid()}"
        heard.bind(name.replace("@", "\0"))
        heard.setblocking(False)
        yield heard, {"NOTIFY_SOCKET": name, "WATCHDOG_USEC": "30000000", "HOME": "/"}


def received(heard: socket.socket) -> list[bytes]:
    messages = []
    while True:
        try:
            messages.append(heard.recv(100))
        except BlockingIOError:
            return messages


def test_it_is_told_of_start_life_at_half_of_its_patience_and_end(
    systemd: tuple[socket.socket, dict[str, str]]
) -> None:
    heard, environment = systemd
    notify = Notify(environment)
    assert environment == {"HOME": "/"}, "what this process starts does not hear of it"
    notify.ready()
    for tenth in range(10_000, 10_451):
        notify.alive(tenth / 10)
    notify.stopping()
    assert received(heard) == [b"READY=1", *[b"WATCHDOG=1"] * 4, b"STOPPING=1"]
    heard.close()
    notify.stopping()  # it is gone: no harm
    notify.close()


def test_a_watchdog_for_another_process_gets_nothing(systemd: tuple[socket.socket, dict[str, str]]) -> None:
    heard, environment = systemd
    Notify(environment | {"WATCHDOG_PID": "1"}).alive(0.0)
    Notify({"WATCHDOG_USEC": "1000"}).alive(0.0)
    assert received(heard) == []
    Notify(environment | {"WATCHDOG_PID": str(os.getpid())}).alive(0.0)
    assert received(heard) == [b"WATCHDOG=1"]
