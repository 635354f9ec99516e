"""The parts of the server: terminals that outlive their clients, links, sockets, wall time, and the witness."""

import fcntl
import math
import os
import select
import signal
import socket
import subprocess
import sys
import termios
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import serial

from robotwalk import assembly
from robotwalk.errors import BusError, UsageError
from robotwalk.realtime import sharpen_timers
from sim_backend import real_time
from sim_backend.device_link import DeviceLink
from sim_backend.pseudo_terminal import PseudoTerminal
from sim_backend.pty_endpoint import PtyEndpoint
from sim_backend.real_time import RealTime
from sim_backend.socket_endpoint import Address, SocketEndpoint, parse_address
from sim_backend.witness import Witness

MS = 1_000_000
EVERY_BYTE = bytes(range(256))
NOBODY = 65534
# Takes the port for itself in both ways there are, says so, and waits to be killed.
GREEDY = """
import fcntl, serial, sys, termios, time
port = serial.Serial(sys.argv[1], 57600, exclusive=True)
fcntl.ioctl(port.fd, termios.TIOCEXCL)
print("open", flush=True)
time.sleep(60)
"""


@pytest.fixture
def terminal() -> Iterator[PseudoTerminal]:
    terminal = PseudoTerminal(1_000_000)
    os.chmod(terminal.path, 0o666)
    yield terminal
    terminal.close()


def readable(*descriptors: int) -> list[int]:
    return select.select(descriptors, [], [], 2.0)[0]


@contextmanager
def bare_client(path: str) -> Iterator[int]:
    """Open it as it is; pyserial would throw away what is there to be read."""
    descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY)
    yield descriptor
    os.close(descriptor)


def opens_without_privileges(path: str) -> bool:
    """Whether someone can open it who may not overrule exclusive use, as root may."""
    user = NOBODY if os.getuid() == 0 else None
    return subprocess.run(["/bin/sh", "-c", f"exec 3<>{path}"], user=user, stderr=subprocess.DEVNULL).returncode == 0


def crash_greedy_client(path: str) -> None:
    with subprocess.Popen([sys.executable, "-c", GREEDY, path], stdout=subprocess.PIPE) as client:
        assert client.stdout is not None
        assert client.stdout.readline() == b"open\n"
        assert not opens_without_privileges(path)
        client.send_signal(signal.SIGKILL)


def test_a_terminal_is_transparent_before_a_client_has_configured_it(terminal: PseudoTerminal) -> None:
    with bare_client(terminal.path) as client:
        os.write(client, EVERY_BYTE)
        assert readable(terminal.master)
        assert terminal.read() == EVERY_BYTE
        terminal.write(EVERY_BYTE)
        assert readable(client)
        assert os.read(client, 1000) == EVERY_BYTE
        assert terminal.read() == b"", "nothing is echoed"


@pytest.mark.parametrize("baud", [9_600, 57_600, 1_000_000, 4_000_000, 4_500_000, 123_456])
def test_the_baud_rate_that_a_client_sets_is_seen(terminal: PseudoTerminal, baud: int) -> None:
    assert terminal.baud == 1_000_000
    with serial.Serial(terminal.path, baud):
        assert terminal.baud == baud


def test_a_client_that_crashes_leaves_nothing_behind(terminal: PseudoTerminal) -> None:
    crash_greedy_client(terminal.path)
    terminal.write(b"a reply that nobody reads")
    assert terminal.baud == 57_600
    assert readable(terminal.departures)
    assert terminal.note_departures()
    assert terminal.baud == 1_000_000
    assert opens_without_privileges(terminal.path)
    with bare_client(terminal.path) as client:
        assert not select.select([client], [], [], 0.02)[0]
    with serial.Serial(terminal.path, 1_000_000, exclusive=True) as port:
        port.write(b"hello")
        assert readable(terminal.master)
        assert terminal.read() == b"hello"


def test_a_client_that_stays_keeps_its_settings_when_another_one_leaves(terminal: PseudoTerminal) -> None:
    with serial.Serial(terminal.path, 57_600) as first:
        serial.Serial(terminal.path, 57_600).close()
        fcntl.ioctl(first.fileno(), termios.TIOCEXCL)
        assert readable(terminal.departures)
        assert not terminal.note_departures()
        assert terminal.baud == 57_600
        assert not opens_without_privileges(terminal.path)
        terminal.write(b"still there")
        assert first.read(11) == b"still there"


def test_bytes_beyond_the_buffer_of_a_client_that_does_not_read_are_lost(terminal: PseudoTerminal) -> None:
    with serial.Serial(terminal.path, 1_000_000, timeout=0.1) as client:
        for _ in range(100):
            terminal.write(EVERY_BYTE * 16)
        kept = client.read(100 * 4096)
        assert 0 < len(kept) < 100 * 4096
        assert kept[:256] == EVERY_BYTE, "the first bytes stay, the last are lost"
        terminal.write(b"timely")
        assert client.read(6) == b"timely"


def test_a_reply_that_comes_after_its_client_has_gone_is_not_for_the_next_one(tmp_path: Path) -> None:
    endpoint = PtyEndpoint(tmp_path / "legs", 1_000_000)
    master, departures = endpoint.descriptors()
    with serial.Serial(endpoint.url, 1_000_000) as client:
        client.write(b"ask")
        assert endpoint.receive(readable(master)) == b"ask"
    assert endpoint.receive(readable(departures)) == b""
    endpoint.send(b"late")
    with bare_client(endpoint.url) as client:
        assert not select.select([client], [], [], 0.02)[0]
        os.write(client, b"ask")
        assert endpoint.receive(readable(master)) == b"ask"
        endpoint.send(b"timely")
        assert readable(client)
        assert os.read(client, 100) == b"timely"
    endpoint.close()


def test_who_writes_and_leaves_at_once_is_heard_but_the_reply_is_for_nobody(tmp_path: Path) -> None:
    endpoint = PtyEndpoint(tmp_path / "legs", 1_000_000)
    master, departures = endpoint.descriptors()
    with bare_client(endpoint.url) as client:
        os.write(client, b"ask")
    assert endpoint.receive(readable(departures)) == b""
    assert endpoint.receive(readable(master)) == b"ask"
    endpoint.send(b"answer")
    with bare_client(endpoint.url) as client:
        assert not select.select([client], [], [], 0.02)[0]
    endpoint.close()


def test_a_link_is_made_with_its_folder_and_removed_with_its_lock(tmp_path: Path) -> None:
    link = DeviceLink(tmp_path / "new" / "legs", "/dev/pts/7")
    assert (tmp_path / "new" / "legs").readlink() == Path("/dev/pts/7")
    link.remove()
    assert list((tmp_path / "new").iterdir()) == []


def test_a_stale_link_is_replaced_and_a_live_one_is_refused(tmp_path: Path) -> None:
    (tmp_path / "legs").symlink_to("/dev/pts/998")
    (tmp_path / ".legs.lock").touch()
    link = DeviceLink(tmp_path / "legs", "/dev/pts/7")
    assert (tmp_path / "legs").readlink() == Path("/dev/pts/7")
    with pytest.raises(BusError, match="legs is served by another robotwalk sim that still runs"):
        DeviceLink(tmp_path / "legs", "/dev/pts/8")
    assert (tmp_path / "legs").readlink() == Path("/dev/pts/7")
    link.remove()
    DeviceLink(tmp_path / "legs", "/dev/pts/8").remove()


@pytest.mark.parametrize("target", [None, "/dev/ttyUSB0"])
def test_what_is_no_link_to_a_terminal_is_left_alone(tmp_path: Path, target: str | None) -> None:
    path = tmp_path / "legs"
    if target:
        path.symlink_to(target)
    else:
        path.write_text("precious")
    with pytest.raises(UsageError, match="legs is in the way"):
        DeviceLink(path, "/dev/pts/7")
    assert [entry.name for entry in tmp_path.iterdir()] == ["legs"]
    assert os.readlink(path) == target if target else path.read_text() == "precious"


def test_a_link_that_someone_has_changed_is_not_removed(tmp_path: Path) -> None:
    link = DeviceLink(tmp_path / "legs", "/dev/pts/7")
    (tmp_path / "legs").unlink()
    (tmp_path / "legs").symlink_to("/dev/pts/9")
    link.remove()
    assert [entry.name for entry in tmp_path.iterdir()] == ["legs"]


def test_a_socket_serves_one_client_after_the_other() -> None:
    endpoint = SocketEndpoint(Address("127.0.0.1", 0), 1_000_000)
    address = ("127.0.0.1", int(endpoint.url.rpartition(":")[2]))
    assert endpoint.url.startswith("socket://127.0.0.1:")
    first = socket.create_connection(address)
    assert endpoint.receive(readable(*endpoint.descriptors())) == b""
    first.sendall(b"ask")
    assert endpoint.receive(readable(endpoint.descriptors()[1])) == b"ask"
    endpoint.send(b"answer")
    assert first.recv(10) == b"answer"

    second = socket.create_connection(address)
    endpoint.receive(readable(endpoint.descriptors()[0]))
    assert second.recv(10) == b"", "turned away"

    first.sendall(b"last words")
    first.close()
    third = socket.create_connection(address)
    assert endpoint.receive(readable(*endpoint.descriptors())) == b"last words"
    third.sendall(b"next")
    assert endpoint.receive(readable(endpoint.descriptors()[1])) == b"next"
    for one in (second, third):
        one.close()
    endpoint.close()


@pytest.mark.parametrize(("text", "address"), [
    ("127.0.0.1:6000", ("127.0.0.1", 6000)),
    ("localhost:0", ("localhost", 0)),
    ("[::1]:6000", ("::1", 6000)),
])
def test_addresses_of_this_computer(text: str, address: tuple[str, int]) -> None:
    assert parse_address(text) == address


@pytest.mark.parametrize("text", ["0.0.0.0:6000", "192.168.1.2:6000", "[::]:6000", "example.org:6000", ":6000"])
def test_other_hosts_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match="this computer alone"):
        parse_address(text)


@pytest.mark.parametrize("text", ["127.0.0.1", "6000", "localhost:port", "localhost:70000", "localhost:-1"])
def test_what_is_no_address_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="should be HOST:PORT"):
        parse_address(text)


def test_a_short_stall_is_caught_up_and_a_long_one_is_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 1_000 * MS
    monkeypatch.setattr(real_time.time, "monotonic_ns", lambda: now)
    pace = RealTime(100 * MS)
    assert pace.wall(100 * MS) == 1_000 * MS
    now += 50 * MS
    assert (pace.target(100 * MS), pace.dropped) == (150 * MS, 0)
    now += 3_000 * MS
    assert (pace.target(150 * MS), pace.dropped) == (200 * MS, 2_950 * MS)
    assert pace.wall(200 * MS) == now
    now += 2 * MS
    assert (pace.target(200 * MS), pace.dropped) == (202 * MS, 2_950 * MS)


def test_time_never_goes_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(real_time.time, "monotonic_ns", lambda: 1_000 * MS)
    pace = RealTime(100 * MS)
    assert pace.target(101 * MS) == 101 * MS


def test_sharp_timers_end_a_sleep_on_time() -> None:
    sharpen_timers()
    late = []
    for _ in range(100):
        began = time.monotonic_ns()
        select.select([], [], [], 0.001)
        late.append(time.monotonic_ns() - began - MS)
    assert min(late) < 45_000


def test_the_witness_measures_a_walk_and_sees_no_fall_in_sitting_down() -> None:
    simulation = assembly.simulate("hexapod")
    witness = Witness(simulation.world.world)
    simulation.world.observers.append(witness.watch)
    with simulation.robot as robot:
        robot.stand()
        robot.walk(vx=0.08, wz=0.3, seconds=2.0)
        end = simulation.world.truth().base
    # An arc of 0.16 m; the straight way to its end is shorter.
    assert witness.distance == pytest.approx(0.16, rel=0.1)
    assert end.yaw == pytest.approx(0.6, abs=0.1)
    assert not witness.fell


def test_distance_is_counted_along_the_body_s_own_x() -> None:
    robot = assembly.simulated_robot(assembly.load("hexapod"), 100, 0)
    qpos = robot.world.data.qpos
    qpos[3:7] = [math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]  # faces left
    witness = Witness(robot.world)
    qpos[:2] = [0.5, 0.3]
    witness.watch()
    assert witness.distance == pytest.approx(0.3)
    qpos[1] = 0.1
    witness.watch()
    assert witness.distance == pytest.approx(0.1)


@pytest.mark.parametrize(("height", "fell"), [(0.002, False), (0.015, True)])
def test_the_base_that_strikes_the_ground_hard_has_fallen(height: float, fell: bool) -> None:
    # A drop of 2 mm ends at 0.2 m/s, one of 15 mm at 0.54 m/s.
    robot = assembly.simulated_robot(assembly.load("hexapod"), 100, 0)
    data = robot.world.data
    data.qpos[2] += height
    data.qpos[7:] = 0.0  # its legs in the air, stretched out
    witness = Witness(robot.world)
    robot.observers.append(witness.watch)
    robot.clock.wait((), 100 * MS)
    assert data.qpos[2] < 0.03
    assert witness.fell is fell


@pytest.mark.parametrize(("degrees", "fell"), [(40.0, False), (50.0, True)])
def test_tilting_over_45_degrees_is_a_fall(degrees: float, fell: bool) -> None:
    robot = assembly.simulated_robot(assembly.load("hexapod"), 100, 0)
    half = math.radians(0.5 * degrees)
    witness = Witness(robot.world)
    robot.world.data.qpos[3:7] = [math.cos(half), 0.0, math.sin(half), 0.0]
    witness.watch()
    assert witness.fell is fell
