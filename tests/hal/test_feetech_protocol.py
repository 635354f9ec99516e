"""Frames against Feetech's examples, and the receiver against everything that a wire can do to them."""

from collections.abc import Callable
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.feetech_protocol import (
    Fault,
    Receiver,
    action,
    calibrate,
    describe_error,
    factory_reset,
    group_read,
    ping,
    read,
    reboot,
    reg_write,
    reset_turns,
    sync_read,
    sync_write,
    write,
)
from hal.protocol import Status

# From the manual's sections 1.3.1, 1.3.2 and 1.3.7.
EMPTY_STATUS = bytes.fromhex("FF FF 01 02 00 FC")
POSITION_STATUS = bytes.fromhex("FF FF 01 04 00 18 05 DD")
FIRST_REPLY = bytes.fromhex("FF FF 01 0A 00 00 08 00 00 00 00 79 1E 55")
SECOND_REPLY = bytes.fromhex("FF FF 02 0A 00 FF 07 00 00 00 00 77 23 53")
FIRST, SECOND = (
    Status(1, 0, False, bytes.fromhex("00 08 00 00 00 00 79 1E")),
    Status(2, 0, False, bytes.fromhex("FF 07 00 00 00 00 77 23")),
)


# The servo's side, written from the manual byte by byte, so that it shares nothing with the code under test.


def status_frame(servo_id: int, error: int, data: bytes) -> bytes:
    total = servo_id + len(data) + 2 + error
    for byte in data:
        total += byte
    return bytes((0xFF, 0xFF, servo_id, len(data) + 2, error, *data, 255 - total % 256))


def frame_of(status: Status) -> bytes:
    return status_frame(status.id, 0x20 if status.alert else 0, status.data)


def pieces(data: bytes, cuts: list[int]) -> list[bytes]:
    edges = [0, *sorted(cut % (len(data) + 1) for cut in cuts), len(data)]
    return [data[a:b] for a, b in pairwise(edges)]


# Bytes rich in what headers and heads of frames are made of.
tricky = [
    b"\xff", b"\xff\xff", b"\xff\xff\xfe", b"\xff\xff\x01", b"\xff\xff\x01\x02\x00", b"\xff\xff\x01\x02\x00\xfc"]
payloads = st.lists(st.sampled_from(tricky) | st.binary(max_size=4), max_size=12).map(b"".join)
eights = st.lists(st.sampled_from(tricky) | st.binary(min_size=1, max_size=4), min_size=8).map(
    lambda parts: b"".join(parts)[:8])
cuts = st.lists(st.integers(0, 500), max_size=8)
ids, alerts = st.integers(0, 253), st.booleans()
statuses = st.builds(Status, ids, st.just(0), alerts, payloads)
equal_statuses = st.builds(Status, ids, st.just(0), alerts, eights)
# Noise that may end like a header but holds none.
harmless = st.lists(st.sampled_from([b"\xff", b"\x00", b"\x01\x02", b"\xff\xff\xfe"]), max_size=8).map(
    lambda parts: b"\x00".join([*parts, b""]))


class TestInstructions:
    @pytest.mark.parametrize(
        ("frame", "expected"),
        [
            (ping(1), "FF FF 01 02 01 FB"),
            (read(1, 56, 2), "FF FF 01 04 02 38 02 BE"),
            (write(254, 5, b"\x01"), "FF FF FE 04 03 05 01 F4"),
            (write(1, 42, bytes.fromhex("00 08 00 00 E8 03")), "FF FF 01 09 03 2A 00 08 00 00 E8 03 D5"),
            (reg_write(1, 42, bytes.fromhex("00 08 00 00 E8 03")), "FF FF 01 09 04 2A 00 08 00 00 E8 03 D4"),
            (action(254), "FF FF FE 02 05 FA"),
            (
                sync_write(42, 6, [(i, bytes.fromhex("00 08 00 00 E8 03")) for i in (1, 2, 3, 4)]),
                "FF FF FE 20 83 2A 06 01 00 08 00 00 E8 03 02 00 08 00 00 E8 03"
                "03 00 08 00 00 E8 03 04 00 08 00 00 E8 03 58",
            ),
            (sync_read(56, 8, (1, 2)), "FF FF FE 06 82 38 08 01 02 36"),
        ],
    )
    def test_equals_the_manuals_example(self, frame: bytes, expected: str) -> None:
        assert frame == bytes.fromhex(expected)

    @pytest.mark.parametrize(
        ("frame", "expected"),
        [
            (write(1, 12, b"\x64\xaa"), "FF FF 01 05 03 0C 64 AA DC"),
            (
                sync_write(30, 4, [(0, b"\x10\x00\x50\x01"), (1, b"\x20\x02\x60\x03")]),
                "FF FF FE 0E 83 1E 04 00 10 00 50 01 01 20 02 60 03 67",
            ),
            (factory_reset(1), "FF FF 01 02 06 F6"),
            (reboot(1), "FF FF 01 02 08 F4"),
            (reset_turns(1), "FF FF 01 02 0A F2"),
            (calibrate(1), "FF FF 01 02 0B F1"),
        ],
    )
    def test_equals_dynamixel_protocol_1_which_has_the_same_shape(self, frame: bytes, expected: str) -> None:
        assert frame == bytes.fromhex(expected)

    def test_the_largest_frames_have_250_bytes(self) -> None:
        assert len(sync_write(41, 7, [(i, bytes(7)) for i in range(30)])) == 248
        assert len(sync_write(42, 2, [(i, bytes(2)) for i in range(80)])) == 248
        assert len(sync_read(56, 8, range(242))) == 250
        assert len(write(1, 0, bytes(243))) == 250

    @pytest.mark.parametrize(
        ("make", "complaint"),
        [
            (lambda: ping(255), "a servo's id is 0 to 253, not 255"),
            (lambda: ping(-1), "a servo's id is 0 to 253, not -1"),
            (lambda: read(254, 56, 2), "no servo answers a broadcast read"),
            (lambda: read(1, 255, 2), "there is no range of 2 bytes at address 255"),
            (lambda: read(1, 0, 245), "a frame holds 244 bytes of data, not 245: ask for less at once"),
            (lambda: write(1, 42, b""), "there is no range of 0 bytes at address 42"),
            (lambda: write(1, 0, bytes(244)), "a frame may be 250 bytes long, not 251: send less at once"),
            (lambda: sync_write(42, 2, [(7, b"\x01")]), "servo 7: expected 2 bytes of data, got 1"),
            (lambda: sync_write(42, 2, []), r"expected different ids from 0 to 253, got \[\]"),
            (lambda: sync_read(56, 8, (1, 1)), r"expected different ids from 0 to 253, got \[1, 1\]"),
            (lambda: sync_read(56, 8, (254,)), r"expected different ids from 0 to 253, got \[254\]"),
            (
                lambda: sync_write(41, 7, [(i, bytes(7)) for i in range(31)]),
                "30 servos fit into a frame with 244 bytes of parameters, not 31",
            ),
            (
                lambda: sync_write(42, 2, [(i, bytes(2)) for i in range(81)]),
                "80 servos fit into a frame with 244 bytes of parameters, not 81",
            ),
            (lambda: sync_read(56, 8, range(243)), "242 servos fit into a frame with 244 bytes of parameters, not 243"),
            (lambda: group_read(56, 8, (1, 2), fast=True), "these servos have no fast sync read"),
        ],
    )
    def test_refuses_what_cannot_be_sent(self, make: Callable[[], object], complaint: str) -> None:
        with pytest.raises(ValueError, match=f"^{complaint}$"):
            make()


class TestReceiver:
    @pytest.mark.parametrize(
        ("frame", "status"),
        [
            (EMPTY_STATUS, Status(1, 0, False, b"")),
            (POSITION_STATUS, Status(1, 0, False, b"\x18\x05")),
            (FIRST_REPLY, FIRST),
            (SECOND_REPLY, SECOND),
        ],
    )
    def test_reads_the_manuals_example(self, frame: bytes, status: Status) -> None:
        assert Receiver().feed(frame) == [status]

    @pytest.mark.parametrize(
        ("error", "alert"),
        [(0x01, True), (0x02, True), (0x04, True), (0x08, True), (0x10, False), (0x20, True), (0x31, True)],
    )
    def test_flags_are_an_alert_and_never_a_refusal_and_the_disputed_one_is_neither(
        self, error: int, alert: bool
    ) -> None:
        assert Receiver().feed(status_frame(9, error, b"\x01")) == [Status(9, 0, alert, b"\x01")]

    @given(st.lists(statuses, max_size=5), cuts)
    def test_finds_every_status_however_the_stream_is_cut(self, sent: list[Status], where: list[int]) -> None:
        receiver = Receiver()
        stream = b"".join(map(frame_of, sent))
        assert [s for piece in pieces(stream, where) for s in receiver.feed(piece)] == sent
        assert receiver.bad_frames == 0

    @given(harmless, statuses, harmless, statuses, cuts)
    def test_finds_the_frames_in_noise(
        self, noise: bytes, first: Status, more: bytes, second: Status, where: list[int]
    ) -> None:
        receiver = Receiver()
        stream = noise + frame_of(first) + more + frame_of(second)
        assert [s for piece in pieces(stream, where) for s in receiver.feed(piece)] == [first, second]

    @given(st.binary(max_size=300), cuts)
    def test_noise_is_survived_and_gone_after_a_reset(self, noise: bytes, where: list[int]) -> None:
        receiver = Receiver()
        for piece in pieces(noise, where):
            receiver.feed(piece)
        receiver.reset()
        assert receiver.feed(POSITION_STATUS) == [Status(1, 0, False, b"\x18\x05")]

    @pytest.mark.parametrize("before", ["FF", "FF FF", "FF FF FF FF", "FF FF FE", "00 FF"])
    def test_a_run_of_ff_is_no_header(self, before: str) -> None:
        receiver = Receiver()
        assert receiver.feed(bytes.fromhex(before) + POSITION_STATUS) == [Status(1, 0, False, b"\x18\x05")]
        assert receiver.bad_frames == 0

    def test_ff_ff_in_the_data_is_data(self) -> None:
        data = bytes.fromhex("FF FF 02 04 00 18 05 DC")
        receiver = Receiver()
        assert receiver.feed(status_frame(1, 0, data)) == [Status(1, 0, False, data)]
        assert receiver.bad_frames == 0

    def test_a_wrong_checksum_is_counted(self) -> None:
        receiver = Receiver()
        assert receiver.feed(POSITION_STATUS[:-1] + b"\xdc" + EMPTY_STATUS) == [Status(1, 0, False, b"")]
        assert receiver.bad_frames == 1

    @pytest.mark.parametrize(
        "head", ["FF FF 01 00", "FF FF 01 01", "FF FF 01 F7", "FF FF 01 04 80", "FF FF 01 04 83"])
    def test_an_impossible_head_is_not_waited_for(self, head: str) -> None:
        receiver = Receiver()
        assert receiver.feed(bytes.fromhex(head)) == []
        assert receiver.bad_frames == 1
        assert receiver.feed(EMPTY_STATUS) == [Status(1, 0, False, b"")]

    def test_the_longest_frame_is_read(self) -> None:
        assert Receiver().feed(status_frame(1, 0, bytes(244))) == [Status(1, 0, False, bytes(244))]

    @pytest.mark.parametrize(
        "echo", [sync_read(56, 8, (1, 2)), sync_write(42, 2, [(1, b"\x00\x08")]), action(254)])
    def test_an_instruction_to_everybody_is_not_a_status(self, echo: bytes) -> None:
        receiver = Receiver()
        assert receiver.feed(echo + EMPTY_STATUS) == [Status(1, 0, False, b"")]
        assert receiver.bad_frames == 0

    def test_an_instruction_to_one_servo_reads_as_its_status(self) -> None:
        """The protocol's own fault, and the reason why the transport must take echoes out."""
        assert Receiver().feed(ping(1)) == [Status(1, 0, True, b"")]

    def test_reset_throws_half_a_frame_away(self) -> None:
        receiver = Receiver()
        receiver.feed(POSITION_STATUS[:6])
        receiver.reset()
        assert receiver.feed(POSITION_STATUS[6:]) == []
        assert receiver.feed(EMPTY_STATUS) == [Status(1, 0, False, b"")]


class TestFlippedByte:
    @given(statuses, st.integers(0, 500), st.integers(1, 255))
    def test_no_status_of_the_same_length_comes_of_it(self, status: Status, position: int, flip: int) -> None:
        garbled = bytearray(frame_of(status))
        garbled[position % len(garbled)] ^= flip
        assert all(len(found.data) != len(status.data) for found in Receiver().feed(bytes(garbled)))

    @pytest.mark.parametrize("data", [b"\x00\x08\x00\x00\x00\x00\x79\x1e", b"\xff\xff\x01\x02\x00\xfc\xff\xff"])
    def test_nothing_comes_of_it_where_the_length_is_known(self, data: bytes) -> None:
        frame = status_frame(1, 0, data)
        for position in range(len(frame)):
            for flip in range(1, 256):
                garbled = bytearray(frame)
                garbled[position] ^= flip
                assert Receiver(8).feed(bytes(garbled)) == []

    @pytest.mark.parametrize("position", range(14))
    def test_it_costs_one_servo_of_a_group_one_answer(self, position: int) -> None:
        for flip in range(1, 256):
            garbled = bytearray(FIRST_REPLY)
            garbled[position] ^= flip
            receiver = Receiver(8)
            assert receiver.feed(bytes(garbled) + SECOND_REPLY) == [SECOND]
            # Where a header is lost, or the id is everybody's, there is no status to count.
            assert receiver.bad_frames == (position >= 2 and garbled[2] != 0xFE)


class TestKnownLength:
    @given(st.lists(equal_statuses, max_size=5), cuts)
    def test_finds_every_status_however_the_stream_is_cut(self, sent: list[Status], where: list[int]) -> None:
        receiver = Receiver(8)
        stream = b"".join(map(frame_of, sent))
        assert [s for piece in pieces(stream, where) for s in receiver.feed(piece)] == sent

    @pytest.mark.parametrize("length", [2, 9, 11, 200, 250, 255])
    def test_a_garbled_length_does_not_hold_up_the_next_servo_of_a_group(self, length: int) -> None:
        _, reply = group_read(56, 8, (1, 2), fast=False)
        reply.feed(FIRST_REPLY[:3] + bytes((length,)) + FIRST_REPLY[4:] + SECOND_REPLY)
        assert reply.results == {1: None, 2: SECOND}

    def test_a_late_acknowledgement_is_no_answer_of_a_group(self) -> None:
        _, reply = group_read(56, 8, (1, 2), fast=False)
        reply.feed(EMPTY_STATUS + FIRST_REPLY)
        assert reply.results == {1: FIRST, 2: None}

    @pytest.mark.parametrize("kept", range(len(FIRST_REPLY)))
    def test_a_frame_cut_short_costs_its_own_servo_only(self, kept: int) -> None:
        assert Receiver(8).feed(FIRST_REPLY[:kept] + SECOND_REPLY) == [SECOND]


def test_no_error_is_defined() -> None:
    assert describe_error(0) == "no error"
    assert describe_error(4) == "error number 4, which the protocol does not define"


def test_faults_name_the_bits_of_register_65() -> None:
    assert str(Fault(0x24)) == "36"
    assert Fault(0x24).name == "TEMPERATURE|OVERLOAD"
