"""What the feet feel of the way down."""

import math

import pytest

from robotwalk.contact import Felt
from robotwalk.plumb import Plumb
from robotwalk.statics import GRAVITY
from robotwalk.types import LEVEL, Vec3

MASS, DT = 2.0, 0.01
SHIFT, PERIOD = 0.3, 2.0  # m to both sides, s; wide, for what is left is averaged away


def turned(leans: float, *, sways: bool) -> float:
    """Return by how far odom is turned about the body's x axis in 10 s in which it really leans so far, rad."""
    plumb, roll, rate = Plumb(MASS), 0.0, math.tau / PERIOD
    for tick in range(1000):
        y = SHIFT * math.sin(rate * tick * DT) if sways else 0.0
        sideways = GRAVITY * math.sin(leans) - rate * rate * y
        foot = Felt(Vec3(0.0, MASS * sideways / 4, MASS * GRAVITY / 4), MASS * GRAVITY / 4, touching=True, sure=True)
        turn = plumb.step(LEVEL._replace(y=y, roll=roll), (foot,) * 4, (True,) * 4, None, DT, PERIOD)
        roll += turn.roll if turn is not None else 0.0
    return roll


@pytest.mark.parametrize("sways", [False, True])
def test_what_a_body_is_told_to_speed_up_by_is_no_slope(sways: bool) -> None:
    assert turned(0.0, sways=sways) == 0.0
    assert turned(math.radians(8.0), sways=sways) == pytest.approx(math.radians(6.0), abs=math.radians(0.5))
