"""Streams as a bad wire makes them: noise, frames cut short, joined, bent, false headers, answers of long ago."""

from collections.abc import Sequence
from random import Random

_MOST_PARTS = 6
_FLOODS, _FLOOD = 0.02, 40  # how many inputs come so many times over
_TYPICAL = b"\xff\xfe\xfd\x00\x55\x01\x02"  # bytes that frames are made of


def noise(rng: Random, frame: bytes) -> bytes:
    return rng.randbytes(rng.randrange(1, 24))


def lookalike(rng: Random, frame: bytes) -> bytes:
    """Noise of the bytes that mean something."""
    return bytes(rng.choice(_TYPICAL) for _ in range(rng.randrange(1, 24)))


def cut(rng: Random, frame: bytes) -> bytes:
    return frame[: rng.randrange(len(frame))]


def tail(rng: Random, frame: bytes) -> bytes:
    return frame[rng.randrange(len(frame)) :]


def bend(rng: Random, frame: bytes) -> bytes:
    """Some bits are wrong."""
    data = bytearray(frame)
    for _ in range(rng.randrange(1, 5)):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)


def lose(rng: Random, frame: bytes) -> bytes:
    """A byte is missing."""
    at = rng.randrange(len(frame))
    return frame[:at] + frame[at + 1 :]


def insert(rng: Random, frame: bytes) -> bytes:
    """A byte too many."""
    at = rng.randrange(len(frame) + 1)
    return frame[:at] + rng.randbytes(1) + frame[at:]


def lie(rng: Random, frame: bytes) -> bytes:
    """A header, id and length, and nothing that they promise."""
    return frame[: rng.randrange(2, 8)] + rng.randbytes(rng.randrange(4))


def whole(rng: Random, frame: bytes) -> bytes:
    """One of long ago, or nobody's."""
    return frame


_WAYS = (noise, lookalike, cut, tail, bend, lose, insert, lie, whole)


def garbled(rng: Random, frames: Sequence[bytes]) -> bytes:
    """Return bytes made of these frames and of noise; now and then a flood of them."""
    parts = [rng.choice(_WAYS)(rng, rng.choice(frames)) for _ in range(rng.randrange(1, _MOST_PARTS + 1))]
    return b"".join(parts) * (1 if rng.random() > _FLOODS else _FLOOD)


def pieces(rng: Random, data: bytes) -> list[bytes]:
    """Cut a stream as reads of a port do."""
    parts: list[bytes] = []
    while data:
        size = rng.choice((1, 2, 7, 16, len(data)))
        parts.append(data[:size])
        data = data[size:]
    return parts
