"""The device side of Feetech's protocol: all servos of one bus, STS and SCS, seen from the wire.

The frames are those of `checksum_frames`. Source: Feetech's FTServo SDK.

The error byte tells the servo's condition, and has no code for an instruction that is refused. What these servos do
not understand (a wrong checksum, an instruction or parameters that they do not know) they answer with silence here: a
plain status would say that all is well.
"""

from collections.abc import Sequence
from enum import IntEnum
from functools import partial

from sim_backend.checksum_frames import BROADCAST, LARGEST_DATA, RANGE, ChecksumParser, status
from sim_backend.device import (
    Packet,
    Reply,
    ServoDevice,
    answers_in_slots,
    answers_in_turn,
    sync_write_blocks,
)
from sim_backend.feetech_firmware import FeetechServo
from sim_backend.reply import collide


class Instruction(IntEnum):
    """The instructions that these servos know."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    RECOVERY = 0x06  # to the factory's settings
    REBOOT = 0x08
    RESET = 0x0A  # of the turns
    CALIBRATE = 0x0B
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83


class FeetechDevice(ServoDevice[FeetechServo]):
    """All servos of one bus. Both series share the frames, so that they may share a wire."""

    def __init__(self, servos: Sequence[FeetechServo]) -> None:
        super().__init__(servos, ChecksumParser())

    def _obey(self, packet: Packet, listening: list[FeetechServo], now: int, byte_ns: int) -> list[Reply]:
        return _answer(packet, listening, now, byte_ns) if packet.intact else []


def _answer(packet: Packet, listening: list[FeetechServo], now: int, byte_ns: int) -> list[Reply]:
    if packet.id != BROADCAST:
        return collide(_answer_one(packet, listening, now, byte_ns), byte_ns)
    match packet.instruction:
        case Instruction.PING:
            able = [servo for servo in listening if servo.knows_broadcast_ping]
            return answers_in_slots(able, lambda servo: status(servo.id, servo.error), byte_ns)
        case Instruction.SYNC_READ:
            return _sync_read(packet.parameters, listening, byte_ns)
        case Instruction.SYNC_WRITE:
            _sync_write(packet.parameters, listening)
        case _:
            for servo in listening:
                _execute(servo, packet, now)
    return []


def _answer_one(packet: Packet, listening: list[FeetechServo], now: int, byte_ns: int) -> list[Reply]:
    """Let the addressed servos obey; return the answer of each."""
    replies: list[Reply] = []
    for servo in listening:
        if servo.id != packet.id:
            continue
        # As they were before: a write may change these.
        answers = servo.answers_writes or packet.instruction in (Instruction.PING, Instruction.READ)
        delay, error, stores = servo.return_delay_ns, servo.error, servo.table.stores
        data = _execute(servo, packet, now)
        if not answers or data is None:
            continue
        delay += servo.eeprom_ns(stores)
        if reply := servo.answer(delay, partial(status, error=error, data=data), packet.id, byte_ns):
            replies.append(reply)
    return replies


def _execute(servo: FeetechServo, packet: Packet, now: int) -> bytes | None:
    """Return the data of the answer; None if the servo does not understand."""
    parameters = packet.parameters
    match packet.instruction:
        case Instruction.PING:
            pass
        case Instruction.READ if len(parameters) == RANGE.size:
            return _read(servo, parameters)
        case Instruction.WRITE if parameters:
            servo.write(parameters[0], parameters[1:])
        case Instruction.REG_WRITE if parameters:
            servo.register_write(parameters[0], parameters[1:])
        case Instruction.ACTION:
            servo.action()
        case Instruction.RECOVERY:
            servo.recover(now)
        case Instruction.REBOOT if servo.knows_reboot:
            servo.reboot(now)
        case Instruction.RESET:
            servo.clear_turns()
        case Instruction.CALIBRATE if servo.knows_calibrate:
            servo.calibrate()
        case _:
            return None
    return b""


def _read(servo: FeetechServo, what: bytes) -> bytes | None:
    address, length = RANGE.unpack(what)
    return servo.read(address, length) if length <= LARGEST_DATA else None


def _sync_read(parameters: bytes, listening: list[FeetechServo], byte_ns: int) -> list[Reply]:
    what, ids = parameters[:RANGE.size], parameters[RANGE.size:]

    def answer(servo: FeetechServo) -> bytes | None:
        if not servo.knows_sync_read:
            return None
        data = _read(servo, what)
        return None if data is None else status(servo.id, servo.error, data)

    return answers_in_turn(ids, listening, answer, byte_ns)


def _sync_write(parameters: bytes, listening: list[FeetechServo]) -> None:
    """Write to every listed servo."""
    if len(parameters) <= RANGE.size:
        return
    address, length = RANGE.unpack_from(parameters)
    blocks = sync_write_blocks(parameters[RANGE.size:], length)
    for servo in listening:
        if servo.id in blocks:
            servo.write(address, blocks[servo.id])
