"""Feetech's protocol for the STS, SMS and SCS series, the host's side: frames <-> values. Pure: no I/O, no clock.

Source: Feetech, "Communication Protocol User Manual" (2019); limits and error bits: feetech-servo-sdk 1.0.0.
The frame, and what becomes of a garbled one: `hal.checksum_frames`.
"""

from collections.abc import Sequence
from enum import IntFlag

from hal.checksum_frames import LONGEST_DATA, MAX_ID, StatusReceiver, frame, replies
from hal.instructions import BROADCAST_ID as BROADCAST_ID
from hal.instructions import Instructions
from hal.protocol import GroupReply, Status

PING_SLOT_NS = None  # not in Feetech's manual
BULK_READ = False


class Fault(IntFlag):
    """What is wrong with a servo: bits of the error byte, and of register 65.

    Bit 0x10 is left out: sources disagree on it, and one takes it for "torque is on".
    """

    VOLTAGE = 0x01
    SENSOR = 0x02
    TEMPERATURE = 0x04
    CURRENT = 0x08
    OVERLOAD = 0x20


_FAULTS = sum(Fault)


def describe_error(number: int) -> str:
    """Return "no error" for 0, and there is nothing else: a servo never says whether it obeyed."""
    return f"error number {number}, which the protocol does not define" if number else "no error"


_instructions = Instructions(frame, max_id=MAX_ID, address_bytes=1, largest=LONGEST_DATA)
ping, reboot = _instructions.ping, _instructions.reboot  # the manual lacks reboot, and a servo may not know it
read, write = _instructions.read, _instructions.write
reg_write, action = _instructions.reg_write, _instructions.action
factory_reset, reset_turns = _instructions.factory_reset, _instructions.reset_turns
calibrate = _instructions.calibrate  # recent STS firmware knows it
sync_write, sync_read = _instructions.sync_write, _instructions.sync_read
sync_writer = _instructions.sync_writer


def single_read(servo_id: int, address: int, length: int) -> tuple[bytes, GroupReply]:
    """Return a read of one servo, and what collects the answer."""
    return read(servo_id, address, length), replies(Receiver(length), (servo_id,), length)


def group_read(address: int, length: int, ids: Sequence[int], *, fast: bool) -> tuple[bytes, GroupReply]:
    """Return a sync read, and what collects the answers. There is no fast form; SCS servos do not know it at all."""
    if fast:
        raise ValueError("these servos have no fast sync read")
    return sync_read(address, length, ids), replies(Receiver(length), ids, length)


def bulk_read(items: Sequence[tuple[int, int, int]], *, fast: bool) -> tuple[bytes, GroupReply]:
    """Raise ValueError: there is no such instruction."""
    raise ValueError("these servos have no bulk read")


def receiver() -> "Receiver":
    """Return a new `Receiver` of statuses of any length."""
    return Receiver()


class Receiver(StatusReceiver):
    """Finds the statuses in a stream of bytes that may be garbled."""

    def status(self, servo_id: int, error: int, data: bytes) -> Status:
        """Return what a status says: its error byte tells of faults, never of a refusal."""
        return Status(servo_id, 0, error & _FAULTS != 0, data)
