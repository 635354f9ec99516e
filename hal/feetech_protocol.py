"""Feetech's protocol for the STS and SMS series, the host's side: frames <-> values. Pure: no I/O, no clock.

Source: Feetech, "Communication Protocol User Manual" (2019); limits and error bits: feetech-servo-sdk 1.0.0.

    FF FF | id | length L | instruction | parameters | checksum     an instruction
    FF FF | id | length L | error       | data       | checksum     a status
            1    1          1             L - 2        1 byte

L counts from instruction or error to the checksum inclusive. The checksum is the complement of the sum of all
bytes behind the header. Nothing is escaped: FF FF may occur in the data.

Nor does anything tell an instruction from a status: the echo of a ping of id 1 reads as "id 1, voltage".
On an adapter that echoes, the transport must take the echo out.

What `Receiver` makes of a garbled stream:

    noise, a run of FF              skipped up to the last FF FF
    an instruction to everybody     skipped: no status has its id
    impossible length or error      bad; goes on behind that FF FF at once
    wrong checksum                  bad; goes on behind that FF FF: a whole frame may lie inside
    half a frame                    kept for the next `feed`, until `reset`

The checksum finds any one garbled byte behind the length. But a garbled length slips through once in 256
times, and a lost header lets frames be found in the data. So where the length is known, as in a group read,
no other counts.
"""

import re
from collections.abc import Sequence
from enum import IntFlag

from hal.instructions import BROADCAST_ID as BROADCAST_ID
from hal.instructions import Instruction, Instructions
from hal.protocol import GroupReply, SeparateReplies, Status

MAX_ID = 253
PING_SLOT_NS = None  # not in Feetech's manual
MAX_FRAME = 250  # bytes; Feetech's SDK sends no more

_HEADER = re.compile(rb"\xff\xff(?![\xfe\xff])")  # not before an id that no status has
_ID, _LENGTH, _CODE, _BODY = 2, 3, 4, 5  # where they are in a frame; code: instruction or error
_OVERHEAD = 6  # bytes of a frame without parameters
_LONGEST_DATA = MAX_FRAME - _OVERHEAD
_LARGEST_ERROR = 0x7F  # Feetech's SDK believes no status with bit 7 of its error byte set


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


def _frame(servo_id: int, instruction: Instruction, parameters: bytes) -> bytes:
    size = _OVERHEAD + len(parameters)
    if size > MAX_FRAME:
        raise ValueError(f"a frame may be {MAX_FRAME} bytes long, not {size}: send less at once")
    body = bytes((servo_id, len(parameters) + 2, instruction)) + parameters
    return b"\xff\xff" + body + bytes((_checksum(body),))


_instructions = Instructions(_frame, max_id=MAX_ID, address_bytes=1, largest=_LONGEST_DATA)
ping, reboot = _instructions.ping, _instructions.reboot  # the manual lacks reboot, and a servo may not know it
read, write = _instructions.read, _instructions.write
reg_write, action = _instructions.reg_write, _instructions.action
sync_write, sync_read = _instructions.sync_write, _instructions.sync_read


def group_read(address: int, length: int, ids: Sequence[int], *, fast: bool) -> tuple[bytes, GroupReply]:
    """Return a sync read, and what collects the answers. There is no fast form."""
    if fast:
        raise ValueError("these servos have no fast sync read")
    return sync_read(address, length, ids), SeparateReplies(Receiver(length), ids, length + _OVERHEAD)


def receiver() -> "Receiver":
    """Return a new `Receiver` of statuses of any length."""
    return Receiver()


class Receiver:
    """Finds the statuses in a stream of bytes that may be garbled (see the module's list)."""

    def __init__(self, length: int | None = None) -> None:
        """Take statuses with `length` bytes of data only, or with any number."""
        self.bad_frames = 0
        self._lengths = range(_LONGEST_DATA + 1) if length is None else range(length, length + 1)
        self._pending = b""

    def reset(self) -> None:
        """Throw away half a frame that is waiting for its rest."""
        self._pending = b""

    def feed(self, data: bytes) -> list[Status]:
        """Take the next bytes of the stream, return the statuses that they complete."""
        stream = self._pending + data
        statuses: list[Status] = []
        position = 0
        while header := _HEADER.search(stream, position):
            start = header.start()
            end = self._frame_end(stream, start)
            if end > len(stream):
                self._pending = stream[start:]
                return statuses
            if end and _checksum(stream[start + _ID : end - 1]) == stream[end - 1]:
                alert = stream[start + _CODE] & _FAULTS != 0
                statuses.append(Status(stream[start + _ID], 0, alert, stream[start + _BODY : end - 1]))
                position = end
            else:
                self.bad_frames += 1
                position = header.end()
        # The last byte may be the beginning of a header.
        self._pending = stream[max(position, len(stream) - 1) :]
        return statuses

    def _frame_end(self, stream: bytes, start: int) -> int:
        """Return where the frame at `start` ends, be it behind the stream's end; 0 if it can be none."""
        received = len(stream) - start
        if received <= _LENGTH:
            return len(stream) + 1
        length = stream[start + _LENGTH] - 2
        if length not in self._lengths or (received > _CODE and stream[start + _CODE] > _LARGEST_ERROR):
            return 0
        return start + _OVERHEAD + length


def _checksum(body: bytes) -> int:
    return ~sum(body) & 0xFF
