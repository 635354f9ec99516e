"""The device side of Dynamixel Protocol 2.0: all servos of one bus, seen from the wire.

Servos that have been told to speak Protocol 1.0 share the wire, each deaf to the other protocol.
Frames: `dynamixel_frames`. What one servo makes of an instruction: `dynamixel_instructions`. Reads and writes of many
servos: `dynamixel_groups`. Source: ROBOTIS e-Manual, Protocol 2.0.
"""

from collections.abc import Sequence
from functools import partial

from sim_backend.device import Packet, Reply, ServoDevice, answers_at_once, answers_in_slots
from sim_backend.dynamixel1_device import Dynamixel1Device
from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.dynamixel_first_protocol import FirstProtocol
from sim_backend.dynamixel_frames import BROADCAST, STATUS, DynamixelParser, status
from sim_backend.dynamixel_groups import (
    bulk_ranges,
    bulk_write,
    read_in_turn,
    read_jointly,
    sync_ranges,
    sync_write,
)
from sim_backend.dynamixel_instructions import Instruction, execute
from sim_backend.dynamixel_table import ErrorNumber
from sim_backend.reply import collide
from sim_backend.status_level import StatusReturnLevel, answers

_PROTOCOL = 2
_RESET_IDS_TOO = b"\xff"  # parameter of a factory reset


class DynamixelDevice(ServoDevice[DynamixelServo]):
    """All Dynamixel servos of one bus."""

    def __init__(self, servos: Sequence[DynamixelServo]) -> None:
        super().__init__(servos, DynamixelParser())
        self._protocol_1 = Dynamixel1Device([FirstProtocol(servo) for servo in servos])

    def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
        """Take bytes, the last of which arrives at `now` ns; return what is answered, in order."""
        # Before the others: an instruction may change the protocol, and is not to be heard twice.
        first = self._protocol_1.receive(data, now, baud) if any(s.protocol == 1 for s in self._servos) else []
        return first + super().receive(data, now, baud)

    def _obey(self, packet: Packet, listening: list[DynamixelServo], now: int, byte_ns: int) -> list[Reply]:
        listening = [servo for servo in listening if servo.protocol == _PROTOCOL]
        if not packet.intact:
            return _report_bad_crc(packet, listening, byte_ns)
        if packet.instruction == STATUS:
            return []
        for servo in listening:
            servo.hear(now)
        return _answer(packet, listening, now, byte_ns)


def _report_bad_crc(packet: Packet, listening: list[DynamixelServo], byte_ns: int) -> list[Reply]:
    addressed = [
        servo for servo in listening
        if servo.id == packet.id and servo.status_return_level == StatusReturnLevel.ALL]
    return answers_at_once(addressed, lambda servo: status(servo.id, ErrorNumber.CRC | servo.alert), byte_ns)


def _answer(packet: Packet, listening: list[DynamixelServo], now: int, byte_ns: int) -> list[Reply]:
    if packet.id != BROADCAST:
        return collide(_answer_one(packet, listening, now, byte_ns), byte_ns)
    parameters = packet.parameters
    match packet.instruction:
        case Instruction.PING:
            return answers_in_slots(
                listening, lambda servo: status(servo.id, servo.alert, servo.identify()), byte_ns)
        case Instruction.SYNC_READ:
            return read_in_turn(sync_ranges(parameters), listening, now, byte_ns)
        case Instruction.BULK_READ:
            return read_in_turn(bulk_ranges(parameters), listening, now, byte_ns)
        case Instruction.FAST_SYNC_READ:
            return read_jointly(sync_ranges(parameters), listening, now, byte_ns)
        case Instruction.FAST_BULK_READ:
            return read_jointly(bulk_ranges(parameters), listening, now, byte_ns)
        case Instruction.SYNC_WRITE:
            sync_write(parameters, listening)
        case Instruction.BULK_WRITE:
            bulk_write(parameters, listening)
        case _:
            all_ids = packet.instruction == Instruction.FACTORY_RESET and parameters == _RESET_IDS_TOO
            for servo in listening:
                if not (all_ids and servo.keeps_own_id):
                    execute(servo, packet.instruction, parameters, now)
    return []


def _answer_one(packet: Packet, listening: list[DynamixelServo], now: int, byte_ns: int) -> list[Reply]:
    """Let the addressed servos obey; return the answer of each.

    One that goes by its secondary id gives none, and lets nobody write its EEPROM (e-Manual, Secondary ID).
    """
    replies: list[Reply] = []
    for servo in listening:
        if packet.id not in (servo.id, servo.secondary_id):
            continue
        # As they were before: a write may change these, and a reboot does.
        primary, level = packet.id == servo.id, servo.status_return_level
        alert, delay = servo.alert, servo.return_delay_ns
        number, data = execute(servo, packet.instruction, packet.parameters, now, ram_only=not primary)
        if not primary or not answers(level, packet.instruction):
            continue
        if reply := servo.answer(delay, partial(status, error=number | alert, data=data), packet.id, byte_ns):
            replies.append(reply)
    return replies
