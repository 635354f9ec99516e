"""What `hal.protocol` promises, asked of every protocol."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal import dynamixel1_protocol, dynamixel_protocol, feetech_protocol
from hal.protocol import GroupReply, ServoProtocol, Status
from hal.whole_reply import WholeReply

Answer = tuple[int, bytes]  # id, data


# The servos' side, from the manuals.


def dynamixel_checked(frame: bytes) -> bytes:
    crc = 0
    for byte in frame:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1) ^ (0x18005 if crc & 0x8000 else 0)
    return frame + bytes((crc & 0xFF, crc >> 8))


def dynamixel_status(servo_id: int, data: bytes, alert: bool = False) -> bytes:
    data = data.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
    return dynamixel_checked(bytes((255, 255, 253, 0, servo_id, len(data) + 4, 0, 0x55, 0x80 * alert)) + data)


def dynamixel_joint_status(answers: Iterable[Answer]) -> bytes:
    answers = tuple(answers)
    length = 1 + sum(4 + len(data) for _, data in answers)
    frame = bytes((255, 255, 253, 0, 254, length & 0xFF, length >> 8, 0x55))
    for servo_id, data in answers:
        frame = dynamixel_checked(frame + bytes((0, servo_id)) + data)
    return frame


def checksum_status(servo_id: int, data: bytes, alert: bool = False) -> bytes:
    body = bytes((servo_id, len(data) + 2, 0x20 * alert)) + data
    return b"\xff\xff" + body + bytes((255 - sum(body) % 256,))


def separate(status: Callable[[int, bytes], bytes], answers: Iterable[Answer]) -> bytes:
    return b"".join(status(servo_id, data) for servo_id, data in answers)


class Brand(NamedTuple):
    """A protocol, one way of its group read, and the servos' answers."""

    module: ServoProtocol
    fast: bool
    status: Callable[..., bytes]
    answers: Callable[[Iterable[Answer]], bytes]

    bulk: bool = False

    def request(self, ids: Sequence[int], length: int = 4) -> tuple[bytes, GroupReply]:
        if self.bulk:
            return self.module.bulk_read([(servo_id, 56, length) for servo_id in ids], fast=self.fast)
        return self.module.group_read(56, length, ids, fast=self.fast)

    def read(self, ids: Sequence[int], length: int = 4) -> GroupReply:
        return self.request(ids, length)[1]


BRANDS = {
    "dynamixel": Brand(
        dynamixel_protocol, False, dynamixel_status, partial(separate, dynamixel_status)),
    "dynamixel, fast": Brand(
        dynamixel_protocol, True, dynamixel_status, dynamixel_joint_status),
    "dynamixel, bulk": Brand(
        dynamixel_protocol, False, dynamixel_status, partial(separate, dynamixel_status), bulk=True),
    "dynamixel, fast bulk": Brand(
        dynamixel_protocol, True, dynamixel_status, dynamixel_joint_status, bulk=True),
    "dynamixel 1.0, bulk": Brand(
        dynamixel1_protocol, False, checksum_status, partial(separate, checksum_status), bulk=True),
    "feetech": Brand(
        feetech_protocol, False, checksum_status, partial(separate, checksum_status)),
}

pytestmark = pytest.mark.parametrize("brand", BRANDS.values(), ids=BRANDS.keys())

IDS = (7, 2, 5)
ANSWERS = [(7, b"\x07\x00\x11\x12"), (2, b"\x02\x00\x21\x22"), (5, b"\x05\x00\x31\x32")]
GOOD = {servo_id: Status(servo_id, 0, False, data) for servo_id, data in ANSWERS}
NOBODY: dict[int, Status | None] = {7: None, 2: None, 5: None}


class TestGroupReply:
    def test_nobody_has_answered_at_first(self, brand: Brand) -> None:
        reply = brand.read(IDS)
        assert reply.results == NOBODY
        assert not reply.complete
        assert reply.bad_frames == 0

    def test_results_are_in_the_order_asked_for(self, brand: Brand) -> None:
        reply = brand.read(IDS)
        reply.feed(brand.answers(ANSWERS))
        assert reply.results == GOOD
        assert list(reply.results) == [7, 2, 5]

    @pytest.mark.parametrize(("servos", "length"), [(1, 1), (3, 4), (18, 6), (24, 8)])
    def test_size_is_the_bytes_of_a_full_answer(self, brand: Brand, servos: int, length: int) -> None:
        answers = [(servo_id, bytes(length)) for servo_id in range(1, servos + 1)]
        assert brand.read(range(1, servos + 1), length).size == len(brand.answers(answers))

    def test_return_delays_are_one_each_unless_the_answer_is_joint(self, brand: Brand) -> None:
        assert brand.read(IDS).waits == (1 if brand.fast else 3)

    def test_it_is_complete_with_the_last_byte_and_not_before(self, brand: Brand) -> None:
        reply = brand.read(IDS)
        stream = brand.answers(ANSWERS)
        reply.feed(stream[:-1])
        assert not reply.complete
        assert reply.results == {**GOOD, 5: None}
        reply.feed(stream[-1:])
        assert reply.complete
        assert reply.results == GOOD

    @given(cuts=st.lists(st.integers(0, 100), max_size=6))
    def test_answers_may_come_in_any_pieces(self, brand: Brand, cuts: list[int]) -> None:
        reply = brand.read(IDS)
        stream = brand.answers(ANSWERS)
        for start, end in pairwise([0, *sorted(min(cut, len(stream)) for cut in cuts), len(stream)]):
            reply.feed(stream[start:end])
        assert reply.results == GOOD
        assert reply.bad_frames == 0

    @given(data=st.lists(st.binary(min_size=4, max_size=4), min_size=1, max_size=8))
    def test_any_data_comes_through(self, brand: Brand, data: list[bytes]) -> None:
        answers = list(enumerate(data))
        reply = brand.read(range(len(data)))
        reply.feed(brand.answers(answers))
        assert reply.results == {servo_id: Status(servo_id, 0, False, block) for servo_id, block in answers}

    def test_strangers_are_ignored(self, brand: Brand) -> None:
        reply = brand.read(IDS)
        reply.feed(brand.status(9, b"\x01\x02\x03\x04") + brand.answers(ANSWERS))
        assert reply.results == GOOD
        assert reply.complete

    def test_of_two_answers_the_first_counts(self, brand: Brand) -> None:
        reply = brand.read(IDS)
        reply.feed(brand.answers(ANSWERS) + brand.status(7, b"\xaa\xaa\xaa\xaa"))
        assert reply.results == GOOD

    def test_noise_before_the_answers_is_skipped(self, brand: Brand) -> None:
        reply = brand.read(IDS)
        reply.feed(b"\x00\xff\xff\x80\xff" + brand.answers(ANSWERS))
        assert reply.results == GOOD

    def test_a_garbled_answer_is_counted_and_is_none(self, brand: Brand) -> None:
        reply = brand.read(IDS)
        stream = bytearray(brand.answers(ANSWERS))
        stream[stream.index(0x31)] ^= 0x04
        reply.feed(bytes(stream))
        assert reply.results == {**GOOD, 5: None}
        assert reply.bad_frames == 1

    def test_reset_forgets_answers_and_half_answers_and_keeps_count_of_the_bad(self, brand: Brand) -> None:
        reply = brand.read(IDS)
        stream = brand.answers(ANSWERS)
        garbled = bytearray(stream)
        garbled[garbled.index(0x31)] ^= 0x04
        reply.feed(bytes(garbled))
        reply.reset()
        assert reply.results == NOBODY
        assert not reply.complete
        reply.feed(stream[:-3])
        reply.reset()
        reply.feed(stream)
        assert reply.results == GOOD
        assert reply.bad_frames == 1

    def test_a_silent_servo_costs_no_one_before_it(self, brand: Brand) -> None:
        reply = brand.read(IDS)
        reply.feed(brand.answers(ANSWERS)[:-3])
        assert reply.results == {**GOOD, 5: None}
        assert not reply.complete


class TestReceiver:
    def test_an_alert_is_told_apart_from_an_error_and_the_data_counts(self, brand: Brand) -> None:
        assert brand.module.receiver().feed(brand.status(3, b"\x01\x02", alert=True)) == [
            Status(3, 0, True, b"\x01\x02")]

    def test_several_statuses_come_in_order(self, brand: Brand) -> None:
        stream = brand.status(3, b"\x01") + brand.status(4, b"") + brand.status(3, b"\x02\x03")
        assert brand.module.receiver().feed(stream) == [
            Status(3, 0, False, b"\x01"), Status(4, 0, False, b""), Status(3, 0, False, b"\x02\x03")]

    def test_half_a_frame_waits_for_its_rest_until_reset(self, brand: Brand) -> None:
        frame = brand.status(3, b"\x01\x02")
        receiver = brand.module.receiver()
        assert receiver.feed(frame[:-2]) == []
        assert receiver.feed(frame[-2:]) == [Status(3, 0, False, b"\x01\x02")]
        receiver.feed(frame[:-2])
        receiver.reset()
        assert receiver.feed(frame[-2:]) == []
        assert receiver.bad_frames == 0

    def test_a_bad_frame_is_counted_and_the_next_one_found(self, brand: Brand) -> None:
        garbled = bytearray(brand.status(3, b"\x01\x02"))
        garbled[-1] ^= 0x01
        receiver = brand.module.receiver()
        assert receiver.feed(bytes(garbled) + brand.status(4, b"\x05")) == [Status(4, 0, False, b"\x05")]
        assert receiver.bad_frames == 1


class TestInstructions:
    def test_everybody_is_254(self, brand: Brand) -> None:
        assert brand.module.BROADCAST_ID == 254

    def test_no_error_is_described_as_that(self, brand: Brand) -> None:
        assert brand.module.describe_error(0) == "no error"
        assert brand.module.describe_error(99) == "error number 99, which the protocol does not define"

    @pytest.mark.parametrize("servo_id", [-1, 255])
    def test_an_id_that_no_servo_has_is_refused(self, brand: Brand, servo_id: int) -> None:
        protocol = brand.module
        for make in (
            lambda: protocol.ping(servo_id),
            lambda: protocol.reboot(servo_id),
            lambda: protocol.read(servo_id, 56, 2),
            lambda: protocol.write(servo_id, 42, b"\x00"),
            lambda: protocol.sync_write(42, 1, [(servo_id, b"\x00")]),
            lambda: brand.request([servo_id], 2),
        ):
            with pytest.raises(ValueError, match=str(servo_id)):
                make()

    def test_a_group_is_of_different_servos(self, brand: Brand) -> None:
        for ids in ([], [1, 1]):
            with pytest.raises(ValueError, match="expected different ids"):
                brand.read(ids)
            with pytest.raises(ValueError, match="expected different ids"):
                brand.module.sync_write(42, 1, [(servo_id, b"\x00") for servo_id in ids])

    def test_a_bulk_read_is_refused_where_there_is_none(self, brand: Brand) -> None:
        if not (brand.module.BULK_READ or brand.bulk):  # of those with Dynamixel 1.0 only some have it
            with pytest.raises(ValueError, match="no bulk read"):
                brand.module.bulk_read([(1, 56, 2)], fast=False)

    def test_nobody_answers_a_broadcast_read(self, brand: Brand) -> None:
        with pytest.raises(ValueError, match="no servo answers a broadcast read"):
            brand.module.read(254, 56, 2)


class TestUsualReply:
    """A reply that is known at one look is what it would be if it were taken apart."""

    def test_the_data_lie_where_the_outline_says(self, brand: Brand) -> None:
        reply = brand.read(IDS)
        assert isinstance(reply, WholeReply)
        reply.feed(brand.answers(ANSWERS))
        assert reply.complete
        assert reply.whole is not None
        lead, before, after = reply.outline
        size = before + 4 + after
        found = [reply.whole[at + before : at + before + 4] for at in range(lead, lead + 3 * size, size)]
        assert found == [data for _, data in ANSWERS]
        assert reply.results == GOOD

    def test_one_with_a_garbled_bit_is_not(self, brand: Brand) -> None:
        good = brand.answers(ANSWERS)
        for bit in range(8 * len(good)):
            garbled = bytearray(good)
            garbled[bit // 8] ^= 1 << bit % 8
            reply, piecewise = brand.read(IDS), brand.read(IDS)
            assert isinstance(reply, WholeReply)
            reply.feed(bytes(garbled))
            assert reply.whole is None
            for byte in garbled:
                piecewise.feed(bytes((byte,)))
            assert reply.results == piecewise.results
            assert reply.results != GOOD

    def test_nor_is_one_from_another_servo_or_with_an_alert(self, brand: Brand) -> None:
        others = [brand.answers([ANSWERS[0], (6, ANSWERS[1][1]), ANSWERS[2]])]
        if brand.answers is not dynamixel_joint_status:
            others.append(b"".join(brand.status(*answer, alert=answer[0] == 2) for answer in ANSWERS))
        for data in others:
            reply = brand.read(IDS)
            assert isinstance(reply, WholeReply)
            reply.feed(data)
            assert reply.whole is None
            assert reply.results != GOOD
