"""Bytes take their time."""

from sim_backend.device import Reply
from sim_backend.simulated_clock import SimulatedClock
from sim_backend.wire import SimulatedPort

BYTE = 10_000  # ns at 1 Mbaud


class Echo:
    """Answers every burst with the bytes given, `delay` ns after it."""

    def __init__(self, *replies: Reply) -> None:
        self.replies = list(replies)
        self.heard: list[tuple[bytes, int, int]] = []

    def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
        self.heard.append((data, now, baud))
        return self.replies


def test_bytes_arrive_when_the_last_one_is_through() -> None:
    clock, device = SimulatedClock(), Echo()
    port = SimulatedPort(clock, device, 1_000_000)
    port.write(b"12345")
    port.write(b"67")
    clock.wait((), 1_000_000)
    assert device.heard == [(b"12345", 5 * BYTE, 1_000_000), (b"67", 7 * BYTE, 1_000_000)]


def test_a_reply_begins_after_its_delay_and_wakes_the_host_when_it_is_whole() -> None:
    clock = SimulatedClock()
    port = SimulatedPort(clock, Echo(Reply(500_000, b"abc"), Reply(50_000, b"de")), 1_000_000)
    port.write(b"12345")
    clock.wait((port,), 10_000_000)
    assert clock.now() == 5 * BYTE + 500_000 + 3 * BYTE
    assert port.read() == b"abc"
    clock.wait((port,), 10_000_000)
    assert clock.now() == 5 * BYTE + 500_000 + 3 * BYTE + 50_000 + 2 * BYTE
    assert port.read() == b"de"
    assert port.read() == b""


def test_who_reads_in_mid_reply_gets_the_bytes_that_are_there() -> None:
    clock = SimulatedClock()
    port = SimulatedPort(clock, Echo(Reply(0, b"abcdef")), 1_000_000)
    port.write(b"1")
    clock.wait((port,), 1 * BYTE + 4 * BYTE + 100)
    assert port.waiting() == 0
    assert port.read() == b"abcd"
    clock.wait((port,), 10_000_000)
    assert clock.now() == 7 * BYTE
    assert port.read() == b"ef"
    assert port.waiting() == 0


def test_the_baud_sets_the_pace() -> None:
    clock, device = SimulatedClock(), Echo()
    SimulatedPort(clock, device, 57_600).write(b"1")
    clock.wait((), 1_000_000)
    assert device.heard == [(b"1", 173_612, 57_600)]


def test_two_wires_carry_their_bytes_at_the_same_time() -> None:
    clock = SimulatedClock()
    ports = [SimulatedPort(clock, Echo(Reply(0, bytes(100))), 1_000_000) for _ in range(2)]
    for port in ports:
        port.write(bytes(10))
    clock.wait(ports, 10_000_000)
    assert clock.now() == 110 * BYTE
    assert [len(port.read()) for port in ports] == [100, 100]
