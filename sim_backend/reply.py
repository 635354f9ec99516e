"""What comes back over a wire: one servo's answer, or what is heard when several talk at once."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

_BITS_PER_BYTE = 10  # 8N1: a start bit (low), eight from the lowest on, a stop bit (high)
_SKEW_BITS = 3  # no two servos begin at the same moment; assumed


class Reply(NamedTuple):
    """A burst of bytes from the bus."""

    delay_ns: int  # after the end of the reply before it, or of the instruction
    data: bytes


def collide(replies: Sequence[Reply], byte_ns: int) -> list[Reply]:
    """Return what is heard of servos that answer the same instruction, each after its own delay.

    The line is low while any of them pulls it low, and each begins a few bits later than the one before it would
    have it begin: equal answers spoil each other too. Those that do not overlap are heard one after the other.
    """
    if len(replies) < 2:
        return list(replies)
    bit_ns = byte_ns / _BITS_PER_BYTE
    low = {
        bit
        for skew, reply in enumerate(replies)
        for bit in _low_bits(reply.data, round(reply.delay_ns / bit_ns) + skew * _SKEW_BITS)}
    received = list(_receive(low))
    heard, end = [], 0
    # Bytes that follow each other without a pause keep their distance to their number.
    for _, burst in groupby(enumerate(received), lambda item: item[1][0] - item[0] * _BITS_PER_BYTE):
        items = [item for _, item in burst]
        heard.append(Reply(round((items[0][0] - end) * bit_ns), bytes(byte for _, byte in items)))
        end = items[-1][0] + _BITS_PER_BYTE
    return heard


def misheard(reply: Reply, said_ns: int, heard_ns: int) -> Reply:
    """Return what a receiver whose bytes take `heard_ns` makes of bytes that take `said_ns` each."""
    if said_ns == heard_ns:
        return reply
    low, last = set(_low_bits(reply.data, 0)), len(reply.data) * _BITS_PER_BYTE
    ratio = heard_ns / said_ns  # bits said per bit heard
    heard, at = bytearray(), 0.0
    while at < last:
        if int(at) not in low:  # idle, until the next start bit
            at = int(at) + 1.0
            continue
        heard.append(sum((int(at + (bit + 1.5) * ratio) not in low) << bit for bit in range(8)))
        at += _BITS_PER_BYTE * ratio
    return reply._replace(data=bytes(heard))


def _low_bits(data: bytes, start: int) -> Iterator[int]:
    """Yield the bit times in which a sender holds the line low."""
    for first, byte in zip(range(start, start + len(data) * _BITS_PER_BYTE, _BITS_PER_BYTE), data, strict=True):
        yield first
        yield from (first + 1 + bit for bit in range(8) if not byte >> bit & 1)


def _receive(low: set[int]) -> Iterator[tuple[int, int]]:
    """Yield when each byte begins, and the byte: a receiver takes the first low bit after a byte for a start bit."""
    free = 0
    for start in sorted(low):
        if start >= free:
            yield start, sum((start + 1 + bit not in low) << bit for bit in range(8))
            free = start + _BITS_PER_BYTE
