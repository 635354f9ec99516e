"""The device side of Dynamixel Protocol 1.0: all its servos on one bus, seen from the wire.

The frames are those of `checksum_frames`. A broadcast gets no answer, not even a ping, but for the bulk read, which the
AX series does not know. Source: ROBOTIS e-Manual, Protocol 1.0.
"""

import struct
from collections.abc import Sequence
from enum import IntEnum
from functools import partial

from sim_backend.ax_table import Refusal, RefusedError
from sim_backend.checksum_frames import BROADCAST, LARGEST_DATA, RANGE, ChecksumParser, status
from sim_backend.device import (
    Packet,
    Reply,
    ServoDevice,
    answers_at_once,
    answers_in_turn,
    sync_write_blocks,
)
from sim_backend.dynamixel1_servo import Protocol1Servo
from sim_backend.reply import collide
from sim_backend.status_level import StatusReturnLevel, answers

_ITEM = struct.Struct("BBB")  # of a bulk read: length, id, address


class Instruction(IntEnum):
    """The instructions that these servos know."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    SYNC_WRITE = 0x83
    BULK_READ = 0x92


class Dynamixel1Device(ServoDevice[Protocol1Servo]):
    """All servos of one bus that speak this protocol."""

    def __init__(self, servos: Sequence[Protocol1Servo]) -> None:
        super().__init__(servos, ChecksumParser())

    def _obey(self, packet: Packet, listening: list[Protocol1Servo], now: int, byte_ns: int) -> list[Reply]:
        if packet.intact:
            for servo in listening:
                servo.hear(now)
        else:
            return _report_bad_checksum(packet, listening, byte_ns)
        if packet.id != BROADCAST:
            return collide(_answer(packet, listening, now, byte_ns), byte_ns)
        if packet.instruction == Instruction.BULK_READ:
            return _bulk_read(packet.parameters, listening, now, byte_ns)
        if packet.instruction == Instruction.SYNC_WRITE:
            _sync_write(packet.parameters, listening)
        else:
            for servo in listening:
                _execute(servo, packet, now)
        return []


def _report_bad_checksum(packet: Packet, listening: list[Protocol1Servo], byte_ns: int) -> list[Reply]:
    addressed = [
        servo for servo in listening
        if servo.id == packet.id and servo.status_return_level == StatusReturnLevel.ALL]
    return answers_at_once(
        addressed, lambda servo: status(servo.id, Refusal.CHECKSUM | servo.conditions), byte_ns)


def _answer(packet: Packet, listening: list[Protocol1Servo], now: int, byte_ns: int) -> list[Reply]:
    """Let the addressed servos obey; return the answer of each."""
    replies: list[Reply] = []
    for servo in listening:
        if servo.id != packet.id:
            continue
        # As they were before: a write may change these.
        level, delay = servo.status_return_level, servo.return_delay_ns
        error, data = _execute(servo, packet, now)
        if not answers(level, packet.instruction):
            continue
        if reply := servo.answer(delay, partial(status, error=error, data=data), packet.id, byte_ns):
            replies.append(reply)
    return replies


def _execute(servo: Protocol1Servo, packet: Packet, now: int) -> tuple[int, bytes]:
    """Return the error byte and the data of the answer."""
    conditions = servo.conditions
    try:
        return conditions, _carry_out(servo, packet.instruction, packet.parameters, now)
    except RefusedError as refused:
        return conditions | refused.bits, b""


def _carry_out(servo: Protocol1Servo, instruction: int, parameters: bytes, now: int) -> bytes:
    """Return the data of the answer.

    Raises:
        RefusedError: the servo does not obey.
    """
    match instruction:
        case Instruction.PING:
            pass
        case Instruction.READ if len(parameters) == RANGE.size:
            address, length = RANGE.unpack(parameters)
            return servo.read(address, min(length, LARGEST_DATA))
        case Instruction.WRITE if parameters:
            servo.write(parameters[0], parameters[1:])
        case Instruction.REG_WRITE if parameters:
            servo.register_write(parameters[0], parameters[1:])
        case Instruction.ACTION:
            servo.action()
        case Instruction.FACTORY_RESET:
            servo.factory_reset(now)
        case Instruction.REBOOT if servo.knows_reboot:
            servo.reboot(now)
        case _:
            raise RefusedError(Refusal.INSTRUCTION)
    return b""


def _bulk_read(
    parameters: bytes, listening: list[Protocol1Servo], now: int, byte_ns: int
) -> list[Reply]:
    """Let each servo listed answer with its own range; of one that is listed twice, the first counts."""
    if parameters[:1] != b"\0" or len(parameters) % _ITEM.size != 1:
        return []
    ranges: dict[int, bytes] = {}
    for length, servo_id, address in _ITEM.iter_unpack(parameters[1:]):
        ranges.setdefault(servo_id, bytes((address, length)))

    def answer(servo: Protocol1Servo) -> bytes | None:
        if not servo.knows_bulk_read or servo.status_return_level < StatusReturnLevel.READ:
            return None
        return status(servo.id, *_execute(servo, Packet(servo.id, Instruction.READ, ranges[servo.id]), now))

    return answers_in_turn(ranges, listening, answer, byte_ns)


def _sync_write(parameters: bytes, listening: list[Protocol1Servo]) -> None:
    """Write to every listed servo; nobody tells whether it took it."""
    if len(parameters) <= RANGE.size:
        return
    address, length = RANGE.unpack_from(parameters)
    blocks = sync_write_blocks(parameters[RANGE.size:], length)
    for servo in listening:
        if servo.id in blocks:
            _execute(servo, Packet(servo.id, Instruction.WRITE, bytes((address,)) + blocks[servo.id]), 0)
