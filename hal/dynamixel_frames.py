"""The frames of Dynamixel Protocol 2.0, the host's side. Pure: no I/O, no clock.

Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0".

    FF FF FD 00 | id | length L | instruction | parameters             | CRC     an instruction
    FF FF FD 00 | id | length L | 55          | error | parameters     | CRC     a status
    '- header -'  1    2          1             <--- L - 3 bytes ----->  2       two bytes: low one first

L counts from the instruction to the CRC inclusive. Between instruction and CRC an FD is stuffed behind every
FF FF FD, so that no header occurs there. The CRC covers everything before it, stuffing included.

What `Receiver` makes of a garbled stream:

    noise, FF FF FD FD              skipped up to the next header
    impossible id or length         bad; goes on behind that header at once
    wrong CRC                       bad; goes on behind that header: a whole frame may lie inside
    a header before a frame's end   bad: the frame was cut short; goes on at the new header
    an instruction (an echo)        dropped
    a status of id FE               dropped: the answer to a fast read, which came too late
    half a frame                    kept for the next `feed`, until `reset`
"""

from collections.abc import Callable, Sequence
from struct import Struct

from fastcrc.crc16 import umts as crc16

from hal.instructions import BROADCAST_ID, Instruction
from hal.protocol import Status
from hal.whole_reply import Outline

MAX_ID = 252
MAX_LENGTH = 1024  # our limit for L; no X-series control table is longer (e-Manual: it ends at 661)
MIN_LENGTH = 3  # instruction and CRC
STATUS_OVERHEAD = 11  # bytes of a status without parameters
STATUS = 0x55
ALERT = 0x80
HEADER = b"\xff\xff\xfd\x00"
HEAD = Struct("<4sBH")  # header, id, length
OUTLINE = Outline(0, HEAD.size + 2, 2)  # of statuses side by side
_UINT16 = Struct("<H")


def frame(servo_id: int, instruction: Instruction, parameters: bytes) -> bytes:
    """Return the frame of an instruction. Raises ValueError if it gets too long."""
    stuffed = parameters.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
    length = len(stuffed) + MIN_LENGTH
    if length > MAX_LENGTH:
        raise ValueError(f"a frame may be {MAX_LENGTH} bytes long, not {length}: send less at once")
    packet = HEAD.pack(HEADER, servo_id, length) + bytes((instruction,)) + stuffed
    return packet + _UINT16.pack(crc16(packet))


class Receiver:
    """Finds the statuses in a stream of bytes that may be garbled (see the module's list)."""

    def __init__(self) -> None:
        self.bad_frames = 0
        self._pending = b""

    def reset(self) -> None:
        """Throw away half a frame that is waiting for its rest."""
        self._pending = b""

    def feed(self, data: bytes) -> list[Status]:
        """Take the next bytes of the stream, return the statuses that they complete."""
        stream = self._pending + data
        statuses: list[Status] = []
        position = 0
        while (start := stream.find(HEADER, position)) >= 0:
            end = _frame_end(stream, start)
            if end > len(stream):
                self._pending = stream[start:]
                return statuses
            if end and crc16(stream[start : end - 2]) == _UINT16.unpack_from(stream, end - 2)[0]:
                status = _decode(stream, start, end)
                if status:
                    statuses.append(status)
                position = end
            else:
                self.bad_frames += 1
                position = start + len(HEADER)
        # The last bytes may be the beginning of a header.
        self._pending = stream[max(position, len(stream) - len(HEADER) + 1) :]
        return statuses


def usual_statuses(ids: Sequence[int], length: int) -> Callable[[bytes], bool]:
    """Return what tells whether statuses side by side are the usual: `length` bytes of each, no error, no alert."""
    size = STATUS_OVERHEAD + length
    frames = [
        (at, at + size - 2, HEAD.pack(HEADER, servo_id, size - HEAD.size) + bytes((STATUS, 0)))
        for at, servo_id in zip(range(0, len(ids) * size, size), ids, strict=True)]

    def is_usual(data: bytes) -> bool:
        return b"\xff\xff\xfd\xfd" not in data and all(  # nothing was stuffed
            data.startswith(head, start) and crc16(data[start:end]) == _UINT16.unpack_from(data, end)[0]
            for start, end, head in frames)

    return is_usual


def _frame_end(stream: bytes, start: int) -> int:
    """Return where the frame at `start` ends, be it behind the stream's end; 0 if there can be no frame."""
    if len(stream) < start + HEAD.size:
        return len(stream) + 1
    _, servo_id, length = HEAD.unpack_from(stream, start)
    if not MIN_LENGTH <= length <= MAX_LENGTH or servo_id in (MAX_ID + 1, 0xFF):
        return 0
    end: int = start + HEAD.size + length
    # Stuffing keeps headers out of an unfinished frame, so one that is there begins the next frame.
    if end > len(stream) and stream.find(HEADER, start + HEAD.size) >= 0:
        return 0
    return end


def _decode(stream: bytes, start: int, end: int) -> Status | None:
    """Return the status in a frame whose CRC is right, None if it is something else."""
    servo_id = stream[start + 4]
    body = stream[start + HEAD.size : end - 2]
    if body[0] != STATUS or servo_id == BROADCAST_ID or len(body) < 2:
        return None
    body = body.replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
    error = body[1]
    return Status(servo_id, error & ~ALERT, error >= ALERT, body[2:])
