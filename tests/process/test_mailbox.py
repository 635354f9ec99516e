"""Shared memory under fire: what is read is what was written, whole."""

import mmap
import multiprocessing
import os
import random
import time
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotwalk.process.mailbox import Ring, Slot, Track
from robotwalk.process.shared import Mailbox, Stop, create, running

SIZE = 4096


# Of a length and of bytes that follow from their numbers.
MESSAGES = [random.Random(number).randbytes(8 + number * 37 % 2000) for number in range(50)]


def message(number: int) -> bytes:
    return MESSAGES[number % 50]


def hammer(memory: Any, until: float) -> None:
    slot, track = Slot(memoryview(memory)[:SIZE]), Track(memoryview(memory)[SIZE:], 4)
    number = 0
    while time.monotonic() < until:
        number += 1
        slot.write(message(number))
        track.write(message(number))


def test_a_reader_beside_a_writer_that_never_rests_sees_only_whole_messages() -> None:
    memory = mmap.mmap(-1, 5 * SIZE)
    slot, track = Slot(memoryview(memory)[:SIZE]), Track(memoryview(memory)[SIZE:], 4)
    writer = multiprocessing.get_context("fork").Process(target=hammer, args=(memory, time.monotonic() + 1.0))
    writer.start()
    seen, ticks, last, tick = 0, 0, 0, 0
    while writer.is_alive():
        found, following = slot.read(), track.next(tick)
        if found is not None:
            assert found.data == message(found.number)
            assert found.number >= last, "it never goes back"
            seen, last = seen + (found.number > last), found.number
        if following is not None:
            assert following.data == message(following.number)
            assert following.number > tick
            ticks, tick = ticks + 1, following.number
    writer.join()
    assert seen > 5
    assert ticks > 5


@given(first=st.binary(max_size=64), second=st.binary(max_size=64), cut=st.integers(0, 120))
def test_a_message_half_written_is_none(first: bytes, second: bytes, cut: int) -> None:
    """A writer is stopped after any byte: that shows, or the message is the old or the new one."""
    old, new = bytearray(120), bytearray(120)
    Slot(memoryview(old)).write(first)
    new[:] = old
    Slot(memoryview(new)).write(second)
    torn = Slot(memoryview(new[:cut] + old[cut:])).read()
    assert torn is None or torn in ((1, first), (2, second))


def test_what_is_too_long_is_refused_and_the_message_before_stays() -> None:
    slot = Slot(memoryview(bytearray(64)))
    assert slot.read() is None
    slot.write(b"short")
    with pytest.raises(ValueError, match="65 bytes do not fit"):
        slot.write(bytes(65))
    assert slot.read() == (1, b"short")


def test_who_falls_behind_is_taken_to_the_newest() -> None:
    track = Track(memoryview(bytearray(4 * 64)), 4)
    assert track.next(0) is None
    for number in range(1, 4):
        track.write(b"%d" % number)
    assert [track.next(0), track.next(1), track.next(2), track.next(3)] == [(1, b"1"), (2, b"2"), (3, b"3"), None]
    for number in range(4, 10):
        track.write(b"%d" % number)
    assert track.next(1) == (9, b"9")


@given(st.lists(st.one_of(st.none(), st.binary(max_size=90)), max_size=60))
def test_a_ring_gives_back_in_order_all_that_found_room(steps: list[bytes | None]) -> None:
    ring = Ring(memoryview(bytearray(64 + 256)))
    kept: list[bytes] = []
    dropped = 0
    for step in steps:
        if step is None:
            assert ring.take() == (kept.pop(0) if kept else None)
        elif ring.put(step):
            kept.append(step)
        else:
            dropped += 1
    assert ring.dropped == dropped
    assert [ring.take() for _ in kept] == kept
    assert ring.take() is None


def test_only_loops_that_run_are_found(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    shared, path = create("hexapod")
    assert path.parent == tmp_path / "robotwalk"
    assert path.stat().st_mode & 0o777 == 0o600
    assert path.parent.stat().st_mode & 0o777 == 0o700
    (name, mailbox), = running()
    assert name.startswith("hexapod-")
    number = mailbox.post_stop(Stop.SIT)
    assert Mailbox(shared).stop_after(0) == (number, Stop.SIT)
    assert Mailbox(shared).stop_after(number) is None
    os.close(shared)
    assert list(running()) == []
    assert not path.exists(), "what a dead one left behind is cleared away"
