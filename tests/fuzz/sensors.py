"""What the host makes of a sensor's garbled line: no frame that was not there, and the next one whole."""

import struct
from collections.abc import Callable, Iterator
from random import Random

from hal.foot_switches import frame as foot_switches
from hal.imu import uart_rvc, witmotion
from hal.unasked_frames import FrameReceiver, Framing

from .garble import garbled, pieces


def _rvc(rng: Random) -> bytes:
    body = bytes([rng.randrange(256)]) + struct.pack("<6h", *(rng.randint(-9000, 9000) for _ in range(6))) + bytes(3)
    return b"\xaa\xaa" + body + bytes([sum(body) % 256])


def _packet(rng: Random) -> bytes:
    body = b"\x55" + bytes([rng.randrange(0x50, 0x55)]) + rng.randbytes(8)
    return body + bytes([sum(body) % 256])


def _switches(rng: Random) -> bytes:
    body = b"FS" + rng.randbytes(2)
    return body + bytes([sum(body) % 256])


def _line(
    framing: Framing, make: Callable[[Random], bytes], decoder: Callable[[], Callable[[bytes], object]]
) -> Callable[[Random], bytes]:
    receiver, decode = FrameReceiver(framing), decoder()

    def trial(rng: Random) -> bytes:
        receiver.reset()
        stream = garbled(rng, [make(rng) for _ in range(4)])
        stray, taken = receiver.stray_bytes, 0
        for piece in pieces(rng, stream):
            for frame in receiver.take(piece):
                assert frame in stream
                assert sum(frame[framing.summed_from:-1]) % 256 == frame[-1]
                decode(frame)
                taken += framing.size
        kept = len(receiver._buffer)
        assert kept < framing.size
        assert taken + kept + receiver.stray_bytes - stray == len(stream), "every byte is accounted for"
        receiver.reset()
        frame = make(rng)
        assert receiver.take(bytes(rng.randrange(0x50) for _ in range(rng.randrange(6))) + frame) == [frame]
        return stream

    return trial


def trials() -> Iterator[tuple[str, Callable[[Random], bytes]]]:
    """Return every one, with its name."""
    yield "IMU, UART-RVC", _line(uart_rvc.FRAMING, _rvc, lambda: uart_rvc.decode)
    yield "IMU, WitMotion", _line(witmotion.FRAMING, _packet, witmotion.Decoder)
    yield "foot switches", _line(foot_switches.FRAMING, _switches, lambda: foot_switches.decode)
