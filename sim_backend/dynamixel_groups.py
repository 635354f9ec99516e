"""Instructions of Dynamixel Protocol 2.0 to many servos at once: each has a range of its own, or all the same one."""

import struct
from collections.abc import Iterator, Mapping
from contextlib import suppress

from fastcrc import crc16

from sim_backend.device import Reply, answers_in_turn, by_id, sync_write_blocks
from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.dynamixel_frames import BROADCAST, HEADER, STATUS, status
from sim_backend.dynamixel_instructions import RANGE, Instruction, execute
from sim_backend.dynamixel_table import StatusError
from sim_backend.reply import collide
from sim_backend.status_level import StatusReturnLevel

_ITEM = struct.Struct("<BHH")  # id, address, length
_LARGEST_FRAME = 0xFFFF  # what the two bytes of a length can say

Ranges = Mapping[int, bytes]  # by id, in the order of answers: address and length, packed


def sync_ranges(parameters: bytes) -> Ranges:
    """Return what a sync read asks of whom."""
    what, ids = parameters[:RANGE.size], parameters[RANGE.size:]
    return dict.fromkeys(ids, what)


def bulk_ranges(parameters: bytes) -> Ranges:
    """Return what a bulk read asks of whom: nothing unless it holds whole items; of an id named twice, the first."""
    ranges: dict[int, bytes] = {}
    if len(parameters) % _ITEM.size == 0:
        for at in range(0, len(parameters), _ITEM.size):
            ranges.setdefault(parameters[at], parameters[at + 1:at + _ITEM.size])
    return ranges


def read_in_turn(ranges: Ranges, listening: list[DynamixelServo], now: int, byte_ns: int) -> list[Reply]:
    """Let each servo answer with a status of its own, behind the one before it."""
    def answer(servo: DynamixelServo) -> bytes | None:
        if servo.status_return_level < StatusReturnLevel.READ:
            return None
        number, data = execute(servo, Instruction.READ, ranges[servo.id], now)
        return status(servo.id, number | servo.alert, data)

    return answers_in_turn(ranges, listening, answer, byte_ns)


def read_jointly(ranges: Ranges, listening: list[DynamixelServo], now: int, byte_ns: int) -> list[Reply]:
    """Let all servos build one frame together, without stuffing; it stops where one of them is silent.

    ... 55 | error, id, data, crc | error, id, data, crc | ...   Each CRC covers all bytes before it, as they were
    said: what a cable does to one block spoils no other's.
    """
    servos = by_id(listening)
    lengths = {servo_id: RANGE.unpack(what)[1] for servo_id, what in ranges.items()}
    size = 1 + sum(length + 4 for length in lengths.values())
    if not ranges or size > _LARGEST_FRAME:
        return []
    lead, delayed = HEADER + struct.pack("<BHB", BROADCAST, size, STATUS), True  # the first one's to say
    crc = crc16.umts(lead)
    heard: list[Reply] = []
    for servo_id, what in ranges.items():
        said = []
        for servo in servos.get(servo_id, ()):
            if not servo.fast_sync_read or servo.status_return_level < StatusReturnLevel.READ:
                continue
            number, data = execute(servo, Instruction.READ, what, now)
            block = bytes((number | servo.alert, servo_id)) + data.ljust(lengths[servo_id], b"\0")
            block += crc16.umts(block, crc).to_bytes(2, "little")
            reply = servo.utter(Reply(servo.return_delay_ns * delayed, lead + block))
            if reply is not None:
                said.append(reply)
        if not said:
            break
        heard += collide(said, byte_ns)
        crc, lead, delayed = crc16.umts(block, crc), b"", False
    return _joined(heard)


def _joined(replies: list[Reply]) -> list[Reply]:
    """Return bursts that follow each other without a pause as one."""
    joined: list[Reply] = []
    for reply in replies:
        if joined and not reply.delay_ns:
            joined[-1] = joined[-1]._replace(data=joined[-1].data + reply.data)
        else:
            joined.append(reply)
    return joined


def sync_write(parameters: bytes, listening: list[DynamixelServo]) -> None:
    """Write to every listed servo at one address."""
    if len(parameters) > RANGE.size:
        address, length = RANGE.unpack_from(parameters)
        blocks = sync_write_blocks(parameters[RANGE.size:], length)
        _write({servo_id: (address, data) for servo_id, data in blocks.items()}, listening)


def bulk_write(parameters: bytes, listening: list[DynamixelServo]) -> None:
    """Write to every listed servo at its own address: to none unless all items are whole."""
    with suppress(ValueError):
        _write(dict(_items(parameters)), listening)


def _items(parameters: bytes) -> Iterator[tuple[int, tuple[int, bytes]]]:
    at = 0
    while at < len(parameters):
        if at + _ITEM.size > len(parameters):
            raise ValueError("an item is cut short")
        servo_id, address, length = _ITEM.unpack_from(parameters, at)
        at += _ITEM.size + length
        if at > len(parameters):
            raise ValueError("an item is cut short")
        yield servo_id, (address, parameters[at - length:at])


def _write(items: Mapping[int | None, tuple[int, bytes]], listening: list[DynamixelServo]) -> None:
    """Nobody answers, so that a refusal goes unseen."""
    for servo in listening:
        for servo_id in (servo.id, servo.secondary_id):
            if servo_id in items:
                with suppress(StatusError):
                    servo.write(*items[servo_id], ram_only=servo_id != servo.id)
                break
