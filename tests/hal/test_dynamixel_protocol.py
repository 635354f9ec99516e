"""Frames against the e-Manual's examples, and the receivers against everything that a wire can do to them."""

from collections.abc import Callable
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.dynamixel_frames import Receiver
from hal.dynamixel_protocol import (
    ErrorNumber,
    Keep,
    action,
    bulk_read,
    bulk_write,
    clear,
    describe_error,
    factory_reset,
    fast_sync_read,
    ping,
    read,
    reboot,
    reg_write,
    restore_backup,
    store_backup,
    sync_read,
    sync_write,
    write,
)
from hal.joint_reply import JointReply
from hal.protocol import Status

# From the e-Manual's pages on Ping, Read, Write and Fast Sync Read.
PING_STATUS = bytes.fromhex("FF FF FD 00 01 07 00 55 00 06 04 26 65 5D")
SECOND_PING_STATUS = bytes.fromhex("FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D")
POSITION_STATUS = bytes.fromhex("FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0")
EMPTY_STATUS = bytes.fromhex("FF FF FD 00 01 04 00 55 00 A1 0C")
FAST_REPLY = bytes.fromhex(
    "FF FF FD 00 FE 19 00 55  00 03 A6 00 00 00 84 08  00 07 1F 08 00 00 16 CA  00 04 FF 03 00 00 D1 9E"
)
FAST_BULK_REPLY = bytes.fromhex(
    "FF FF FD 00 FE 14 00 55  00 03 A6 00 00 00 67 A4  00 07 A5 01 24 74  00 04 1F D9 C1"
)
BULK_READ, _ = bulk_read([(1, 144, 2), (2, 146, 1)], fast=False)
FAST_BULK_READ, _ = bulk_read([(3, 132, 4), (7, 124, 2), (4, 146, 1)], fast=True)
FAST_STATUSES = {
    3: Status(3, 0, False, b"\xa6\x00\x00\x00"),
    7: Status(7, 0, False, b"\x1f\x08\x00\x00"),
    4: Status(4, 0, False, b"\xff\x03\x00\x00"),
}


# The servo's side, written from the manual byte by byte, so that it shares nothing with the code under test.


def crc_of(data: bytes) -> bytes:
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1) ^ (0x18005 if crc & 0x8000 else 0)
    return bytes((crc & 0xFF, crc >> 8))


def status_frame(servo_id: int, error: int, data: bytes) -> bytes:
    body = bytearray()
    for byte in (0x55, error, *data):
        body.append(byte)
        if body[-3:] == b"\xff\xff\xfd":
            body.append(0xFD)
    length = len(body) + 2
    frame = bytes((0xFF, 0xFF, 0xFD, 0, servo_id, length & 0xFF, length >> 8, *body))
    return frame + crc_of(frame)


def fast_reply(blocks: list[tuple[int, int, bytes]]) -> bytes:
    length = 1 + sum(len(data) + 4 for _, _, data in blocks)
    frame = bytes((0xFF, 0xFF, 0xFD, 0, 0xFE, length & 0xFF, length >> 8, 0x55))
    for servo_id, error, data in blocks:
        frame += bytes((error, servo_id)) + data
        frame += crc_of(frame)
    return frame


def pieces(data: bytes, cuts: list[int]) -> list[bytes]:
    edges = [0, *sorted(cut % (len(data) + 1) for cut in cuts), len(data)]
    return [data[a:b] for a, b in pairwise(edges)]


# Bytes rich in what headers, stuffing and heads of frames are made of.
tricky = [b"\xff", b"\xfd", b"\xff\xff\xfd", b"\xff\xff\xfd\x00", b"\xff\xff\xfd\x00\x01\x08\x00\x55"]
payloads = st.lists(st.sampled_from(tricky) | st.binary(max_size=4), max_size=12).map(b"".join)
cuts = st.lists(st.integers(0, 500), max_size=8)
statuses = st.builds(Status, st.integers(0, 252), st.integers(0, 127), st.booleans(), payloads)


def frame_of(status: Status) -> bytes:
    return status_frame(status.id, status.error | (0x80 if status.alert else 0), status.data)


class TestInstructions:
    @pytest.mark.parametrize(
        ("frame", "expected"),
        [
            (ping(1), "FF FF FD 00 01 03 00 01 19 4E"),
            (ping(254), "FF FF FD 00 FE 03 00 01 31 42"),
            (read(1, 132, 4), "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"),
            (write(1, 116, b"\x00\x02\x00\x00"), "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89"),
            (reg_write(1, 104, b"\xc8\x00\x00\x00"), "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E"),
            (action(1), "FF FF FD 00 01 03 00 05 02 CE"),
            (reboot(1), "FF FF FD 00 01 03 00 08 2F 4E"),
            (factory_reset(1, Keep.ID), "FF FF FD 00 01 04 00 06 01 A1 E6"),
            (clear(1), "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC"),
            (store_backup(1), "FF FF FD 00 01 08 00 20 01 43 54 52 4C 16 F5"),
            # The manual ends this one with 92 F5, and the fast bulk read with 20 F2: no CRC of theirs.
            (restore_backup(1), "FF FF FD 00 01 08 00 20 02 43 54 52 4C 9E F5"),
            (BULK_READ, "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05"),
            (FAST_BULK_READ, "FF FF FD 00 FE 12 00 9A 03 84 00 04 00 07 7C 00 02 00 04 92 00 01 00 DA 2D"),
            (
                bulk_write([(1, 32, b"\xa0\x00"), (2, 31, b"\x50")]),
                "FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68",
            ),
            (sync_read(132, 4, (1, 2)), "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA"),
            (
                sync_write(116, 4, [(1, b"\x96\x00\x00\x00"), (2, b"\xaa\x00\x00\x00")]),
                "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87",
            ),
            (fast_sync_read(132, 4, (3, 7, 4)), "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2"),
        ],
    )
    def test_equals_the_manuals_example(self, frame: bytes, expected: str) -> None:
        assert frame == bytes.fromhex(expected)

    def test_stuffs_behind_each_header_lookalike(self) -> None:
        frame = write(1, 116, b"\xff\xff\xfd\xff\xff\xfd")
        assert frame[5:-2] == bytes.fromhex("0D 00 03 74 00 FF FF FD FD FF FF FD FD")
        assert frame[-2:] == crc_of(frame[:-2])

    @pytest.mark.parametrize(
        ("make", "complaint"),
        [
            (lambda: ping(253), "a servo's id is 0 to 252, not 253"),
            (lambda: ping(-1), "a servo's id is 0 to 252, not -1"),
            (lambda: read(254, 132, 4), "no servo answers a broadcast read"),
            (lambda: read(1, 65535, 4), "there is no range of 4 bytes at address 65535"),
            (lambda: write(1, 116, b""), "there is no range of 0 bytes at address 116"),
            (lambda: write(1, 0, bytes(2000)), "a frame holds 1021 bytes of data, not 2000: ask for less at once"),
            (lambda: sync_write(116, 4, [(7, b"\x01\x02")]), "servo 7: expected 4 bytes of data, got 2"),
            (lambda: sync_write(116, 4, []), r"expected different ids from 0 to 252, got \[\]"),
            (lambda: sync_read(132, 4, (1, 1)), r"expected different ids from 0 to 252, got \[1, 1\]"),
            (lambda: fast_sync_read(132, 4, (254,)), r"expected different ids from 0 to 252, got \[254\]"),
            (
                lambda: JointReply(dict.fromkeys((1, 2), 999)),
                "a reply may be 1024 bytes long, not 2007: read less at once",
            ),
            (
                lambda: bulk_read([(1, 0, 4), (1, 8, 4)], fast=False),
                r"expected different ids from 0 to 252, got \[1, 1\]",
            ),
            (lambda: bulk_read([(1, 0, 0)], fast=True), "there is no range of 0 bytes at address 0"),
            (lambda: bulk_write([(1, 0, b"")]), "there is no range of 0 bytes at address 0"),
            (
                lambda: bulk_write([(i, 0, bytes(20)) for i in range(50)]),
                "a frame may be 1024 bytes long, not 1253: send less at once",
            ),
            (lambda: factory_reset(254, Keep.NOTHING), "all servos of the bus would get the same id, so they refuse"),
        ],
    )
    def test_refuses_what_cannot_be_sent(self, make: Callable[[], object], complaint: str) -> None:
        with pytest.raises(ValueError, match=f"^{complaint}$"):
            make()


class TestReceiver:
    @pytest.mark.parametrize(
        ("frame", "status"),
        [
            (PING_STATUS, Status(1, 0, False, b"\x06\x04\x26")),
            (SECOND_PING_STATUS, Status(2, 0, False, b"\x06\x04\x26")),
            (POSITION_STATUS, Status(1, 0, False, b"\xa6\x00\x00\x00")),
            (EMPTY_STATUS, Status(1, 0, False, b"")),
        ],
    )
    def test_reads_the_manuals_example(self, frame: bytes, status: Status) -> None:
        assert Receiver().feed(frame) == [status]

    def test_parts_alert_and_error_number(self) -> None:
        assert Receiver().feed(status_frame(9, 0x87, b"")) == [Status(9, 7, True, b"")]
        assert Receiver().feed(status_frame(9, 0x80, b"\x01")) == [Status(9, 0, True, b"\x01")]

    @given(st.lists(statuses, max_size=5), cuts)
    def test_finds_every_status_however_the_stream_is_cut(self, sent: list[Status], where: list[int]) -> None:
        receiver = Receiver()
        stream = b"".join(map(frame_of, sent))
        assert [s for piece in pieces(stream, where) for s in receiver.feed(piece)] == sent
        assert receiver.bad_frames == 0

    @given(payloads, statuses, payloads, statuses, cuts)
    def test_finds_the_frames_in_noise(
        self, noise: bytes, first: Status, more: bytes, second: Status, where: list[int]
    ) -> None:
        receiver = Receiver()
        stream = noise + frame_of(first) + more + frame_of(second)
        found = [s for piece in pieces(stream, where) for s in receiver.feed(piece)]
        assert found == [first, second]

    @given(st.binary(max_size=300), cuts)
    def test_after_any_noise_the_next_status_is_found(self, noise: bytes, where: list[int]) -> None:
        receiver = Receiver()
        for piece in pieces(noise, where):
            receiver.feed(piece)
        assert receiver.feed(POSITION_STATUS)[-1:] == [Status(1, 0, False, b"\xa6\x00\x00\x00")]

    @pytest.mark.parametrize("frame", [PING_STATUS, status_frame(5, 0x80, b"\xff\xff\xfd\x00\xff\xff\xfd")])
    def test_no_flipped_byte_yields_a_wrong_status(self, frame: bytes) -> None:
        for position in range(len(frame)):
            for flip in range(1, 256):
                garbled = bytearray(frame)
                garbled[position] ^= flip
                receiver = Receiver()
                assert receiver.feed(bytes(garbled)) == []
                assert receiver.feed(POSITION_STATUS * 2)[-1] == Status(1, 0, False, b"\xa6\x00\x00\x00")

    @given(statuses, st.integers(0, 500), st.integers(1, 255), statuses)
    def test_a_flipped_byte_costs_one_frame_only(
        self, first: Status, position: int, flip: int, second: Status
    ) -> None:
        garbled = bytearray(frame_of(first))
        garbled[position % len(garbled)] ^= flip
        assert Receiver().feed(bytes(garbled) + frame_of(second)) == [second]

    @pytest.mark.parametrize("kept", range(8, len(POSITION_STATUS)))
    def test_a_frame_cut_short_is_given_up_at_the_next_header(self, kept: int) -> None:
        receiver = Receiver()
        assert receiver.feed(POSITION_STATUS[:kept] + EMPTY_STATUS) == [Status(1, 0, False, b"")]
        assert receiver.bad_frames == 1

    def test_a_false_header_is_data(self) -> None:
        receiver = Receiver()
        assert receiver.feed(b"\xff\xff\xfd\xfd" + EMPTY_STATUS) == [Status(1, 0, False, b"")]
        assert receiver.bad_frames == 0

    def test_a_wrong_crc_is_counted(self) -> None:
        receiver = Receiver()
        assert receiver.feed(PING_STATUS[:-1] + b"\x5c" + EMPTY_STATUS) == [Status(1, 0, False, b"")]
        assert receiver.bad_frames == 1

    @pytest.mark.parametrize(
        "head", ["FF FF FD 00 01 01 04 55", "FF FF FD 00 01 02 00 55", "FF FF FD 00 FD 04 00 55"]
    )
    def test_an_impossible_head_is_not_waited_for(self, head: str) -> None:
        receiver = Receiver()
        assert receiver.feed(bytes.fromhex(head)) == []
        assert receiver.bad_frames == 1
        assert receiver.feed(EMPTY_STATUS) == [Status(1, 0, False, b"")]

    def test_a_long_garbage_length_does_not_hold_up_the_next_frame(self) -> None:
        receiver = Receiver()
        assert receiver.feed(bytes.fromhex("FF FF FD 00 01 00 04 55 00")) == []
        assert receiver.feed(EMPTY_STATUS) == [Status(1, 0, False, b"")]
        assert receiver.bad_frames == 1

    @pytest.mark.parametrize(
        "echo",
        [ping(1), write(1, 116, b"\xff\xff\xfd\x00"), sync_write(116, 4, [(i, bytes(4)) for i in range(60)])],
    )
    def test_an_echo_is_dropped_and_not_counted(self, echo: bytes) -> None:
        receiver = Receiver()
        assert receiver.feed(echo + EMPTY_STATUS) == [Status(1, 0, False, b"")]
        assert receiver.bad_frames == 0

    def test_a_status_without_an_error_byte_is_dropped(self) -> None:
        frame = bytes.fromhex("FF FF FD 00 01 03 00 55")
        assert Receiver().feed(frame + crc_of(frame) + EMPTY_STATUS) == [Status(1, 0, False, b"")]

    def test_a_late_fast_sync_reply_is_not_a_servos_status(self) -> None:
        receiver = Receiver()
        assert receiver.feed(FAST_REPLY + EMPTY_STATUS) == [Status(1, 0, False, b"")]
        assert receiver.bad_frames == 0

    def test_reset_throws_half_a_frame_away(self) -> None:
        receiver = Receiver()
        receiver.feed(POSITION_STATUS[:10])
        receiver.reset()
        assert receiver.feed(POSITION_STATUS[10:]) == []
        assert receiver.feed(EMPTY_STATUS) == [Status(1, 0, False, b"")]


class TestJointReply:
    def test_reads_the_manuals_example(self) -> None:
        reply = JointReply(dict.fromkeys((3, 7, 4), 4))
        reply.feed(FAST_REPLY)
        assert reply.results == FAST_STATUSES
        assert list(reply.results) == [3, 7, 4]
        assert reply.complete
        assert not reply.corrupt

    def test_reads_the_manuals_example_of_a_bulk_read(self) -> None:
        _, reply = bulk_read([(3, 132, 4), (7, 124, 2), (4, 146, 1)], fast=True)
        reply.feed(FAST_BULK_REPLY)
        assert reply.results == {
            3: Status(3, 0, False, b"\xa6\x00\x00\x00"), 7: Status(7, 0, False, b"\xa5\x01"),
            4: Status(4, 0, False, b"\x1f")}
        assert reply.complete
        assert reply.size == len(FAST_BULK_REPLY)

    @pytest.mark.parametrize("kept", range(len(FAST_BULK_REPLY)))
    def test_blocks_of_a_bulk_read_before_a_silent_servo_are_kept(self, kept: int) -> None:
        _, reply = bulk_read([(3, 132, 4), (7, 124, 2), (4, 146, 1)], fast=True)
        reply.feed(FAST_BULK_REPLY[:kept])
        good = [servo_id for servo_id, status in reply.results.items() if status is not None]
        assert good == [3, 7][:(kept >= 16) + (kept >= 22)]

    def test_results_come_block_by_block(self) -> None:
        reply = JointReply(dict.fromkeys((3, 7, 4), 4))
        assert reply.results == {3: None, 7: None, 4: None}
        done = []
        for index, byte in enumerate(FAST_REPLY, start=1):
            reply.feed(bytes((byte,)))
            done.append((index, sum(status is not None for status in reply.results.values()), reply.complete))
        assert done[15:17] == [(16, 1, False), (17, 1, False)]
        assert done[14] == (15, 0, False)
        assert done[23] == (24, 2, False)
        assert done[31] == (32, 3, True)

    def test_reset_makes_it_ready_for_the_next_reply(self) -> None:
        reply = JointReply(dict.fromkeys((3, 7, 4), 4))
        reply.feed(FAST_REPLY[:20])
        reply.reset()
        assert reply.results == {3: None, 7: None, 4: None}
        reply.feed(FAST_REPLY)
        assert reply.results == FAST_STATUSES

    @pytest.mark.parametrize(
        "before",
        [b"\x00\xff\xff\xfd", fast_sync_read(132, 4, (3, 7, 4)), EMPTY_STATUS, b"\xff\xff\xfd\x00\xfe\x19"],
        ids=["noise", "echo", "stale status", "half a head"],
    )
    def test_what_comes_before_the_reply_is_skipped(self, before: bytes) -> None:
        reply = JointReply(dict.fromkeys((3, 7, 4), 4))
        reply.feed(before + FAST_REPLY)
        assert reply.results == FAST_STATUSES

    @pytest.mark.parametrize("kept", range(len(FAST_REPLY)))
    def test_blocks_before_a_silent_servo_are_kept(self, kept: int) -> None:
        reply = JointReply(dict.fromkeys((3, 7, 4), 4))
        reply.feed(FAST_REPLY[:kept])
        assert reply.results == {
            3: FAST_STATUSES[3] if kept >= 16 else None,
            7: FAST_STATUSES[7] if kept >= 24 else None,
            4: None,
        }
        assert not reply.complete
        assert not reply.corrupt

    @pytest.mark.parametrize("position", range(len(FAST_REPLY)))
    def test_blocks_before_a_flipped_byte_are_kept_and_no_wrong_one_is_believed(self, position: int) -> None:
        for flip in range(1, 256):
            garbled = bytearray(FAST_REPLY)
            garbled[position] ^= flip
            reply = JointReply(dict.fromkeys((3, 7, 4), 4))
            reply.feed(bytes(garbled))
            assert reply.results == {
                3: FAST_STATUSES[3] if position >= 16 else None,
                7: FAST_STATUSES[7] if position >= 24 else None,
                4: None,
            }
            assert reply.corrupt == (position >= 8)
            assert reply.complete == (position >= 8)

    @pytest.mark.parametrize("lost", range(8, len(FAST_REPLY)))
    def test_a_lost_byte_costs_its_block_and_those_behind(self, lost: int) -> None:
        reply = JointReply(dict.fromkeys((3, 7, 4), 4))
        reply.feed(FAST_REPLY[:lost] + FAST_REPLY[lost + 1 :])
        kept = [servo_id for servo_id, status in reply.results.items() if status == FAST_STATUSES[servo_id]]
        assert kept == [3, 7, 4][: (lost - 8) // 8]
        assert not reply.complete

    def test_another_servos_block_is_not_believed(self) -> None:
        reply = JointReply(dict.fromkeys((3, 4, 7), 4))
        reply.feed(FAST_REPLY)
        assert reply.results == {3: FAST_STATUSES[3], 4: None, 7: None}
        assert reply.corrupt

    def test_error_and_alert_are_per_servo(self) -> None:
        reply = JointReply(dict.fromkeys((1, 2), 2))
        reply.feed(fast_reply([(1, 0x80, b"\x01\x02"), (2, 0x07, b"\x00\x00")]))
        assert reply.results == {1: Status(1, 0, True, b"\x01\x02"), 2: Status(2, 7, False, b"\x00\x00")}

    @given(st.lists(st.binary(min_size=7, max_size=7), min_size=1, max_size=18), cuts)
    def test_any_data_in_any_pieces(self, data: list[bytes], where: list[int]) -> None:
        blocks = [(servo_id, 0, block) for servo_id, block in enumerate(data)]
        reply = JointReply(dict.fromkeys(range(len(data)), 7))
        for piece in pieces(fast_reply(blocks), where):
            reply.feed(piece)
        assert reply.results == {servo_id: Status(servo_id, 0, False, block) for servo_id, _, block in blocks}

    @pytest.mark.parametrize("data", [b"\xff\xff\xfd\x00", b"\xff\xff\xfd\xfd", b"\xff\xff\xfd\xff"])
    def test_nothing_is_unstuffed(self, data: bytes) -> None:
        reply = JointReply(dict.fromkeys((1,), 4))
        reply.feed(fast_reply([(1, 0, data)]))
        assert reply.results == {1: Status(1, 0, False, data)}


def test_errors_are_described_in_plain_words() -> None:
    assert [error.value for error in ErrorNumber] == [1, 2, 3, 4, 5, 6, 7]
    assert describe_error(0) == "no error"
    assert describe_error(7) == "the register is read-only or absent, or is locked while torque is on"
    assert describe_error(9) == "error number 9, which the protocol does not define"
