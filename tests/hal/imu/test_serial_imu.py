"""The driver: what it makes of bytes, silence, pauses and a port that is gone."""

import math
import struct

import pytest

from hal.imu.model import ImuConfig
from hal.imu.serial_imu import SerialImu

from ..unasked_rig import MS, Line
from .test_frames import RVC


def made(**keys: object) -> tuple[Line, SerialImu]:
    line = Line()
    config = ImuConfig.model_validate({"kind": "bno085-rvc", "port": "", "baud": 115200, **keys})
    imu = SerialImu(line, line, "uart-rvc", config)
    imu.read()
    return line, imu


def later(line: Line, imu: SerialImu, milliseconds: float, data: bytes = b"") -> object:
    line.time += round(milliseconds * MS)
    line.data += data
    return imu.read()


def test_nothing_is_known_before_the_first_frame() -> None:
    line, imu = made()
    assert later(line, imu, 10, RVC[:18]) is None
    state = later(line, imu, 10, RVC[18:])
    assert (state.age, state.valid) == (0.0, True)
    assert math.degrees(state.pitch) == pytest.approx(20.85, abs=0.01)


def test_what_is_silent_grows_old_and_then_invalid() -> None:
    line, imu = made(stale_after_s=0.1)
    first = later(line, imu, 10, RVC)
    young, old = later(line, imu, 60), later(line, imu, 60)
    assert (young.age, young.valid) == (pytest.approx(0.06), True)
    assert (old.age, old.valid) == (pytest.approx(0.12), False)
    assert old[:5] == first[:5]
    assert later(line, imu, 10, RVC).valid
    assert imu.statistics().max_age == pytest.approx(0.12)


def test_what_piled_up_in_a_pause_is_thrown_away() -> None:
    """A serial driver keeps the first 4096 bytes, so the last of them may be seconds old."""
    line, imu = made()
    later(line, imu, 10, RVC)
    state = later(line, imu, 3000, RVC * 200 + RVC[:7])
    assert (state.age, state.valid) == (pytest.approx(3.0), False)
    assert later(line, imu, 10, RVC[7:]).valid is False  # its beginning went with the rest
    assert later(line, imu, 10, RVC).valid
    assert imu.statistics().reports == 2


def test_a_port_that_is_gone_is_silence_with_a_reason() -> None:
    line, imu = made()
    later(line, imu, 10, RVC)
    line.gone = True
    assert later(line, imu, 400).valid is False
    line.gone = False  # it is not asked again
    assert later(line, imu, 10, RVC).valid is False
    assert imu.statistics().failure == "/dev/ttyUSB1 is gone: it ends"


def test_a_sensor_upside_down_tells_of_a_base_that_is_not() -> None:
    line, imu = made(mounting_deg=[180, 0, 0])
    # Lying flat upside down: its roll about y is 180 deg, and gravity pushes along its -z.
    body = struct.pack("<B6h3x", 0, 0, 0, 18000, 0, 0, -1000)
    state = later(line, imu, 10, b"\xaa\xaa" + body + bytes([sum(body) & 0xFF]))
    assert (state.roll, state.pitch) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert state.acceleration == pytest.approx((0.0, 0.0, 9.80665))
