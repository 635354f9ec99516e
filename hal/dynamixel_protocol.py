"""Dynamixel Protocol 2.0, the host's side: frames <-> values. Pure: no I/O, no clock.

Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0".

    FF FF FD 00 | id | length L | instruction | parameters             | CRC     an instruction
    FF FF FD 00 | id | length L | 55          | error | parameters     | CRC     a status
    '- header -'  1    2          1             <--- L - 3 bytes ----->  2       two bytes: low one first

L counts from the instruction to the CRC inclusive. Between instruction and CRC an FD is stuffed behind every
FF FF FD, so that no header occurs there. The CRC covers everything before it, stuffing included.

The reply to a fast sync read is one frame that the servos build in turn. It is not stuffed:

    FF FF FD 00 | FE | length L | 55 | error id data CRC | error id data CRC | ...

Each CRC there runs over the whole frame so far, with the earlier CRCs; the last one is the frame's own.

What `Receiver` makes of a garbled stream:

    noise, FF FF FD FD              skipped up to the next header
    impossible id or length         bad; goes on behind that header at once
    wrong CRC                       bad; goes on behind that header: a whole frame may lie inside
    a header before a frame's end   bad: the frame was cut short; goes on at the new header
    an instruction (an echo)        dropped
    a status of id FE               dropped: a fast sync reply that came too late
    half a frame                    kept for the next `feed`, until `reset`
"""

from collections.abc import Sequence
from enum import IntEnum
from struct import Struct
from typing import Self

from fastcrc.crc16 import umts as crc16

from hal.instructions import BROADCAST_ID as BROADCAST_ID
from hal.instructions import Instruction, Instructions
from hal.protocol import GroupReply, SeparateReplies, Status

MAX_ID = 252
PING_SLOT_NS = 3_000_000  # what ROBOTIS's libraries allow for
MAX_LENGTH = 1024  # our limit for L; no X-series control table is longer (e-Manual: it ends at 661)

_HEADER = b"\xff\xff\xfd\x00"
_HEAD = Struct("<4sBH")  # header, id, length
_UINT16 = Struct("<H")
_STATUS = 0x55
_ALERT = 0x80
_MIN_LENGTH = 3  # instruction and CRC
_STATUS_OVERHEAD = 11  # bytes of a status without parameters


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


def _frame(servo_id: int, instruction: Instruction, parameters: bytes) -> bytes:
    stuffed = parameters.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
    length = len(stuffed) + _MIN_LENGTH
    if length > MAX_LENGTH:
        raise ValueError(f"a frame may be {MAX_LENGTH} bytes long, not {length}: send less at once")
    frame = _HEAD.pack(_HEADER, servo_id, length) + bytes((instruction,)) + stuffed
    return frame + _UINT16.pack(crc16(frame))


_instructions = Instructions(_frame, max_id=MAX_ID, address_bytes=2, largest=MAX_LENGTH - _MIN_LENGTH)
ping, reboot = _instructions.ping, _instructions.reboot  # the status of a ping names model and firmware
read, write = _instructions.read, _instructions.write
reg_write, action = _instructions.reg_write, _instructions.action
sync_write, sync_read = _instructions.sync_write, _instructions.sync_read
fast_sync_read = _instructions.fast_sync_read


def group_read(address: int, length: int, ids: Sequence[int], *, fast: bool) -> tuple[bytes, GroupReply]:
    """Return a fast sync read or a sync read, and what collects the answers."""
    if fast:
        return fast_sync_read(address, length, ids), FastSyncReply(ids, length)
    return sync_read(address, length, ids), SeparateReplies(Receiver(), ids, length + _STATUS_OVERHEAD)


def receiver() -> "Receiver":
    """Return a new `Receiver`."""
    return Receiver()


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
        while (start := stream.find(_HEADER, position)) >= 0:
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
                position = start + len(_HEADER)
        # The last bytes may be the beginning of a header.
        self._pending = stream[max(position, len(stream) - len(_HEADER) + 1) :]
        return statuses


class FastSyncReply:
    """The joint reply to one `fast_sync_read`, block by block.

    Each block is checked by its own CRC, so those before a silent servo or a garbled byte count. Bytes before
    the reply, an echo among them, are skipped. `results` has one entry per id, in the order asked for: None
    until a good block has come. `corrupt` tells that a block came garbled; it and all behind it stay None.
    """

    waits = 1  # the return delay passes once for all

    def __init__(self, ids: Sequence[int], length: int) -> None:
        _instructions.check_ids(ids)
        self._ids = tuple(ids)
        self._block = Struct(f"<BB{length}sH")  # error, id, data, CRC
        size = 1 + len(ids) * self._block.size
        if size > MAX_LENGTH:
            raise ValueError(f"a reply may be {MAX_LENGTH} bytes long, not {size}: read less at once")
        self._head = _HEAD.pack(_HEADER, BROADCAST_ID, size) + bytes((_STATUS,))
        self.size = _HEAD.size + size
        self.bad_frames = 0
        self.reset()

    def reset(self) -> None:
        """Forget what has come, for the next reply to the same instruction."""
        self.results: dict[int, Status | None] = dict.fromkeys(self._ids)
        self.corrupt = False
        self._pending = b""
        self._crc: int | None = None  # over the frame up to `_pending`; None: its head has not come
        self._arrived = 0  # blocks

    @property
    def complete(self) -> bool:
        """Whether every block has arrived, good or bad: nothing more will come."""
        return self._arrived == len(self._ids)

    def feed(self, data: bytes) -> None:
        """Take the next bytes and put the blocks that they complete into `results`."""
        pending = self._pending + data
        if self._crc is None:
            start = pending.find(self._head)
            if start < 0:
                self._pending = pending[max(0, len(pending) - len(self._head) + 1) :]
                return
            self._crc = crc16(self._head)
            pending = pending[start + len(self._head) :]
        self._pending = self._take_blocks(pending, self._crc)

    def _take_blocks(self, pending: bytes, crc: int) -> bytes:
        """Check and store the whole blocks of `pending`, return the bytes behind them."""
        size = self._block.size
        position = 0
        for expected in self._ids[self._arrived : self._arrived + len(pending) // size]:
            end = position + size
            error, servo_id, data, received = self._block.unpack_from(pending, position)
            crc = crc16(pending[position : end - 2], crc)
            if not self.corrupt and (crc != received or servo_id != expected):
                self.corrupt = True
                self.bad_frames += 1
            if not self.corrupt:
                self.results[servo_id] = Status(servo_id, error & ~_ALERT, error >= _ALERT, data)
            crc = crc16(pending[end - 2 : end], crc)
            position = end
            self._arrived += 1
        self._crc = crc
        return pending[position:]


def _frame_end(stream: bytes, start: int) -> int:
    """Return where the frame at `start` ends, be it behind the stream's end; 0 if there can be no frame."""
    if len(stream) < start + _HEAD.size:
        return len(stream) + 1
    _, servo_id, length = _HEAD.unpack_from(stream, start)
    if not _MIN_LENGTH <= length <= MAX_LENGTH or servo_id in (MAX_ID + 1, 0xFF):
        return 0
    end: int = start + _HEAD.size + length
    # Stuffing keeps headers out of an unfinished frame, so one that is there begins the next frame.
    if end > len(stream) and stream.find(_HEADER, start + _HEAD.size) >= 0:
        return 0
    return end


def _decode(stream: bytes, start: int, end: int) -> Status | None:
    """Return the status in a frame whose CRC is right, None if it is something else."""
    servo_id = stream[start + 4]
    body = stream[start + _HEAD.size : end - 2]
    if body[0] != _STATUS or servo_id == BROADCAST_ID or len(body) < 2:
        return None
    body = body.replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
    error = body[1]
    return Status(servo_id, error & ~_ALERT, error >= _ALERT, body[2:])
