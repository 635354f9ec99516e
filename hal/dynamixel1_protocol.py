"""Dynamixel Protocol 1.0, the host's side: frames <-> values. Pure: no I/O, no clock.

Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 1.0"; limits: dynamixel-sdk 4.1.0.
The frame, and what becomes of a garbled one: `hal.checksum_frames`.

The error byte is a set of bits, of two kinds. A condition of the servo comes back with every answer while it lasts,
and the data is valid all the same: an alert. A refusal concerns the instruction that is answered: an error.
"""

from collections.abc import Sequence
from enum import IntFlag

from hal.checksum_frames import LONGEST_DATA, MAX_ID, StatusReceiver, frame, replies
from hal.instructions import BROADCAST_ID as BROADCAST_ID
from hal.instructions import Instruction, Instructions
from hal.protocol import GroupReply, Status

PING_SLOT_NS = None  # a broadcast gets no answer
BULK_READ = False  # the AX series has none; who knows that it is an MX may still call `bulk_read`

_BULK_READ_HEAD = b"\x00"  # before the items


class Condition(IntFlag):
    """What is wrong with a servo."""

    VOLTAGE = 0x01
    OVERHEATING = 0x04
    OVERLOAD = 0x20


class Refusal(IntFlag):
    """Why a servo did not obey."""

    ANGLE_LIMIT = 0x02
    RANGE = 0x08
    CHECKSUM = 0x10
    INSTRUCTION = 0x40


_CONDITIONS, _REFUSALS = sum(Condition), sum(Refusal)
_MEANINGS = {
    Refusal.ANGLE_LIMIT: "the goal lies outside the angle limits that are set in the servo",
    Refusal.RANGE: "the value or the address is outside the range that the servo allows",
    Refusal.CHECKSUM: "the instruction reached the servo garbled",
    Refusal.INSTRUCTION: "the servo does not know the instruction, or an action had nothing registered",
}


def describe_error(number: int) -> str:
    """Return in plain words what `Status.error` says, whether or not the protocol defines it."""
    if number & ~_REFUSALS:
        return f"error number {number}, which the protocol does not define"
    return "; ".join(meaning for bit, meaning in _MEANINGS.items() if number & bit) or "no error"


_instructions = Instructions(frame, max_id=MAX_ID, address_bytes=1, largest=LONGEST_DATA)
ping, reboot = _instructions.ping, _instructions.reboot  # AX servos do not know reboot
read, write = _instructions.read, _instructions.write
reg_write, action = _instructions.reg_write, _instructions.action
sync_write = _instructions.sync_write
sync_writer = _instructions.sync_writer


def single_read(servo_id: int, address: int, length: int) -> tuple[bytes, GroupReply]:
    """Return a read of one servo, and what collects the answer."""
    return read(servo_id, address, length), replies(Receiver(length), (servo_id,), length)


def group_read(address: int, length: int, ids: Sequence[int], *, fast: bool) -> tuple[bytes, GroupReply]:
    """Raise ValueError: no instruction of this protocol reads many servos, but for the MX series' bulk read."""
    raise ValueError("Dynamixel Protocol 1.0 has no sync read: read each servo by itself")


def bulk_read(items: Sequence[tuple[int, int, int]], *, fast: bool = False) -> tuple[bytes, GroupReply]:
    """Return a bulk read of each (id, address, length), and what collects the answers. MX series only; none is fast.

    The protocol would let lengths differ. One that is known beforehand keeps garbled ones out.

    Raises:
        ValueError: it cannot be sent.
    """
    if fast:
        raise ValueError("these servos have no fast bulk read")
    ids, lengths = [servo_id for servo_id, _, _ in items], {length for _, _, length in items}
    _instructions.check_ids(ids, 3)
    if len(lengths) > 1:
        raise ValueError(f"expected one length for all servos, got {sorted(lengths)}")
    [length] = lengths
    if not 0 < length <= LONGEST_DATA or any(not 0 <= address <= 256 - length for _, address, _ in items):
        raise ValueError(f"there is no range of {length} bytes at each of {[address for _, address, _ in items]}")
    ranges = b"".join(bytes((length, servo_id, address)) for servo_id, address, _ in items)
    request = frame(BROADCAST_ID, Instruction.BULK_READ, _BULK_READ_HEAD + ranges)
    return request, replies(Receiver(length), ids, length)


def receiver() -> "Receiver":
    """Return a new `Receiver` of statuses of any length."""
    return Receiver()


class Receiver(StatusReceiver):
    """Finds the statuses in a stream of bytes that may be garbled."""

    def status(self, servo_id: int, error: int, data: bytes) -> Status:
        """Return what a status says: its error byte tells conditions from refusals."""
        return Status(servo_id, error & _REFUSALS, error & _CONDITIONS != 0, data)
