"""What the simulated servos make of garbled instructions, and of well-formed ones that make no sense.

Of each input is asked that nothing raises; that what is answered is well-formed; that little is kept; and that a servo
whose bus is quiet again answers a ping.
"""

from collections.abc import Callable, Iterator
from random import Random
from typing import Any

from robotwalk.assembly import load_servo
from sim_backend.brands import make_device, make_servo
from sim_backend.checksum_frames import ChecksumParser
from sim_backend.device import InstructionParser, Packet
from sim_backend.dynamixel_device import DynamixelParser
from sim_backend.servo_physics import ServoPhysics

from . import oracle
from .garble import garbled, pieces

_BAUD = 1_000_000
_KEPT = 1100  # bytes; no instruction is longer
_LATER = 2_000_000_000  # ns; every restart is over by then
_MOST_SERVOS = 3
_FRESH = 200  # trials, after which the servos are taken new: their registers hold much nonsense by then
_INSTRUCTIONS = (1, 2, 3, 4, 5, 6, 8, 0x0A, 0x0B, 0x10, 0x20, 0x55, 0x82, 0x83, 0x8A, 0x92, 0x93, 0x9A)

Framing = Callable[[int, bytes], bytes]


def _dynamixel(servo_id: int, body: bytes) -> bytes:
    return oracle.dynamixel(servo_id, body.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd"))


class Bench:
    """Some servos of a model on one wire."""

    def __init__(self, name: str) -> None:
        model = load_servo(name)
        physics = ServoPhysics([model] * _MOST_SERVOS)
        baud = model.baud_value(_BAUD)
        self.servos = [
            make_servo(physics, index, id=index + 1, baud_rate=baud, return_delay_time=0)
            for index in range(_MOST_SERVOS)]
        self.device: Any = make_device("bench", self.servos)
        self.now = 10_000_000


def trial_of(name: str, frame: Framing, frames: Callable[[bytes], set[oracle.Frame]]) -> Callable[[Random], bytes]:
    """Return a trial of servos of a model."""
    bench, left = Bench(name), _FRESH

    def trial(rng: Random) -> bytes:
        nonlocal bench, left
        left -= 1
        if not left:
            bench, left = Bench(name), _FRESH
        stream = garbled(rng, _instructions(rng, frame))
        for piece in pieces(rng, stream):
            _hear(bench, piece, rng.choice((0, 100_000, 2_000_000)))
        bench.now += _LATER
        for servo in bench.servos:
            alone = [other.id for other in bench.servos].count(servo.id) == 1
            if alone and servo.listens(bench.now, _BAUD):
                answer = _hear(bench, frame(servo.id, b"\x01"), 2_000_000)
                assert [servo_id for servo_id, _ in frames(answer)] == [servo.id], f"a ping of id {servo.id}"
        return stream

    return trial


def parser(
    found: InstructionParser, frame: Framing, frames: Callable[[bytes], set[oracle.Frame]]
) -> Callable[[Random], bytes]:
    """Return a trial of what finds instructions."""
    now = 10_000_000

    def trial(rng: Random) -> bytes:
        nonlocal now
        now += _LATER
        stream = garbled(rng, _instructions(rng, frame))
        packets = []
        for piece in pieces(rng, stream):
            now += len(piece) * 10_000
            packets += found.feed(piece, now, 10_000)
        held = {(servo_id, body.replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")) for servo_id, body in frames(stream)}
        held |= frames(stream)  # of protocols that stuff nothing
        for packet in packets:
            whole = packet.id, bytes((packet.instruction,)) + packet.parameters
            assert not packet.intact or whole in held, f"{packet} was not in the stream"
        now += _LATER
        assert list(found.feed(frame(9, b"\x02\x84\x00\x04\x00"), now, 10_000)) == [Packet(9, 2, b"\x84\x00\x04\x00")]
        return stream

    return trial


def _hear(bench: Bench, data: bytes, pause: int) -> bytes:
    bench.now += pause + len(data) * 10_000
    answers = bench.device.receive(data, bench.now, _BAUD)
    assert len(bench.device._parser._buffer) <= _KEPT
    for answer in answers:
        assert answer.delay_ns >= 0
    return b"".join(answer.data for answer in answers)


def _instructions(rng: Random, frame: Framing) -> list[bytes]:
    """Return instructions that are well-formed and sensible, or well-formed."""
    made = [frame(rng.choice((1, 2, 3, 0xFE)), _body(rng)) for _ in range(4)]
    return [*made, frame(rng.randrange(255), rng.randbytes(rng.randrange(1, 20)))]


def _body(rng: Random) -> bytes:
    address, size = rng.randrange(256), rng.choice((1, 2, 4, 10))
    return bytes((rng.choice(_INSTRUCTIONS),)) + rng.choice((
        b"", bytes((address, size)), bytes((address, 0, size, 0)), bytes((address,)) + rng.randbytes(size),
        bytes((address, 0)) + rng.randbytes(size), bytes((address, size, 1)) + rng.randbytes(size),
        bytes((address, 0, size, 0, 1)) + rng.randbytes(size), bytes((address, 0, size, 0, 1, 2, 3)),
        bytes((address, size, 1, 2, 3)), rng.randbytes(rng.randrange(1, 12))))


def trials() -> Iterator[tuple[str, Callable[[Random], bytes]]]:
    """Return every one, with its name."""
    yield "fakes' Dynamixel 2.0", parser(DynamixelParser(), _dynamixel, oracle.dynamixel_frames)
    yield "fakes' Dynamixel 1.0, Feetech", parser(ChecksumParser(), oracle.checksummed, oracle.checksum_frames)
    for name in ("xl430-w250", "xl330-m288"):
        yield f"fake {name}", trial_of(name, _dynamixel, oracle.dynamixel_frames)
    for name in ("ax-12a", "sts3215", "scs15"):
        yield f"fake {name}", trial_of(name, oracle.checksummed, oracle.checksum_frames)
