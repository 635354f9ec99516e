"""What the host makes of garbled bytes: its receivers, its replies to group reads, and the splitter for people.

Of each input is asked that nothing raises; that what is believed was in the stream, its checksum right; that little is
kept; and that the exchange that follows is received whole.
"""

from collections.abc import Callable, Iterator, Sequence
from random import Random
from typing import NamedTuple

from hal import dynamixel1_protocol, dynamixel_protocol, feetech_protocol
from hal.frame_splitter import Frame, Splitter
from hal.protocol import GroupReply, Receiver, Status
from hal.whole_reply import WholeReply

from . import oracle
from .garble import garbled, pieces

_KEPT = 1100  # bytes that anybody may hold back: no frame is longer
_IDS = (7, 2, 5)
_LENGTHS = dict.fromkeys(_IDS, 4)

Believed = set[tuple[int, int, bool, bytes]]


class Wire(NamedTuple):
    """A protocol's frames: how a status is made, and which statuses a stream holds."""

    status: Callable[[int, bytes], bytes]
    held: Callable[[bytes], Believed]


def _dynamixel_status(servo_id: int, data: bytes) -> bytes:
    return oracle.dynamixel(servo_id, b"\x55\x00" + data.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd"))


def _dynamixel_held(stream: bytes) -> Believed:
    return {
        (servo_id, body[1] & 0x7F, body[1] >= 0x80, body[2:].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd"))
        for servo_id, body in oracle.dynamixel_frames(stream) if body[0] == 0x55 and len(body) > 1 and servo_id != 0xFE}


def _checksum_status(servo_id: int, data: bytes) -> bytes:
    return oracle.checksummed(servo_id, b"\x00" + data)


def _checksum_held(errors: int, alerts: int) -> Callable[[bytes], Believed]:
    return lambda stream: {
        (servo_id, body[0] & errors, body[0] & alerts != 0, body[1:])
        for servo_id, body in oracle.checksum_frames(stream)}


DYNAMIXEL = Wire(_dynamixel_status, _dynamixel_held)
DYNAMIXEL_1 = Wire(_checksum_status, _checksum_held(0x5A, 0x25))
FEETECH = Wire(_checksum_status, _checksum_held(0, 0x2F))


def _frames(rng: Random, status: Callable[[int, bytes], bytes]) -> list[bytes]:
    """Return frames of today and of long ago."""
    made = [status(servo_id, rng.randbytes(4)) for servo_id in _IDS]
    return [*made, status(rng.choice(_IDS), b""), status(rng.randrange(253), rng.randbytes(rng.randrange(9)))]


def _check(statuses: Sequence[Status], held: Believed) -> None:
    for status in statuses:
        assert tuple(status) in held, f"{status} was not in the stream"


def receiver(make: Callable[[], Receiver], wire: Wire) -> Callable[[Random], bytes]:
    """Return a trial of what finds statuses."""
    found = make()

    def trial(rng: Random) -> bytes:
        found.reset()
        stream = garbled(rng, _frames(rng, wire.status))
        statuses = [status for piece in pieces(rng, stream) for status in found.feed(piece)]
        _check(statuses, wire.held(stream))
        assert len(found._pending) <= _KEPT  # type: ignore[attr-defined]
        found.reset()
        data = rng.randbytes(4)
        assert found.feed(wire.status(3, data)) == [Status(3, 0, False, data)]
        return stream

    return trial


def separate(reply: GroupReply, wire: Wire, ids: Sequence[int] = _IDS) -> Callable[[Random], bytes]:
    """Return a trial of what collects one status of each servo."""

    def trial(rng: Random) -> bytes:
        reply.reset()
        stream = garbled(rng, _frames(rng, wire.status))
        for piece in pieces(rng, stream):
            reply.feed(piece)
        _check([status for status in reply.results.values() if status is not None], wire.held(stream))
        _whole(rng, reply, ids, lambda answers: b"".join(wire.status(*answer) for answer in answers))
        return stream

    return trial


def joint(reply: GroupReply) -> Callable[[Random], bytes]:
    """Return a trial of what takes a joint reply apart."""

    def trial(rng: Random) -> bytes:
        reply.reset()
        made = [oracle.dynamixel_joint((servo_id, rng.randbytes(4)) for servo_id in _IDS) for _ in range(2)]
        stream = garbled(rng, [*made, *made, _dynamixel_status(7, rng.randbytes(4))])
        for piece in pieces(rng, stream):
            reply.feed(piece)
        held = {
            (servo_id, error & 0x7F, error >= 0x80, data)
            for servo_id, error, data in oracle.joint_blocks(stream, _LENGTHS)}
        _check([status for status in reply.results.values() if status is not None], held)
        careful = reply._careful if isinstance(reply, WholeReply) else reply
        assert len(careful._pending) <= _KEPT  # type: ignore[attr-defined]
        _whole(rng, reply, _IDS, oracle.dynamixel_joint)
        return stream

    return trial


def _whole(
    rng: Random, reply: GroupReply, ids: Sequence[int], answers: Callable[[list[tuple[int, bytes]]], bytes]
) -> None:
    """Check that the next exchange brings all answers, behind noise of which no frame begins."""
    reply.reset()
    data = [(servo_id, rng.randbytes(4)) for servo_id in ids]
    for piece in pieces(rng, bytes(rng.randrange(0x80) for _ in range(rng.randrange(6))) + answers(data)):
        reply.feed(piece)
    assert reply.complete
    assert reply.results == {servo_id: Status(servo_id, 0, False, each) for servo_id, each in data}


def splitter(
    protocol: str, wire: Wire, frames: Callable[[bytes], set[oracle.Frame]], body: slice
) -> Callable[[Random], bytes]:
    """Return a trial of what cuts a stream into frames and garbage: it may lose no byte."""

    def trial(rng: Random) -> bytes:
        made = Splitter(protocol)
        stream = garbled(rng, _frames(rng, wire.status))
        cut = [each for piece in pieces(rng, stream) for each in made.feed(piece)]
        assert len(made._pending) <= _KEPT
        cut += made.flush()
        assert b"".join(each.raw for each in cut) == stream
        for each in cut:
            if isinstance(each, Frame):
                assert (each.id, each.raw[body]) in frames(each.raw)
        return stream

    return trial


def trials() -> Iterator[tuple[str, Callable[[Random], bytes]]]:
    """Return every one, with its name."""
    yield "Dynamixel 2.0, statuses", receiver(dynamixel_protocol.receiver, DYNAMIXEL)
    yield "Dynamixel 1.0, statuses", receiver(dynamixel1_protocol.receiver, DYNAMIXEL_1)
    yield "Feetech, statuses", receiver(feetech_protocol.receiver, FEETECH)
    items = [(servo_id, 56, 4) for servo_id in _IDS]
    yield "Dynamixel 2.0, sync read", separate(dynamixel_protocol.group_read(56, 4, _IDS, fast=False)[1], DYNAMIXEL)
    yield "Dynamixel 2.0, bulk read", separate(dynamixel_protocol.bulk_read(items, fast=False)[1], DYNAMIXEL)
    yield "Dynamixel 2.0, fast sync read", joint(dynamixel_protocol.group_read(56, 4, _IDS, fast=True)[1])
    yield "Dynamixel 2.0, fast bulk read", joint(dynamixel_protocol.bulk_read(items, fast=True)[1])
    yield "Dynamixel 1.0, bulk read", separate(dynamixel1_protocol.bulk_read(items)[1], DYNAMIXEL_1)
    yield "Feetech, sync read", separate(feetech_protocol.group_read(56, 4, _IDS, fast=False)[1], FEETECH)
    yield "Dynamixel 2.0, single read", separate(dynamixel_protocol.single_read(7, 56, 4)[1], DYNAMIXEL, [7])
    yield "Dynamixel 1.0, single read", separate(dynamixel1_protocol.single_read(7, 56, 4)[1], DYNAMIXEL_1, [7])
    yield "Feetech, single read", separate(feetech_protocol.single_read(7, 56, 4)[1], FEETECH, [7])
    yield "Dynamixel 2.0, in words", splitter("dynamixel-2.0", DYNAMIXEL, oracle.dynamixel_frames, slice(7, -2))
    yield "Dynamixel 1.0, in words", splitter("dynamixel-1.0", DYNAMIXEL_1, oracle.checksum_frames, slice(4, -1))
    yield "Feetech STS, in words", splitter("feetech-sts", FEETECH, oracle.checksum_frames, slice(4, -1))
    yield "Feetech SCS, in words", splitter("feetech-scs", FEETECH, oracle.checksum_frames, slice(4, -1))
