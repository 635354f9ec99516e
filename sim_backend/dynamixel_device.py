"""The device side of Dynamixel Protocol 2.0: all servos of one bus, seen from the wire.

    FF FF FD 00 | id | length lo, hi | instruction | parameters | crc lo, hi
    FF FF FD 00 | id | length lo, hi | 55 | error | data | crc lo, hi              (status)

The length counts from the instruction on. From there to the parameters' end, FF FF FD is followed by an extra
FD (stuffing). The CRC covers the stuffed frame. Source: ROBOTIS e-Manual, Protocol 2.0.
"""

import struct
from collections.abc import Sequence
from contextlib import suppress
from enum import IntEnum

from fastcrc import crc16

from sim_backend.device import (
    InstructionParser,
    Packet,
    Reply,
    ServoDevice,
    answers_at_once,
    answers_in_slots,
    answers_in_turn,
    by_id,
    sync_write_blocks,
)
from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.dynamixel_table import ErrorNumber, StatusError
from sim_backend.reply import collide

BROADCAST = 0xFE
_HEADER = b"\xff\xff\xfd\x00"  # the reserved byte tells it from stuffed data
_STUFFED = (b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
_STATUS = 0x55
_PROLOGUE = 7  # bytes up to the length's end
_INVALID_IDS = (0xFD, 0xFF)
_LENGTHS = range(3, 1025)  # beyond: a false header in noise
_LARGEST_FRAME = 0xFFFF  # what the two bytes of a length can say
_RANGE = struct.Struct("<HH")  # address, length
_RESET_IDS_TOO = b"\xff"  # parameter of a factory reset


class Instruction(IntEnum):
    """The instructions that these servos know."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A


class StatusReturnLevel(IntEnum):
    """What is answered at all; a ping always is."""

    PING = 0
    READ = 1
    ALL = 2


_ANSWERED_FROM: dict[int, int] = {  # the others from ALL
    Instruction.PING: StatusReturnLevel.PING, Instruction.READ: StatusReturnLevel.READ}


class DynamixelParser(InstructionParser):
    """Finds frames of Protocol 2.0."""

    header = _HEADER
    prologue = _PROLOGUE

    def _next(self) -> Packet | None:
        buffer = self._buffer
        while self._align():
            end = _PROLOGUE + (buffer[5] | buffer[6] << 8)
            restart = buffer.find(_HEADER, len(_HEADER), min(end - 2, len(buffer)))
            if restart > 0:  # stuffing keeps headers out of a frame: this one was broken off
                del buffer[:restart]
                continue
            if len(buffer) < end:
                return None
            frame = bytes(buffer[:end])
            intact = crc16.umts(frame[:-2]) == frame[-2] | frame[-1] << 8
            del buffer[:end if intact else len(_HEADER)]
            body = frame[_PROLOGUE:-2].replace(_STUFFED[1], _STUFFED[0])
            return Packet(frame[4], body[0], body[1:], intact)
        return None

    def _plausible(self) -> bool:
        buffer = self._buffer
        return buffer[4] not in _INVALID_IDS and buffer[5] | buffer[6] << 8 in _LENGTHS


class DynamixelDevice(ServoDevice[DynamixelServo]):
    """All Dynamixel servos of one bus."""

    def __init__(self, servos: Sequence[DynamixelServo]) -> None:
        super().__init__(servos, DynamixelParser())

    def _obey(self, packet: Packet, listening: list[DynamixelServo], now: int, byte_ns: int) -> list[Reply]:
        if not packet.intact:
            return _report_bad_crc(packet, listening, byte_ns)
        if packet.instruction == _STATUS:
            return []
        for servo in listening:
            servo.hear(now)
        return _answer(packet, listening, now, byte_ns)


def _report_bad_crc(packet: Packet, listening: list[DynamixelServo], byte_ns: int) -> list[Reply]:
    addressed = [
        servo for servo in listening
        if servo.id == packet.id and servo.status_return_level == StatusReturnLevel.ALL]
    return answers_at_once(addressed, lambda servo: _status(servo.id, ErrorNumber.CRC | servo.alert), byte_ns)


def _answer(packet: Packet, listening: list[DynamixelServo], now: int, byte_ns: int) -> list[Reply]:
    if packet.id != BROADCAST:
        return collide(_answer_one(packet, listening, now), byte_ns)
    match packet.instruction:
        case Instruction.PING:
            return answers_in_slots(
                listening, lambda servo: _status(servo.id, servo.alert, servo.identify()), byte_ns)
        case Instruction.SYNC_READ:
            return _sync_read(packet.parameters, listening, now, byte_ns)
        case Instruction.FAST_SYNC_READ:
            return _fast_sync_read(packet.parameters, by_id(listening), now, byte_ns)
        case Instruction.SYNC_WRITE:
            _sync_write(packet.parameters, listening)
        case Instruction.FACTORY_RESET if packet.parameters == _RESET_IDS_TOO:
            pass  # refused: all servos would get one id
        case _:
            for servo in listening:
                _execute(servo, packet.instruction, packet.parameters, now)
    return []


def _answer_one(packet: Packet, listening: list[DynamixelServo], now: int) -> list[Reply]:
    """Let the addressed servos obey; return the answer of each. One that goes by its secondary id gives none."""
    replies: list[Reply] = []
    for servo in listening:
        if packet.id not in (servo.id, servo.secondary_id):
            continue
        # As they were before: a write may change these, and a reboot does.
        primary, level = packet.id == servo.id, servo.status_return_level
        alert, delay = servo.alert, servo.return_delay_ns
        number, data = _execute(servo, packet.instruction, packet.parameters, now)
        if not primary or level < _ANSWERED_FROM.get(packet.instruction, StatusReturnLevel.ALL):
            continue
        if reply := servo.utter(Reply(delay, _status(packet.id, number | alert, data))):
            replies.append(reply)
    return replies


def _execute(servo: DynamixelServo, instruction: int, parameters: bytes, now: int) -> tuple[int, bytes]:
    """Return the error number, 0 if none, and the data of the answer."""
    try:
        return 0, _perform(servo, instruction, parameters, now)
    except StatusError as refusal:
        return refusal.number, b""


def _perform(servo: DynamixelServo, instruction: int, parameters: bytes, now: int) -> bytes:
    match instruction:
        case Instruction.PING:
            return servo.identify()
        case Instruction.READ:
            if len(parameters) != _RANGE.size:
                raise StatusError(ErrorNumber.DATA_LENGTH)
            address, length = _RANGE.unpack(parameters)
            return servo.read(address, length, now)
        case Instruction.WRITE | Instruction.REG_WRITE:
            if len(parameters) < 2:
                raise StatusError(ErrorNumber.DATA_LENGTH)
            write = servo.write if instruction == Instruction.WRITE else servo.register_write
            write(int.from_bytes(parameters[:2], "little"), parameters[2:])
        case Instruction.ACTION:
            servo.action()
        case Instruction.FACTORY_RESET:
            if len(parameters) != 1:
                raise StatusError(ErrorNumber.DATA_LENGTH)
            servo.factory_reset(parameters[0], now)
        case Instruction.REBOOT:
            servo.reboot(now)
        case _:
            raise StatusError(ErrorNumber.INSTRUCTION)
    return b""


def _sync_read(parameters: bytes, listening: list[DynamixelServo], now: int, byte_ns: int) -> list[Reply]:
    if len(parameters) <= _RANGE.size:
        return []
    what, ids = parameters[:_RANGE.size], parameters[_RANGE.size:]

    def answer(servo: DynamixelServo) -> bytes | None:
        if servo.status_return_level < StatusReturnLevel.READ:
            return None
        number, data = _execute(servo, Instruction.READ, what, now)
        return _status(servo.id, number | servo.alert, data)

    return answers_in_turn(ids, listening, answer, byte_ns)


def _fast_sync_read(
    parameters: bytes, servos: dict[int, list[DynamixelServo]], now: int, byte_ns: int
) -> list[Reply]:
    """All servos build one frame together, without stuffing; it stops where one of them is silent.

    ... 55 | error, id, data, crc | error, id, data, crc | ...   Each CRC covers all bytes before it, as they were
    said: what a cable does to one block spoils no other's.
    """
    what, ids = parameters[:_RANGE.size], parameters[_RANGE.size:]
    if not ids:
        return []
    _, length = _RANGE.unpack(what)
    size = 1 + len(ids) * (length + 4)
    if size > _LARGEST_FRAME:
        return []
    lead, delayed = _HEADER + struct.pack("<BHB", BROADCAST, size, _STATUS), True  # the first one's to say
    crc = crc16.umts(lead)
    heard: list[Reply] = []
    for servo_id in ids:
        said = []
        for servo in servos.get(servo_id, ()):
            if not servo.fast_sync_read or servo.status_return_level < StatusReturnLevel.READ:
                continue
            number, data = _execute(servo, Instruction.READ, what, now)
            block = bytes((number | servo.alert, servo_id)) + data.ljust(length, b"\0")
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


def _sync_write(parameters: bytes, listening: list[DynamixelServo]) -> None:
    """Write to every listed servo. Nobody answers, so that a refusal goes unseen."""
    if len(parameters) <= _RANGE.size:
        return
    address, length = _RANGE.unpack_from(parameters)
    blocks = sync_write_blocks(parameters[_RANGE.size:], length)
    for servo in listening:
        data = blocks.get(servo.id)
        if data is None and servo.secondary_id is not None:
            data = blocks.get(servo.secondary_id)
        if data is not None:
            with suppress(StatusError):
                servo.write(address, data)


def _status(servo_id: int, error: int, data: bytes = b"") -> bytes:
    """Return a status packet."""
    body = (bytes((_STATUS, error)) + data).replace(*_STUFFED)
    frame = _HEADER + struct.pack("<BH", servo_id, len(body) + 2) + body
    return frame + crc16.umts(frame).to_bytes(2, "little")
