"""What is heard of servos that talk at once, and what a servo's answer meets on its way to the wire."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.dynamixel_protocol import Receiver
from robotwalk.assembly import load_servo
from sim_backend.brands import make_device, make_servo
from sim_backend.device import Device
from sim_backend.fake_servo import FakeServo
from sim_backend.reply import Reply, collide, misheard
from sim_backend.servo_physics import ServoPhysics

BYTE_NS = 10_000  # at 1 Mbaud
MS = 1_000_000
PING_STATUS = bytes.fromhex("FF FF FD 00 01 07 00 55 00 06 04 26 65 5D")
SYNC_READ = bytes.fromhex("FF FF FD 00 FE 0A 00 82 84 00 04 00 01 02 03 2A 6C")  # position of 1, 2 and 3
FAST_SYNC_READ = bytes.fromhex("FF FF FD 00 FE 0A 00 8A 84 00 04 00 01 02 03 1A EC")
FEETECH_SYNC_READ = bytes.fromhex("FF FF FE 07 82 38 02 01 02 03 38")


def test_one_alone_is_heard_as_it_is() -> None:
    assert collide([Reply(5, b"\xff\x00")], BYTE_NS) == [Reply(5, b"\xff\x00")]
    assert collide([], BYTE_NS) == []


def test_the_line_is_low_while_anybody_pulls_it_low() -> None:
    # 55 on the wire: 0 10101010 1; three bits later the same again.
    assert collide([Reply(0, b"\x55"), Reply(0, b"\x55")], BYTE_NS) == [Reply(0, b"\x01"), Reply(1_000, b"\xff")]


@given(st.lists(st.binary(min_size=1, max_size=40), min_size=2, max_size=4), st.data())
def test_a_collision_is_over_when_the_last_of_them_is_and_goes_by_nothing_but_its_bytes(
    frames: list[bytes], data: st.DataObject
) -> None:
    replies = [Reply(2_000 * data.draw(st.integers(0, 254)), frame) for frame in frames]
    heard = collide(replies, BYTE_NS)
    assert heard == collide(replies, BYTE_NS)
    assert all(reply.delay_ns >= 0 and reply.data for reply in heard)
    ends = sum(reply.delay_ns + len(reply.data) * BYTE_NS for reply in heard)
    last = max(reply.delay_ns + len(reply.data) * BYTE_NS for reply in replies)
    assert ends <= last + len(replies) * BYTE_NS


@given(st.integers(0, 254), st.integers(0, 254))
def test_no_host_takes_what_is_left_of_two_overlapping_statuses_for_one(first: int, second: int) -> None:
    heard = collide([Reply(2_000 * first, PING_STATUS), Reply(2_000 * second, PING_STATUS)], BYTE_NS)
    behind = abs(2_000 * (second - first) + 3_000) - len(PING_STATUS) * BYTE_NS
    statuses = Receiver().feed(b"".join(reply.data for reply in heard))
    if not -3 * BYTE_NS < behind < 0:  # or the stop bits of one may be all that the header of the other hides
        assert len(statuses) == (2 if behind >= 0 else 0)


def bus(name: str, **firmware: bool) -> tuple[list[FakeServo], Device]:
    """Servos 1, 2 and 3 at 1 Mbaud, without return delay."""
    model = load_servo(name)
    model = model.model_copy(update={"firmware": model.firmware.model_copy(update=firmware)})
    physics = ServoPhysics([model] * 3)
    baud = model.baud_value(1_000_000)
    servos = [make_servo(physics, i, id=i + 1, baud_rate=baud, return_delay_time=0) for i in range(3)]
    physics.step(np.zeros(3), np.zeros(3), 0)
    return servos, make_device("legs", servos)


def heard(device: Device, instruction: bytes) -> list[Reply]:
    return device.receive(instruction, 10 * MS, 1_000_000)


def swallow(reply: Reply) -> None:
    return None


def flip_first(reply: Reply) -> Reply:
    return reply._replace(data=bytes([reply.data[0] ^ 0x80]) + reply.data[1:])


def late(reply: Reply) -> Reply:
    return reply._replace(delay_ns=reply.delay_ns + 70_000)


@pytest.mark.parametrize(("name", "instruction"), [("xl430-w250", SYNC_READ), ("sts3215", FEETECH_SYNC_READ)])
@pytest.mark.parametrize(("patient", "left"), [(False, [0]), (True, [0, 2])])
def test_a_dropped_answer_is_a_silent_servo_to_those_behind(
    name: str, instruction: bytes, patient: bool, left: Sequence[int]
) -> None:
    servos, device = bus(name, later_ids_answer=patient)
    whole = heard(device, instruction)
    assert len(whole) == 3
    servos[1].interferences = [swallow]
    assert heard(device, instruction) == [whole[index] for index in left]


@pytest.mark.parametrize(("name", "instruction"), [("xl430-w250", SYNC_READ), ("sts3215", FEETECH_SYNC_READ)])
@pytest.mark.parametrize("change", [flip_first, late])
def test_those_behind_a_garbled_or_late_answer_go_on(
    name: str, instruction: bytes, change: Callable[[Reply], Reply]
) -> None:
    servos, device = bus(name)
    first, second, third = heard(device, instruction)
    servos[1].interferences = [change]
    assert heard(device, instruction) == [first, change(second), third]


def test_each_block_of_a_fast_read_is_one_answer() -> None:
    servos, device = bus("xl430-w250")
    [(_, frame)] = heard(device, FAST_SYNC_READ)
    assert len(frame) == 8 + 3 * 8
    servos[1].interferences = [flip_first]
    assert heard(device, FAST_SYNC_READ) == [
        Reply(0, frame[:16] + bytes([frame[16] ^ 0x80]) + frame[17:])], "the CRCs behind are as they were said"
    servos[1].interferences = [late]
    assert heard(device, FAST_SYNC_READ) == [Reply(0, frame[:16]), Reply(70_000, frame[16:])]
    servos[1].interferences = [swallow]
    assert heard(device, FAST_SYNC_READ) == [Reply(0, frame[:16])]
    servos[0].interferences = [swallow]
    assert heard(device, FAST_SYNC_READ) == []


def test_bytes_at_another_rate_are_heard_as_other_bytes() -> None:
    """Nine low bits at half the rate last for eighteen: a whole byte of them, and seven and a half of the next."""
    low = Reply(7, b"\0")
    assert misheard(low, 10_000, 10_000) is low
    assert misheard(low, 20_000, 10_000) == Reply(7, b"\x00\x80")
