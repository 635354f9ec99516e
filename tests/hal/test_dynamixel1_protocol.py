"""Frames of Dynamixel Protocol 1.0 against the e-Manual's examples, and what its error byte says."""

from collections.abc import Callable
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hal.dynamixel1_protocol import (
    Receiver,
    action,
    bulk_read,
    describe_error,
    group_read,
    ping,
    read,
    reg_write,
    sync_write,
    write,
)
from hal.protocol import Status

# The servo's side, written from the manual byte by byte, so that it shares nothing with the code under test.


def status_frame(servo_id: int, error: int, data: bytes) -> bytes:
    total = servo_id + len(data) + 2 + error
    for byte in data:
        total += byte
    return bytes((0xFF, 0xFF, servo_id, len(data) + 2, error, *data, 255 - total % 256))


def pieces(data: bytes, cuts: list[int]) -> list[bytes]:
    edges = [0, *sorted(cut % (len(data) + 1) for cut in cuts), len(data)]
    return [data[a:b] for a, b in pairwise(edges)]


class TestInstructions:
    @pytest.mark.parametrize(
        ("frame", "expected"),
        [
            (ping(1), "FF FF 01 02 01 FB"),
            (read(1, 43, 1), "FF FF 01 04 02 2B 01 CC"),
            (write(1, 12, b"\x64\xaa"), "FF FF 01 05 03 0C 64 AA DC"),
            (write(254, 3, b"\x01"), "FF FF FE 04 03 03 01 F6"),
            (reg_write(1, 30, b"\xf4\x01"), "FF FF 01 05 04 1E F4 01 E2"),
            (action(254), "FF FF FE 02 05 FA"),
            (
                sync_write(30, 4, [(0, b"\x10\x00\x50\x01"), (1, b"\x20\x02\x60\x03")]),
                "FF FF FE 0E 83 1E 04 00 10 00 50 01 01 20 02 60 03 67",
            ),
            (bulk_read([(1, 30, 2), (2, 36, 2)])[0], "FF FF FE 09 92 00 02 01 1E 02 02 24 1D"),
        ],
    )
    def test_equals_the_manuals_example(self, frame: bytes, expected: str) -> None:
        assert frame == bytes.fromhex(expected)

    def test_eighteen_goals_go_into_62_bytes(self) -> None:
        assert len(sync_write(30, 2, [(servo_id, bytes(2)) for servo_id in range(1, 19)])) == 62

    @pytest.mark.parametrize(
        ("make", "complaint"),
        [
            (lambda: ping(255), "a servo's id is 0 to 253, not 255"),
            (lambda: read(254, 36, 6), "no servo answers a broadcast read"),
            (lambda: read(1, 255, 2), "there is no range of 2 bytes at address 255"),
            (lambda: write(1, 0, bytes(244)), "a frame may be 250 bytes long, not 251: send less at once"),
            (
                lambda: group_read(36, 6, (1, 2), fast=False),
                "Dynamixel Protocol 1.0 has no sync read: read each servo by itself",
            ),
            (lambda: bulk_read([(1, 36, 2), (1, 30, 2)]), r"expected different ids from 0 to 253, got \[1, 1\]"),
            (lambda: bulk_read([]), r"expected different ids from 0 to 253, got \[\]"),
            (lambda: bulk_read([(1, 255, 2)]), r"there is no range of 2 bytes at each of \[255\]"),
            (lambda: bulk_read([(1, 36, 0)]), r"there is no range of 0 bytes at each of \[36\]"),
            (
                lambda: bulk_read([(i, 36, 2) for i in range(81)]),
                "80 servos fit into a frame with 244 bytes of parameters, not 81",
            ),
        ],
    )
    def test_refuses_what_cannot_be_sent(self, make: Callable[[], object], complaint: str) -> None:
        with pytest.raises(ValueError, match=f"^{complaint}$"):
            make()


class TestErrorByte:
    def test_reads_the_manuals_examples(self) -> None:
        assert Receiver().feed(bytes.fromhex("FF FF 01 02 00 FC")) == [Status(1, 0, False, b"")]
        assert Receiver().feed(bytes.fromhex("FF FF 01 03 00 20 DB")) == [Status(1, 0, False, b"\x20")]
        assert Receiver().feed(bytes.fromhex("FF FF 01 02 24 D8")) == [Status(1, 0, True, b"")]

    @pytest.mark.parametrize("error", range(0x80))
    def test_conditions_alert_and_refusals_are_errors(self, error: int) -> None:
        [status] = Receiver().feed(status_frame(7, error, b"\x05"))
        voltage, angle, heat, value, checksum, overload, instruction = (error >> bit & 1 for bit in range(7))
        assert status.alert == bool(voltage or heat or overload)
        assert status.error == 0x02 * angle + 0x08 * value + 0x10 * checksum + 0x40 * instruction
        assert (status.id, status.data) == (7, b"\x05")

    @pytest.mark.parametrize("error", [0x80, 0xFF])
    def test_bit_7_belongs_to_no_status(self, error: int) -> None:
        receiver = Receiver()
        assert receiver.feed(status_frame(7, error, b"")) == []
        assert receiver.bad_frames == 1

    @pytest.mark.parametrize(
        ("error", "words"),
        [
            (0, "no error"),
            (0x02, "the goal lies outside the angle limits"),
            (0x08, "outside the range that the servo allows"),
            (0x10, "garbled"),
            (0x40, "does not know the instruction"),
        ],
    )
    def test_each_refusal_is_told_in_words(self, error: int, words: str) -> None:
        assert words in describe_error(error)

    def test_two_refusals_at_once_are_both_told(self) -> None:
        assert describe_error(0x48) == f"{describe_error(0x08)}; {describe_error(0x40)}"

    @pytest.mark.parametrize("condition", [0x01, 0x04, 0x20, 0x80])
    def test_a_condition_is_no_error_number(self, condition: int) -> None:
        assert "does not define" in describe_error(condition)


class TestBulkRead:
    def test_answers_come_from_different_addresses(self) -> None:
        _, reply = bulk_read([(1, 30, 2), (2, 36, 2)])
        reply.feed(bytes.fromhex("FF FF 01 04 00 00 80 7A"))
        assert not reply.complete
        reply.feed(bytes.fromhex("FF FF 02 04 00 00 80 79"))
        assert reply.complete
        assert reply.results == {1: Status(1, 0, False, b"\x00\x80"), 2: Status(2, 0, False, b"\x00\x80")}

    def test_a_late_acknowledgement_is_no_answer(self) -> None:
        _, reply = bulk_read([(1, 30, 2), (2, 36, 2)])
        reply.feed(bytes.fromhex("FF FF 01 02 00 FC FF FF 02 04 00 00 80 79"))
        assert reply.results == {1: None, 2: Status(2, 0, False, b"\x00\x80")}


# Bytes rich in what headers and heads of frames are made of.
tricky = [b"\xff", b"\xff\xff", b"\xff\xff\xfe", b"\xff\xff\x01", b"\xff\xff\x01\x02\x00", b"\xff\xff\x01\x02\x00\xfc"]
noises = st.lists(st.sampled_from(tricky) | st.binary(max_size=4), max_size=12).map(b"".join)
feedback = st.tuples(st.integers(0, 253), st.integers(0, 0x7F), st.binary(min_size=6, max_size=6))
cuts = st.lists(st.integers(0, 500), max_size=8)


class TestFuzz:
    """Three properties of 1000 streams each: noise, half frames, false headers and stale bytes."""

    @settings(max_examples=1000)
    @given(st.lists(feedback, max_size=4), cuts)
    def test_every_status_is_found_however_the_stream_is_cut(
        self, sent: list[tuple[int, int, bytes]], where: list[int]
    ) -> None:
        receiver = Receiver(6)
        stream = b"".join(status_frame(*one) for one in sent)
        found = [status for piece in pieces(stream, where) for status in receiver.feed(piece)]
        assert [(status.id, status.data) for status in found] == [(servo_id, data) for servo_id, _, data in sent]
        assert receiver.bad_frames == 0

    @settings(max_examples=1000)
    @given(noises, st.integers(0, 12), feedback, feedback, cuts)
    def test_after_anything_the_next_exchange_is_heard(
        self, noise: bytes, kept: int, broken: tuple[int, int, bytes], whole: tuple[int, int, bytes], where: list[int]
    ) -> None:
        receiver = Receiver(6)
        for piece in pieces(noise + status_frame(*broken)[:kept], where):
            receiver.feed(piece)
        receiver.reset()
        [status] = receiver.feed(status_frame(*whole))
        assert (status.id, status.data) == (whole[0], whole[2])

    @settings(max_examples=1000)
    @given(feedback, st.integers(0, 11), st.integers(1, 255))
    def test_one_flipped_byte_makes_no_status_of_a_known_length(
        self, sent: tuple[int, int, bytes], position: int, flip: int
    ) -> None:
        garbled = bytearray(status_frame(*sent))
        garbled[position] ^= flip
        assert Receiver(6).feed(bytes(garbled)) == []
