"""Traffic in words, whole or garbled, with its directions known or listened to."""

from collections.abc import Iterable
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal import dynamixel_protocol, feetech_protocol
from hal.frame_splitter import Frame, Splitter
from hal.maintenance.transcript import Said, Transcriber
from hal.protocols import protocol_of
from hal.register_map import ServoModel
from robotwalk.assembly import load_servo
from sim_backend.brands import make_device, make_servo
from sim_backend.device import Device
from sim_backend.servo_physics import ServoPhysics

XL430, STS, AX, SCS = map(load_servo, ("xl430-w250", "sts3215", "ax-12a", "scs15"))
EACH = pytest.mark.parametrize("model", [XL430, STS, AX, SCS], ids=lambda model: model.name)


def words(said: Iterable[Said]) -> list[str]:
    return [f"{one.kind}: {one.words}" for one in said]


def bus(model: ServoModel, *ids: int) -> Device:
    physics = ServoPhysics([model] * len(ids))
    return make_device("test", [
        make_servo(physics, i, id=servo_id, baud_rate=model.baud_value(1_000_000), return_delay_time=0)
        for i, servo_id in enumerate(ids)])


def conversation(model: ServoModel, *instructions: bytes) -> list[tuple[bool, bytes]]:
    """Return what went over the wire, and whether the host sent it."""
    device, now, said = bus(model, 1, 2), 10_000_000, []
    for instruction in instructions:
        said.append((True, instruction))
        now += 10_000_000
        said += [(False, reply.data) for reply in device.receive(instruction, now, 1_000_000)]
    return said


def questions(model: ServoModel) -> list[bytes]:
    protocol, position, enable = protocol_of(model), model[model.cyclic.position], model["torque_enable"]
    return [
        protocol.ping(1), protocol.read(2, position.address, position.size), protocol.write(1, enable.address, b"\1"),
        protocol.read(1, enable.address, 1), protocol.ping(9), protocol.ping(9),
        protocol.sync_write(enable.address, 1, [(1, b"\0"), (2, b"\0")])]


@EACH
@pytest.mark.parametrize("directions", ["known", "heard by a third"])
def test_a_conversation_is_told_in_words_whoever_listens(model: ServoModel, directions: str) -> None:
    transcriber = Transcriber(model.protocol, {1: model, 2: model})
    told: list[str] = []
    for sent, data in conversation(model, *questions(model)):
        told += words(transcriber.take(data, sent if directions == "known" else None))
    position, centre = model.cyclic.position, model.encoder.centre
    two = model is XL430
    unit = model[position].unit
    assert told == [
        "instruction: ping 1", "status: 1 is there" + (": model 1060, firmware 45" if two else ""),
        f"instruction: read 2: {position}", f"status: 2 {position} = {centre} {unit}",
        "instruction: write 1: torque_enable = 1", "status: 1 agrees",
        "instruction: read 1: torque_enable", "status: 1 torque_enable = 1",
        "instruction: ping 9", "instruction: ping 9",
        "instruction: sync write: 1 torque_enable = 0; 2 torque_enable = 0"]


def test_the_blocks_of_a_joint_reply_are_told_one_by_one() -> None:
    request = dynamixel_protocol.fast_sync_read(132, 4, (1, 2))
    transcriber = Transcriber("dynamixel-2.0", {1: XL430, 2: XL430})
    told = [word for sent, data in conversation(XL430, request) for word in words(transcriber.take(data, sent))]
    assert told == [
        "instruction: fast sync read 1, 2: present_position",
        "status: 1 present_position = 2048 pulse; 2 present_position = 2048 pulse"]


def test_a_refusal_is_told_with_its_reason() -> None:
    transcriber = Transcriber("dynamixel-2.0", {1: XL430})
    told = [
        word for sent, data in conversation(XL430, dynamixel_protocol.write(1, 132, bytes(4)))
        for word in words(transcriber.take(data, sent))]
    assert told[1] == (
        "status: 1 refuses: the register is read-only or absent, or is locked while torque is on")


def test_registers_of_an_unknown_servo_are_told_by_number() -> None:
    transcriber = Transcriber("feetech-sts", {})
    assert words(transcriber.take(feetech_protocol.read(7, 56, 2), True)) == ["instruction: read 7: 2 bytes from 56"]
    assert words(transcriber.take(bytes.fromhex("FF FF 07 04 00 00 08 EC"), False)) == ["status: 7 00 08 at 56"]


def test_what_is_no_frame_is_shown_as_such() -> None:
    transcriber = Transcriber("dynamixel-2.0", {})
    ping = dynamixel_protocol.ping(1)
    bad = ping[:-1] + bytes((ping[-1] ^ 1,))
    told = [*transcriber.take(b"\x01\x02" + bad + ping + ping[:5], True), *transcriber.end()]
    assert [(said.kind, said.raw) for said in told] == [
        ("garbage", b"\x01\x02"), ("garbage", bad), ("instruction", ping), ("garbage", ping[:5])]
    assert [said.words.split(":")[0] for said in told if said.kind == "garbage"] == [
        "2 bytes, no header", "10 bytes, wrong CRC", "5 bytes, it breaks off"]


@EACH
@given(seed=st.integers(0, 2**32), noise=st.lists(st.binary(max_size=20), min_size=8, max_size=8))
def test_no_byte_is_lost_however_the_stream_is_cut_and_frames_behind_noise_are_found(
    model: ServoModel, seed: int, noise: list[bytes]
) -> None:
    chance = Random(seed)
    frames = [protocol_of(model).ping(chance.randrange(250)) for _ in range(7)]
    # A header's bytes in the noise may begin a frame that swallows ours; nothing can tell.
    quiet = [part.replace(b"\xff", b"\0") for part in noise]
    stream = b"".join(part for pair in zip(quiet, [*frames, b""], strict=True) for part in pair)
    splitter, pieces = Splitter(model.protocol), []
    while stream:
        cut = chance.randint(1, len(stream))
        pieces += splitter.feed(stream[:cut])
        stream = stream[cut:]
    pieces += splitter.flush()
    assert b"".join(piece.raw for piece in pieces) == b"".join(
        part for pair in zip(quiet, [*frames, b""], strict=True) for part in pair)
    assert [piece.raw for piece in pieces if isinstance(piece, Frame)] == frames


@EACH
@given(data=st.binary(max_size=200))
def test_nothing_that_may_come_confuses_it(model: ServoModel, data: bytes) -> None:
    transcriber = Transcriber(model.protocol, dict.fromkeys(range(253), model))
    told = [*transcriber.take(data), *transcriber.end()]
    assert b"".join(said.raw for said in told) == data
