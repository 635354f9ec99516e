"""When a host gets bytes: made-up times, 1 Mbaud, so 10 us a byte."""

import pytest

from sim_backend.adapter import ADAPTERS, Adapter, AdapterName, Burst
from sim_backend.device import Reply
from sim_backend.simulated_clock import SimulatedClock
from sim_backend.wire import SimulatedPort

US = 1_000
MS = 1_000_000
BAUD = 1_000_000


def hand_overs(adapter: Adapter, *bursts: tuple[int, int]) -> list[tuple[float, int]]:
    """Return (us, bytes) of each hand-over to a host that waits, of bursts given as (us of their begin, bytes)."""
    for begins, size in bursts:
        adapter.expect(Burst(begins * US, BAUD, bytes(size)))
    seen = []
    while (due := adapter.due()) is not None:
        seen.append((due / US, len(adapter.collect(due))))
    return seen


@pytest.mark.parametrize(("name", "expected"), [
    ("none", [(240, 14), (400, 14)]),
    ("uart-echo", [(240, 14), (400, 14)]),
    ("ftdi16", [(16_110, 28)]),
    ("ftdi1", [(1_110, 28)]),
    ("cdc", [(1_000, 28)]),
])
def test_two_short_replies(name: AdapterName, expected: list[tuple[float, int]]) -> None:
    assert hand_overs(ADAPTERS[name](), (100, 14), (260, 14)) == expected


@pytest.mark.parametrize(("name", "expected"), [
    ("none", [(2_600, 260)]),
    # Four full packets while the bytes still come, then the timer from the first byte of the rest.
    ("ftdi16", [(620, 62), (1_240, 62), (1_860, 62), (2_480, 62), (2_490 + 16_000, 12)]),
    ("ftdi1", [(620, 62), (1_240, 62), (1_860, 62), (2_480, 62), (3_490, 12)]),
    ("cdc", [(1_000, 100), (2_000, 100), (3_000, 60)]),
])
def test_a_long_reply(name: AdapterName, expected: list[tuple[float, int]]) -> None:
    assert hand_overs(ADAPTERS[name](), (0, 260)) == expected


def test_a_packet_that_fills_up_goes_before_its_timer_is_over() -> None:
    assert hand_overs(ADAPTERS["ftdi16"](), (0, 40), (5_000, 30)) == [(5_220, 62), (21_230, 8)]


def test_a_byte_that_arrives_as_a_frame_begins_goes_with_it() -> None:
    assert hand_overs(ADAPTERS["cdc"](), (990, 2)) == [(1_000, 1), (2_000, 1)]


def test_a_buffering_adapter_keeps_its_bytes_from_a_host_that_looks_early() -> None:
    adapter = ADAPTERS["ftdi16"]()
    adapter.expect(Burst(0, BAUD, b"abc"))
    assert adapter.collect(16_009 * US) == b""
    assert adapter.collect(16_010 * US) == b"abc"


class Parrot:
    """Answers every instruction with the same bytes."""

    def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
        return [Reply(50 * US, b"reply")]


def heard(name: AdapterName, writes: int = 1) -> list[tuple[float, bytes]]:
    """Return (us, bytes) of what a waiting host reads after it has sent `ask` so many times at once."""
    clock = SimulatedClock()
    port = SimulatedPort(clock, Parrot(), BAUD, ADAPTERS[name]())
    for _ in range(writes):
        port.write(b"ask")
    seen = []
    while clock.now() < 100 * MS:
        clock.wait((port,), 100 * MS)
        if port.waiting():
            seen.append((clock.now() / US, port.read()))
    return seen


@pytest.mark.parametrize(("name", "expected"), [
    ("none", [(130, b"reply")]),
    ("ftdi16", [(16_090, b"reply")]),
    ("ftdi1", [(1_090, b"reply")]),
    ("cdc", [(1_000, b"reply")]),
    ("uart-echo", [(30, b"ask"), (130, b"reply")]),
])
def test_an_exchange(name: AdapterName, expected: list[tuple[float, bytes]]) -> None:
    assert heard(name) == expected


def test_replies_never_share_the_wire() -> None:
    assert heard("none", writes=3) == [(130, b"reply"), (180, b"reply"), (230, b"reply")]


def test_each_exchange_keeps_the_baud_rate_at_which_it_began() -> None:
    clock = SimulatedClock()
    port = SimulatedPort(clock, Parrot(), BAUD)
    port.write(b"ask")
    port.baud = 57_600
    clock.wait((port,), 100 * MS)
    assert clock.now() == 130 * US
    assert port.read() == b"reply"
    port.write(b"ask")
    clock.wait((port,), 100 * MS)
    # 8 bytes of 173.6 us and the pause.
    assert (clock.now() / US - 130) == pytest.approx(8 * 173.611 + 50, abs=0.01)
