"""The instructions of Dynamixel Protocol 2.0, as one servo obeys them.

What the e-Manual leaves open: parameters of the wrong length are a data length error, an unknown option or a wrong
key a data range error.
"""

import struct
from enum import IntEnum

from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.dynamixel_table import ErrorNumber, StatusError

RANGE = struct.Struct("<HH")  # address, length
_CLEAR_POSITION = b"\x01\x44\x58\x4c\x22"
_STORE, _RESTORE = b"\x01CTRL", b"\x02CTRL"


class Instruction(IntEnum):
    """The instructions that these servos know, some of them from a version of their firmware on."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    CLEAR = 0x10
    CONTROL_TABLE_BACKUP = 0x20
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A
    BULK_READ = 0x92
    BULK_WRITE = 0x93
    FAST_BULK_READ = 0x9A


def execute(
    servo: DynamixelServo, instruction: int, parameters: bytes, now: int, *, ram_only: bool = False
) -> tuple[int, bytes]:
    """Return the error number, 0 if none, and the data of the answer; `ram_only` keeps writes off the EEPROM."""
    try:
        return 0, _perform(servo, instruction, parameters, now, ram_only)
    except StatusError as refusal:
        return refusal.number, b""


def _perform(servo: DynamixelServo, instruction: int, parameters: bytes, now: int, ram_only: bool) -> bytes:
    match instruction:
        case Instruction.PING:
            return servo.identify()
        case Instruction.READ:
            if len(parameters) != RANGE.size:
                raise StatusError(ErrorNumber.DATA_LENGTH)
            address, length = RANGE.unpack(parameters)
            return servo.read(address, length, now)
        case Instruction.WRITE | Instruction.REG_WRITE:
            if len(parameters) < 2:
                raise StatusError(ErrorNumber.DATA_LENGTH)
            write = servo.write if instruction == Instruction.WRITE else servo.register_write
            write(int.from_bytes(parameters[:2], "little"), parameters[2:], ram_only=ram_only)
        case Instruction.ACTION:
            servo.action()
        case Instruction.FACTORY_RESET:
            if len(parameters) != 1:
                raise StatusError(ErrorNumber.DATA_LENGTH)
            servo.factory_reset(parameters[0], now)
        case Instruction.REBOOT:
            servo.reboot(now)
        case Instruction.CLEAR:
            _choose(parameters, _CLEAR_POSITION)
            servo.clear_turns()
        case Instruction.CONTROL_TABLE_BACKUP if servo.keeps_backup:
            if _choose(parameters, _STORE, _RESTORE) == _STORE:
                servo.store_backup()
            else:
                servo.restore_backup(now)
        case _:
            raise StatusError(ErrorNumber.INSTRUCTION)
    return b""


def _choose(parameters: bytes, *options: bytes) -> bytes:
    if len(parameters) != len(options[0]):
        raise StatusError(ErrorNumber.DATA_LENGTH)
    if parameters not in options:
        raise StatusError(ErrorNumber.DATA_RANGE)
    return parameters
