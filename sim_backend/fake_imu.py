"""A fake IMU: it talks on a line of its own, as often as it is set to, about what MuJoCo's sensors feel.

Its encoders are written from the data sheets that `hal.imu` names, and share nothing with the decoders there.
Not modelled: the lag of its filter, what acceleration does to its idea of up, its axes' scale and misalignment, the
compass (yaw is the world's), and drift.
"""

import math
import struct
from collections.abc import Callable, Mapping
from random import Random
from typing import NamedTuple

from sim_backend.talker import Talker

Triple = tuple[float, float, float]

_G = 9.80665  # m/s^2


class SimulatedImu(NamedTuple):
    """One IMU to be made. Errors are standard deviations: a bias is drawn once, noise for each measurement."""

    frames: str  # as it is named in configs/imus
    baud: int
    rate_hz: float
    mounting: Triple  # roll, pitch, yaw of the sensor in the base, rad
    tilt_bias: float  # rad
    tilt_noise: float  # rad
    gyro_bias: float  # rad/s
    gyro_noise: float  # rad/s
    acceleration_noise: float  # m/s^2


class Felt(NamedTuple):
    """What MuJoCo's sensors have, in the sensor's frame."""

    attitude: tuple[float, float, float, float]  # in the world, w, x, y, z
    angular_velocity: Triple  # rad/s
    acceleration: Triple  # m/s^2, at rest one g upwards


class FakeImu(Talker):
    """What hangs on the far end of its line."""

    def __init__(self, kind: SimulatedImu, felt: Callable[[], Felt], seed: int) -> None:
        """Make it; `felt` tells what its sensors have now."""
        self._kind = kind
        self._felt = felt
        super().__init__(kind.rate_hz)
        self._chance = Random(f"imu {seed}")
        self._bias = [self._chance.gauss(0.0, kind.tilt_bias) for _ in range(2)]
        self._gyro_bias = [self._chance.gauss(0.0, kind.gyro_bias) for _ in range(3)]
        self._encode = _ENCODERS[kind.frames]
        self._count = -1  # of measurements

    def report(self) -> bytes:
        """Return a measurement."""
        self._count += 1
        kind, gauss, felt = self._kind, self._chance.gauss, self._felt()
        # Errors of tilt are small turns about the sensor's x and y.
        x, y = (0.5 * (bias + gauss(0.0, kind.tilt_noise)) for bias in self._bias)
        w, a, b, c = felt.attitude
        attitude = (w - a * x - b * y, a + w * x - c * y, b + w * y + c * x, c + a * y - b * x)
        rate = [
            true + bias + gauss(0.0, kind.gyro_noise)
            for true, bias in zip(felt.angular_velocity, self._gyro_bias, strict=True)]
        acceleration = [true + gauss(0.0, kind.acceleration_noise) for true in felt.acceleration]
        return self._encode(self._count, attitude, rate, acceleration)


def _rotation(attitude: tuple[float, float, float, float]) -> list[list[float]]:
    """Return the matrix of an attitude that may be a little longer than 1."""
    size = math.sqrt(sum(part * part for part in attitude))
    w, x, y, z = (part / size for part in attitude)
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


def _uart_rvc(
    count: int, attitude: tuple[float, float, float, float], rate: list[float], acceleration: list[float]
) -> bytes:
    """Return a frame; its angles turn about z, then x, then y."""
    m = _rotation(attitude)
    yaw, pitch, roll = (
        math.atan2(-m[0][1], m[1][1]), math.asin(min(max(m[2][1], -1.0), 1.0)), math.atan2(-m[2][0], m[2][2]))
    body = struct.pack(
        "<B6h3x", count & 0xFF, *(round(math.degrees(angle) * 100.0) for angle in (yaw, pitch, roll)),
        *(_short(part / _G * 1000.0) for part in acceleration))
    return b"\xaa\xaa" + body + bytes([sum(body) & 0xFF])


def _witmotion(
    count: int, attitude: tuple[float, float, float, float], rate: list[float], acceleration: list[float]
) -> bytes:
    """Return three packets; its angles turn about z, then y, then x."""
    m = _rotation(attitude)
    roll, pitch, yaw = (
        math.atan2(m[2][1], m[2][2]), math.asin(min(max(-m[2][0], -1.0), 1.0)), math.atan2(m[1][0], m[0][0]))
    packets = (
        (0x51, [part / (16.0 * _G) for part in acceleration]),
        (0x52, [math.degrees(part) / 2000.0 for part in rate]),
        (0x53, [angle / math.pi for angle in (roll, pitch, yaw)]))
    said = b""
    for kind, shares in packets:
        packet = struct.pack("<2B3h2x", 0x55, kind, *(_short(share * 32768.0) for share in shares))
        said += packet + bytes([sum(packet) & 0xFF])
    return said


def _short(value: float) -> int:
    """Round to what 16 bits hold."""
    return min(max(round(value), -32768), 32767)


_ENCODERS: Mapping[str, Callable[[int, tuple[float, float, float, float], list[float], list[float]], bytes]] = {
    "uart-rvc": _uart_rvc,
    "witmotion": _witmotion,
}
