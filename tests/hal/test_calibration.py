"""Radians to ticks and back, for servos mounted either way round."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.calibration import Calibration

TICK = 0.0015339807878856412  # rad, 4096 to a turn

UPRIGHT = Calibration(direction=1, zero=0.0, centre=2048, radians_per_tick=TICK)
MIRRORED = Calibration(direction=-1, zero=0.0, centre=2048, radians_per_tick=TICK)
OFFSET = Calibration(direction=-1, zero=0.5, centre=2048, radians_per_tick=TICK)

calibrations = st.builds(
    Calibration,
    direction=st.sampled_from([1, -1]),
    zero=st.floats(-math.pi, math.pi),
    centre=st.sampled_from([0, 512, 2048]),
    radians_per_tick=st.sampled_from([TICK, 0.005113269292952137]),
)


@pytest.mark.parametrize(
    ("calibration", "angle", "ticks"),
    [
        (UPRIGHT, 0.0, 2048),
        (UPRIGHT, math.pi / 2, 3072),
        (UPRIGHT, -math.pi / 2, 1024),
        (MIRRORED, math.pi / 2, 1024),
        (MIRRORED, -math.pi / 2, 3072),
        (OFFSET, 0.5, 2048),
        (OFFSET, 0.5 + math.pi / 4, 1536),
        (OFFSET, 0.5 - math.pi / 4, 2560),
    ],
)
def test_known_places(calibration: Calibration, angle: float, ticks: int) -> None:
    assert calibration.ticks(angle) == ticks
    assert calibration.angle(ticks) == pytest.approx(angle, abs=1e-12)


def test_the_nearest_tick_is_taken() -> None:
    assert UPRIGHT.ticks(10.4 * TICK) == 2058
    assert UPRIGHT.ticks(10.6 * TICK) == 2059
    assert MIRRORED.ticks(10.6 * TICK) == 2037


@given(calibrations, st.floats(-7.0, 7.0))
def test_there_and_back_is_within_half_a_tick(calibration: Calibration, angle: float) -> None:
    error = calibration.angle(calibration.ticks(angle)) - angle
    assert abs(error) <= 0.5 * calibration.radians_per_tick + 1e-9


@given(calibrations, st.integers(-1048575, 1048575))
def test_ticks_survive_the_way_to_radians_and_back(calibration: Calibration, ticks: int) -> None:
    assert calibration.ticks(calibration.angle(ticks)) == ticks


def test_speed_has_the_joints_sign() -> None:
    assert UPRIGHT.speed(100, 0.024) == pytest.approx(2.4)
    assert MIRRORED.speed(100, 0.024) == pytest.approx(-2.4)
    assert OFFSET.speed(-100, 0.024) == pytest.approx(2.4)


@pytest.mark.parametrize("angle", [math.nan, math.inf, -math.inf, 1.7e308])
def test_no_servo_is_sent_what_is_no_angle(angle: float) -> None:
    with pytest.raises(ValueError, match="no encoder shows an angle of"):
        OFFSET.ticks(angle)


@pytest.mark.parametrize(
    ("direction", "zero", "radians_per_tick", "complaint"),
    [
        (0, 0.0, TICK, r"direction is \+1 or -1, not 0"),
        (1, math.nan, TICK, "zero is a finite angle, not nan"),
        (1, 0.0, 0.0, "radians_per_tick is positive and finite, not 0.0"),
        (1, 0.0, math.nan, "radians_per_tick is positive and finite, not nan"),
    ],
)
def test_what_is_no_calibration(direction: int, zero: float, radians_per_tick: float, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        Calibration(direction, zero, 2048, radians_per_tick)
