"""Bytes of a servo bus in either direction -> frames, and what is between them. For looking, not for the loop.

The loop's receivers know what they wait for, and skip the rest. Who only listens wants to see the rest, too.
"""

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

from fastcrc.crc16 import umts as crc16

from hal.checksum_frames import OVERHEAD
from hal.dynamixel_frames import HEAD, HEADER, MAX_LENGTH, MIN_LENGTH, STATUS

_CHECKSUM_HEADER = re.compile(rb"\xff\xff(?!\xff)")


class Frame(NamedTuple):
    """A whole frame."""

    id: int
    code: int  # the instruction; in a status of a checksum protocol, the error byte
    parameters: bytes  # in a status of Dynamixel 2.0, the error byte first
    raw: bytes
    status: bool | None  # None: nothing in the frame tells


class Garbage(NamedTuple):
    """Bytes that are no frame."""

    raw: bytes
    why: str


Piece = Frame | Garbage


class Splitter:
    """Cuts a stream into pieces."""

    def __init__(self, protocol: str) -> None:
        """Take the name of a protocol, as servo models have it."""
        self._frame_at: Callable[[bytes, int], Piece | None]
        self._header = re.compile(re.escape(HEADER)) if protocol == "dynamixel-2.0" else _CHECKSUM_HEADER
        self._frame_at = _dynamixel_frame if protocol == "dynamixel-2.0" else _checksum_frame
        self._longest_head = len(HEADER) if protocol == "dynamixel-2.0" else 2
        self._pending = b""

    def feed(self, data: bytes) -> Iterator[Piece]:
        """Take the next bytes; return the pieces that they complete."""
        stream, position = self._pending + data, 0
        while header := self._header.search(stream, position):
            start = header.start()
            piece = self._frame_at(stream, start)
            if piece is None:
                break
            if start > position:
                yield Garbage(stream[position:start], "no header")
            yield piece
            position = start + len(piece.raw)
        else:
            # The last bytes may be the beginning of a header.
            start = max(position, len(stream) - self._longest_head + 1)
            if start > position:
                yield Garbage(stream[position:start], "no header")
        if start > position and header:
            yield Garbage(stream[position:start], "no header")
        self._pending = stream[start:]

    def flush(self) -> Iterator[Piece]:
        """Return what is left, when nothing more comes."""
        rest, self._pending = self._pending, b""
        if rest:
            yield Garbage(rest, "it breaks off")


def _dynamixel_frame(stream: bytes, start: int) -> Piece | None:
    """Return the piece that begins with this header; None if it is not all there."""
    if len(stream) < start + HEAD.size:
        return None
    _, servo_id, length = HEAD.unpack_from(stream, start)
    if not MIN_LENGTH <= length <= MAX_LENGTH:
        return Garbage(stream[start : start + len(HEADER)], f"a length of {length} cannot be")
    end = start + HEAD.size + length
    if end > len(stream):
        again = stream.find(HEADER, start + len(HEADER))
        return Garbage(stream[start:again], "it breaks off") if again > 0 else None
    raw = stream[start:end]
    if crc16(raw[:-2]) != int.from_bytes(raw[-2:], "little"):
        again = raw.find(HEADER, len(HEADER))
        return Garbage(raw[:again] if again > 0 else raw, "wrong CRC")
    body = raw[HEAD.size : -2]
    code = body[0]
    joint = code == STATUS and servo_id == 0xFE  # which nobody stuffs
    parameters = body[1:] if joint else body[1:].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
    return Frame(servo_id, code, parameters, raw, code == STATUS)


def _checksum_frame(stream: bytes, start: int) -> Piece | None:
    if len(stream) < start + 4:
        return None
    length = stream[start + 3]
    if length < 2:
        return Garbage(stream[start : start + 2], f"a length of {length} cannot be")
    end = start + OVERHEAD + length - 2
    if end > len(stream):
        return None
    raw = stream[start:end]
    if sum(raw[2:]) & 0xFF != 0xFF:
        again = _CHECKSUM_HEADER.search(raw, 2)
        return Garbage(raw[: again.start()] if again else raw, "wrong checksum")
    return Frame(raw[2], raw[4], raw[5:-1], raw, None)
