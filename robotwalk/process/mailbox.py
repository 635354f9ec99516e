"""Memory that two processes share: nobody waits for the other, and a torn read is seen.

    Slot    the newest message; written over
    Track   the newest few of a stream of messages, each in a slot of its own
    Ring    every message, until it is full

A slot's bytes: sequence number, length, CRC-32, message, and the sequence number again in its last bytes. A reader
copies all of it first; if the numbers differ or the CRC is wrong, somebody was writing, and it reads again. The numbers
alone would not do: a writer may overtake a reader in between, and ARM does not keep the order of writes.

Ticks are packed by `robotwalk.process.plain`, 10 us for 18 joints; what is rare is pickled. The file belongs
to one user and nobody else can open it; who could write into it could as well start a program of his own.
"""

import pickle
import struct
import zlib
from typing import Any, NamedTuple

_HEAD = struct.Struct("<QII")  # sequence number, length, CRC-32
_NUMBER = struct.Struct("<Q")
_FRAME = struct.Struct("<II")  # length, CRC-32
_TRIES = 50  # at a whole copy; a writer needs microseconds
_COUNTERS = 64  # bytes; of messages put and taken, and of those dropped
OVERHEAD = _HEAD.size + _NUMBER.size  # bytes of a slot beyond its message


class Message(NamedTuple):
    """What a slot held."""

    number: int  # counted from 1
    data: bytes


class Slot:
    """The newest message of one writer. Several may write, if torn messages are no harm."""

    def __init__(self, memory: memoryview) -> None:
        """Take bytes that are shared, at first all zero."""
        self._memory = memory
        self._room = len(memory) - OVERHEAD

    @property
    def number(self) -> int:
        """The number of the newest message, or of one that is being written; 0: there was none yet."""
        return int(_NUMBER.unpack_from(self._memory)[0])

    def write(self, data: bytes, number: int | None = None) -> int:
        """Replace the message; return its number: the next one, unless it is given.

        Raises:
            ValueError: it is too long.
        """
        if len(data) > self._room:
            raise ValueError(f"{len(data)} bytes do not fit into a slot of {self._room}")
        if number is None:
            number = self.number + 1
        memory, tail = self._memory, _NUMBER.pack(number)
        _HEAD.pack_into(memory, 0, number, len(data), zlib.crc32(data, number & 0xFFFFFFFF))
        memory[_HEAD.size:_HEAD.size + len(data)] = data
        memory[-_NUMBER.size:] = tail
        return number

    def read(self) -> Message | None:
        """Return the newest message; None if there was none yet, or only torn ones can be had."""
        for _ in range(_TRIES):
            copy = bytes(self._memory)
            number, length, checksum = _HEAD.unpack_from(copy)
            if number == 0:
                return None
            if length > self._room or copy[-_NUMBER.size:] != _NUMBER.pack(number):
                continue
            data = copy[_HEAD.size:_HEAD.size + length]
            if zlib.crc32(data, number & 0xFFFFFFFF) == checksum:
                return Message(number, data)
        return None


class Track:
    """The newest messages of a stream, for readers who want each of them and may fall behind."""

    def __init__(self, memory: memoryview, slots: int) -> None:
        """Divide shared bytes among so many slots."""
        size = len(memory) // slots
        self._slots = [Slot(memory[index * size:(index + 1) * size]) for index in range(slots)]
        self._newest = 0

    def write(self, data: bytes) -> None:
        """Add a message. Raises ValueError if it is too long."""
        self._newest += 1
        self._slots[self._newest % len(self._slots)].write(data, self._newest)

    def next(self, after: int) -> Message | None:
        """Return the message after the one of that number, or a later one if that is gone; None if there is none yet.

        Who has fallen behind is taken to the newest.
        """
        message = self._slots[(after + 1) % len(self._slots)].read()
        if message is None or message.number <= after:
            return None
        return message if message.number == after + 1 else self.newest()

    def newest(self) -> Message | None:
        """Return the newest message."""
        slot = max(self._slots, key=lambda slot: slot.number)
        return slot.read()


class Ring:
    """Messages from one writer to one reader, in order. What finds no room is counted and gone."""

    def __init__(self, memory: memoryview) -> None:
        """Take bytes that are shared, a multiple of 8, at first all zero."""
        self._counters = memory[:_COUNTERS].cast("Q")  # each is one aligned store
        self._data = memory[_COUNTERS:]

    @property
    def dropped(self) -> int:
        """How many messages found no room."""
        return int(self._counters[2])

    def put(self, data: bytes) -> bool:
        """Add a message, if there is room."""
        taken, put = self._counters[0], self._counters[1]
        frame = _FRAME.pack(len(data), zlib.crc32(data)) + data
        if put - taken + len(frame) > len(self._data):
            self._counters[2] += 1
            return False
        begin = put % len(self._data)
        first = min(len(frame), len(self._data) - begin)
        self._data[begin:begin + first] = frame[:first]
        self._data[:len(frame) - first] = frame[first:]
        self._counters[1] = put + len(frame)
        return True

    def take(self) -> bytes | None:
        """Return the oldest message; None if there is none."""
        taken = self._counters[0]
        if taken == self._counters[1]:
            return None
        length, checksum = _FRAME.unpack(self._copy(taken, _FRAME.size))
        if length > len(self._data):
            return None
        data = self._copy(taken + _FRAME.size, length)
        if zlib.crc32(data) != checksum:
            return None  # its bytes are not all here yet
        self._counters[0] = taken + _FRAME.size + length
        return data

    def _copy(self, at: int, size: int) -> bytes:
        begin = at % len(self._data)
        first = min(size, len(self._data) - begin)
        return bytes(self._data[begin:begin + first]) + bytes(self._data[:size - first])


def packed(thing: Any) -> bytes:
    """Return a thing as bytes."""
    return pickle.dumps(thing, pickle.HIGHEST_PROTOCOL)


def unpacked(data: bytes) -> Any:
    """Return the thing that `packed` made these bytes of."""
    return pickle.loads(data)
