"""The servos' side of the frames of Dynamixel Protocol 2.0.

    FF FF FD 00 | id | length lo, hi | instruction | parameters | crc lo, hi
    FF FF FD 00 | id | length lo, hi | 55 | error | data | crc lo, hi              (status)

The length counts from the instruction on. From there to the parameters' end, FF FF FD is followed by an extra
FD (stuffing). The CRC covers the stuffed frame. Source: ROBOTIS e-Manual, Protocol 2.0.
"""

import struct

from fastcrc import crc16

from sim_backend.device import InstructionParser, Packet

BROADCAST = 0xFE
HEADER = b"\xff\xff\xfd\x00"  # the reserved byte tells it from stuffed data
STATUS = 0x55
_STUFFED = (b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
_PROLOGUE = 7  # bytes up to the length's end
_INVALID_IDS = (0xFD, 0xFF)
_LENGTHS = range(3, 1025)  # beyond: a false header in noise


class DynamixelParser(InstructionParser):
    """Finds frames of Protocol 2.0."""

    header = HEADER
    prologue = _PROLOGUE

    def _next(self) -> Packet | None:
        buffer = self._buffer
        while self._align():
            end = _PROLOGUE + (buffer[5] | buffer[6] << 8)
            restart = buffer.find(HEADER, len(HEADER), min(end - 2, len(buffer)))
            if restart > 0:  # stuffing keeps headers out of a frame: this one was broken off
                del buffer[:restart]
                continue
            if len(buffer) < end:
                return None
            frame = bytes(buffer[:end])
            intact = crc16.umts(frame[:-2]) == frame[-2] | frame[-1] << 8
            del buffer[:end if intact else len(HEADER)]
            body = frame[_PROLOGUE:-2].replace(_STUFFED[1], _STUFFED[0])
            return Packet(frame[4], body[0], body[1:], intact)
        return None

    def _plausible(self) -> bool:
        buffer = self._buffer
        return buffer[4] not in _INVALID_IDS and buffer[5] | buffer[6] << 8 in _LENGTHS


def status(servo_id: int, error: int, data: bytes = b"") -> bytes:
    """Return a status packet."""
    body = (bytes((STATUS, error)) + data).replace(*_STUFFED)
    frame = HEADER + struct.pack("<BH", servo_id, len(body) + 2) + body
    return frame + crc16.umts(frame).to_bytes(2, "little")
