"""The servos' side of frames that a one-byte checksum ends: Dynamixel Protocol 1.0's and Feetech's.

    FF FF | id | length | instruction | parameters | checksum
    FF FF | id | length | error | data | checksum               (status)

The length counts from the instruction on. The checksum is the complement of the sum of all bytes between header and
itself. Nothing keeps FF FF out of the data.
"""

import struct

from sim_backend.device import InstructionParser, Packet

BROADCAST = 0xFE
RANGE = struct.Struct("BB")  # address, length
LARGEST_DATA = 253  # bytes: what the length of a status can say
_HEADER = b"\xff\xff"
_PROLOGUE = 4  # bytes up to the length's end
_SHORTEST = 2  # length: instruction and checksum
_INVALID_ID = 0xFF


class ChecksumParser(InstructionParser):
    """Finds such frames. Of one whose checksum is wrong the header is dropped: it may have been noise."""

    header = _HEADER
    prologue = _PROLOGUE

    def _next(self) -> Packet | None:
        buffer = self._buffer
        if not self._align():
            return None
        end = _PROLOGUE + buffer[3]
        if len(buffer) < end:
            return None
        intact = _checksum(buffer[2:end - 1]) == buffer[end - 1]
        packet = Packet(buffer[2], buffer[4], bytes(buffer[5:end - 1]), intact)
        del buffer[:end if intact else len(_HEADER)]
        return packet

    def _plausible(self) -> bool:
        return self._buffer[2] != _INVALID_ID and self._buffer[3] >= _SHORTEST


def status(servo_id: int, error: int, data: bytes = b"") -> bytes:
    """Return a status packet."""
    body = bytes((servo_id, len(data) + 2, error)) + data
    return _HEADER + body + bytes((_checksum(body),))


def _checksum(body: bytes | bytearray) -> int:
    return ~sum(body) & 0xFF
