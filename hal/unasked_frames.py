"""Bytes of a line on which somebody talks unasked -> frames of one size that end in a sum of their bytes.

Garbled are: bytes lost (the header is then where the checksum should be), bytes changed (the sum differs), bytes
between frames, and what begins in the middle of a frame, as every line does. A frame whose sum differs costs its
first byte alone: the next header may already be within it.
"""

import re
from typing import NamedTuple


class Framing(NamedTuple):
    """How frames look."""

    header: re.Pattern[bytes]
    size: int  # bytes, header and sum included
    summed_from: int  # the first byte that counts; the last one is their sum modulo 256


class FrameReceiver:
    """Finds frames, piece by piece.

    Attributes:
        stray_bytes: how many belonged to no frame; what came before the first one counts, too.
    """

    def __init__(self, framing: Framing) -> None:
        self._framing = framing
        self._buffer = bytearray()
        self.stray_bytes = 0

    def take(self, data: bytes) -> list[bytes]:
        """Take bytes as they come; return the frames that are whole now."""
        buffer, (header, size, summed_from) = self._buffer, self._framing
        buffer += data
        frames = []
        at = 0
        while (found := header.search(buffer, at)) is not None:
            start = found.start()
            self.stray_bytes += start - at
            at = start
            if len(buffer) - at < size:
                break
            frame = bytes(buffer[at:at + size])
            if sum(frame[summed_from:-1]) & 0xFF == frame[-1]:
                frames.append(frame)
                at += size
            else:
                self.stray_bytes += 1
                at += 1
        else:
            end = max(at, len(buffer) - 1)  # with the last byte a header may have begun
            self.stray_bytes += end - at
            at = end
        del buffer[:at]
        return frames

    def reset(self) -> None:
        """Forget what has come of a frame."""
        self._buffer.clear()
