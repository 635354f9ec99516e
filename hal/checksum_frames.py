"""Frames that a one-byte checksum ends, which Dynamixel Protocol 1.0 and Feetech share. Pure: no I/O, no clock.

    FF FF | id | length L | instruction | parameters | checksum     an instruction
    FF FF | id | length L | error       | data       | checksum     a status
            1    1          1             L - 2        1 byte

L counts from instruction or error to the checksum inclusive. The checksum is the complement of the sum of all
bytes behind the header. Nothing is escaped: FF FF may occur in the data.

Nor does anything tell an instruction from a status: the echo of a ping of id 1 reads as "id 1, voltage".
On an adapter that echoes, the transport must take the echo out.

What a `StatusReceiver` makes of a garbled stream:

    noise, a run of FF              skipped up to the last FF FF
    an instruction to everybody     skipped: no status has its id
    impossible length or error      bad; goes on behind that FF FF at once
    wrong checksum                  bad; goes on behind that FF FF: a whole frame may lie inside
    half a frame                    kept for the next `feed`, until `reset`

The checksum finds any one garbled byte behind the length. But a garbled length slips through once in 256
times, and a lost header lets frames be found in the data. So where the length is known, as in a read of a group,
no other counts.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

from hal.instructions import Instruction
from hal.protocol import GroupReply, SeparateReplies, Status
from hal.whole_reply import Outline, WholeReply

MAX_ID = 253
MAX_FRAME = 250  # bytes; neither vendor's SDK sends more
OVERHEAD = 6  # bytes of a frame without parameters
LONGEST_DATA = MAX_FRAME - OVERHEAD

_HEADER = re.compile(rb"\xff\xff(?![\xfe\xff])")  # not before an id that no status has
_ID, _LENGTH, _CODE, _BODY = 2, 3, 4, 5  # where they are in a frame; code: instruction or error
_LARGEST_ERROR = 0x7F  # neither SDK believes a status with bit 7 of its error byte set


def frame(servo_id: int, instruction: Instruction, parameters: bytes) -> bytes:
    """Return the frame of an instruction. Raises ValueError if it gets too long."""
    size = OVERHEAD + len(parameters)
    if size > MAX_FRAME:
        raise ValueError(f"a frame may be {MAX_FRAME} bytes long, not {size}: send less at once")
    body = bytes((servo_id, len(parameters) + 2, instruction)) + parameters
    return b"\xff\xff" + body + bytes((_checksum(body),))


class StatusReceiver(ABC):
    """Finds the statuses in a stream of bytes that may be garbled (see the module's list)."""

    def __init__(self, length: int | None = None) -> None:
        """Take statuses with `length` bytes of data only, or with any number."""
        self.bad_frames = 0
        self._lengths = range(LONGEST_DATA + 1) if length is None else range(length, length + 1)
        self._pending = b""

    @abstractmethod
    def status(self, servo_id: int, error: int, data: bytes) -> Status:
        """Return what a status says whose error byte is `error`."""

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
                data = stream[start + _BODY : end - 1]
                statuses.append(self.status(stream[start + _ID], stream[start + _CODE], data))
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
        return start + OVERHEAD + length


def replies(receiver: StatusReceiver, ids: Sequence[int], length: int) -> GroupReply:
    """Return what collects a status with `length` bytes of data from each servo."""
    careful = SeparateReplies(receiver, ids, len(ids) * (OVERHEAD + length))
    return WholeReply(careful, Outline(0, _BODY, 1), _usual_statuses(ids, length))


def _usual_statuses(ids: Sequence[int], length: int) -> Callable[[bytes], bool]:
    """Return what tells whether statuses side by side are the usual: `length` bytes of each, and no error bit."""
    size = OVERHEAD + length
    frames = [
        (at, at + size, bytes((0xFF, 0xFF, servo_id, length + 2, 0)))
        for at, servo_id in zip(range(0, len(ids) * size, size), ids, strict=True)]

    def is_usual(data: bytes) -> bool:
        return all(
            data.startswith(head, start) and sum(data[start + _ID : end]) & 0xFF == 0xFF
            for start, end, head in frames)

    return is_usual


def _checksum(body: bytes) -> int:
    return ~sum(body) & 0xFF
