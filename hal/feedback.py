"""Which reads bring the feedback of a wire's servos: as few as their protocol, models and firmware allow.

    fast sync read, fast bulk read    Dynamixel 2.0, from some firmware on: one reply of all
    sync read, bulk read              one request, one reply each; bulk where the servos' registers lie elsewhere
    single reads                      Dynamixel 1.0 and Feetech SCS: spread over as many ticks as they take
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from enum import StrEnum
from itertools import groupby
from typing import NamedTuple

from hal.protocol import GroupReply, ServoProtocol
from hal.roll_call import RollCall
from hal.samples import Sample, sample_decoder, samples_decoder
from hal.whole_reply import WholeReply
from hal.wired import Wired

Samples = Iterator[tuple[int, tuple[float, float, float]]]  # slots and samples

_KEPT = 64  # requests, ready made; when replies are lost the order of ids changes often


class Way(StrEnum):
    """How feedback is read."""

    FAST = "fast"
    GROUP = "group"
    SINGLE = "single"


class Reading(NamedTuple):
    """A request that can be sent again and again, and what collects the answers."""

    ids: tuple[int, ...]
    request: bytes
    reply: GroupReply
    usual: Callable[[], Samples | None]  # the samples of all, if the reply is the usual one


class Reader:
    """Reads the feedback of servos that are asked in one way, and keeps the roll of who answers."""

    def __init__(self, protocol: ServoProtocol, servos: Sequence[Wired], way: Way) -> None:
        self.way = way
        self.servos = {servo.id: servo for servo in servos}
        self._protocol = protocol
        self._places = {
            servo.id: (servo.slot, servo.model.feedback.size, sample_decoder(servo)) for servo in servos}
        self._blocks = {servo.id: servo.model.feedback for servo in servos}
        self._alike = len({(block.address, block.size) for block in self._blocks.values()}) == 1
        self._roll = RollCall(tuple(self.servos))
        self._ready: dict[tuple[int, ...], Reading] = {}

    @property
    def spreads(self) -> bool:
        """Whether a tick need not hold all its readings."""
        return self.way is Way.SINGLE

    def everyone(self) -> list[Reading]:
        """Return the readings of a tick in which all are asked."""
        return [self._reading(ids) for ids in self._portions(tuple(self.servos))]

    def readings(self) -> Iterator[Reading]:
        """Begin a tick; return its readings. At most one of them waits for servos that owe an answer."""
        waits = 0
        for ids in self._portions(tuple(self._roll.next())):
            if self.spreads and self._roll.is_silent(ids[0]):
                waits += 1
                if waits > 1:
                    return
            yield self._reading(ids)

    def collect_usual(self, reading: Reading) -> Samples | None:
        """Return the samples of all that were asked, if all answered and have nothing to report."""
        samples = reading.usual()
        if samples is not None:
            self._roll.note(reading.ids, reading.ids)
        return samples

    def collect(self, reading: Reading) -> list[tuple[int, Sample | None, bool]]:
        """Note who answered; return of each that was asked its slot, its sample if a good one came, and its alert."""
        results, heard = reading.reply.results, []
        found: list[tuple[int, Sample | None, bool]] = []
        for servo_id in reading.ids:
            status, (slot, size, decode) = results[servo_id], self._places[servo_id]
            if status is None:
                found.append((slot, None, False))
                continue
            heard.append(servo_id)
            good = not status.error and len(status.data) == size
            found.append((slot, decode(status.data) if good else None, status.alert))
        self._roll.note(reading.ids, heard)
        return found

    def _portions(self, ids: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
        return ((servo_id,) for servo_id in ids) if self.spreads else iter((ids,))

    def _reading(self, ids: tuple[int, ...]) -> Reading:
        reading = self._ready.get(ids)
        if reading is None:
            if len(self._ready) >= _KEPT:
                self._ready.clear()
            request, reply = self._ask(ids)
            usual = _usual([self.servos[servo_id] for servo_id in ids], reply)
            reading = self._ready[ids] = Reading(ids, request, reply, usual)
        return reading

    def _ask(self, ids: tuple[int, ...]) -> tuple[bytes, GroupReply]:
        block = self._blocks[ids[0]]
        if self.spreads:
            return self._protocol.single_read(ids[0], block.address, block.size)
        if self._alike:
            return self._protocol.group_read(block.address, block.size, ids, fast=self.way is Way.FAST)
        items = [(servo_id, self._blocks[servo_id].address, self._blocks[servo_id].size) for servo_id in ids]
        return self._protocol.bulk_read(items, fast=self.way is Way.FAST)


def _usual(servos: Sequence[Wired], reply: GroupReply) -> Callable[[], Samples | None]:
    """Return what decodes a reply at once, if it is the usual one."""
    decode = samples_decoder(servos, reply.outline) if isinstance(reply, WholeReply) else None

    def usual() -> Samples | None:
        whole = reply.whole if isinstance(reply, WholeReply) else None
        return None if whole is None or decode is None else decode(whole)

    return usual


def readers(protocol: ServoProtocol, servos: Sequence[Wired], fast: Collection[int]) -> list[Reader]:
    """Divide a wire's servos by how they are read; those whose id is in `fast` know the fast reads."""

    def key(servo: Wired) -> tuple[str, int, int]:
        block = servo.model.feedback
        way = Way.FAST if servo.id in fast else Way.GROUP if servo.model.sync_read else Way.SINGLE
        return (way, 0, 0) if protocol.BULK_READ or way is Way.SINGLE else (way, block.address, block.size)

    return [
        Reader(protocol, tuple(group), Way(way)) for (way, *_), group in groupby(sorted(servos, key=key), key=key)]
