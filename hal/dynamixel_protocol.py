"""Dynamixel Protocol 2.0, the host's side: frames <-> values. Pure: no I/O, no clock.

Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0". The frame, and what becomes of a garbled one:
`hal.dynamixel_frames`; the reply that many servos build together: `hal.joint_reply`.
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import Self

from hal.dynamixel_frames import (
    MAX_ID,
    MAX_LENGTH,
    MIN_LENGTH,
    OUTLINE,
    STATUS_OVERHEAD,
    Receiver,
    frame,
    usual_statuses,
)
from hal.dynamixel_instructions import DynamixelInstructions, Range
from hal.dynamixel_instructions import Keep as Keep
from hal.instructions import BROADCAST_ID as BROADCAST_ID
from hal.joint_reply import JOINT_OUTLINE, JointReply, usual_joint_reply
from hal.protocol import GroupReply, SeparateReplies
from hal.whole_reply import WholeReply

PING_SLOT_NS = 3_000_000  # what ROBOTIS's libraries allow for
BULK_READ = True


class ErrorNumber(IntEnum):
    """Why a servo refused an instruction: bits 0 to 6 of the error byte, a number and not flags."""

    description: str

    def __new__(cls, number: int, description: str) -> Self:
        """Make a member of the number on the wire and its meaning."""
        member = int.__new__(cls, number)
        member._value_ = number
        member.description = description
        return member

    RESULT_FAIL = 1, "the servo could not carry out the instruction"
    INSTRUCTION = 2, "the servo does not know the instruction, or an action had nothing registered"
    CRC = 3, "the instruction reached the servo garbled"
    DATA_RANGE = 4, "the value is outside the register's range, or the bus watchdog has tripped"
    DATA_LENGTH = 5, "the data is shorter than the register"
    DATA_LIMIT = 6, "the value is outside the limits that are set in the servo"
    ACCESS = 7, "the register is read-only or absent, or is locked while torque is on"


def describe_error(number: int) -> str:
    """Return in plain words what `Status.error` says, whether or not the protocol defines it."""
    if number == 0:
        return "no error"
    unknown = f"error number {number}, which the protocol does not define"
    return next((error.description for error in ErrorNumber if error == number), unknown)


_instructions = DynamixelInstructions(frame, max_id=MAX_ID, address_bytes=2, largest=MAX_LENGTH - MIN_LENGTH)
ping, reboot = _instructions.ping, _instructions.reboot  # the status of a ping names model and firmware
read, write = _instructions.read, _instructions.write
reg_write, action = _instructions.reg_write, _instructions.action
factory_reset, clear = _instructions.factory_reset_but, _instructions.clear
store_backup, restore_backup = _instructions.store_backup, _instructions.restore_backup
sync_write, bulk_write = _instructions.sync_write, _instructions.bulk_write
sync_writer = _instructions.sync_writer
sync_read, fast_sync_read = _instructions.sync_read, _instructions.fast_sync_read


def single_read(servo_id: int, address: int, length: int) -> tuple[bytes, GroupReply]:
    """Return a read of one servo, and what collects the answer."""
    return read(servo_id, address, length), _reply({servo_id: length}, fast=False)


def group_read(address: int, length: int, ids: Sequence[int], *, fast: bool) -> tuple[bytes, GroupReply]:
    """Return a fast sync read or a sync read, and what collects the answers."""
    request = fast_sync_read if fast else sync_read
    return request(address, length, ids), _reply(dict.fromkeys(ids, length), fast)


def bulk_read(items: Sequence[Range], *, fast: bool) -> tuple[bytes, GroupReply]:
    """Return a fast bulk read or a bulk read of each (id, address, length), and what collects the answers."""
    request = _instructions.fast_bulk_read if fast else _instructions.bulk_read
    return request(items), _reply({servo_id: length for servo_id, _, length in items}, fast)


def _reply(lengths: dict[int, int], fast: bool) -> GroupReply:
    ids, sizes = tuple(lengths), {*lengths.values()}
    careful = JointReply(lengths) if fast else SeparateReplies(
        Receiver(), ids, sum(lengths.values()) + len(ids) * STATUS_OVERHEAD)
    if len(sizes) > 1:
        return careful
    [length] = sizes
    if fast:
        return WholeReply(careful, JOINT_OUTLINE, usual_joint_reply(ids, length))
    return WholeReply(careful, OUTLINE, usual_statuses(ids, length))


def receiver() -> Receiver:
    """Return a new `Receiver`."""
    return Receiver()
