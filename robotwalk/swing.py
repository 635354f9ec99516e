"""How a foot is carried over: across the ground with least jerk, and up along a curve.

Along the ground the foot follows, from wherever it is and however fast it moves, the quintic that ends at
rest on the target (Flash and Hogan 1985). Solved anew in each tick, it takes a moving target without a jump
in position, velocity or acceleration, and a fixed target gives the plain minimum-jerk curve. Upwards the foot
follows a curve over the way already made, so both velocities vanish at lift-off and at touchdown.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

_ROUNDING = 0.15


class Motion(NamedTuple):
    """Position, velocity and acceleration along one axis."""

    position: float
    velocity: float
    acceleration: float


def least_jerk(motion: Motion, target: float, remaining: float, dt: float) -> Motion:
    """Go on for `dt` s on the quintic that comes to rest at `target` after `remaining` s."""
    if remaining <= dt:
        return Motion(target, 0.0, 0.0)
    p, v, a = motion
    r, inverse = remaining, 1.0 / remaining
    way = target - p - (v + 0.5 * a * r) * r
    dv, da = (v + a * r) * r, a * r * r
    cubed = inverse * inverse * inverse
    c3 = (10.0 * way + 4.0 * dv - 0.5 * da) * cubed
    c4 = (-15.0 * way - 7.0 * dv + da) * cubed * inverse
    c5 = (6.0 * way + 3.0 * dv - 0.5 * da) * cubed * inverse * inverse
    return Motion(
        p + (v + (0.5 * a + (c3 + (c4 + c5 * dt) * dt) * dt) * dt) * dt,
        v + (a + (3.0 * c3 + (4.0 * c4 + 5.0 * c5 * dt) * dt) * dt) * dt,
        a + (6.0 * c3 + (12.0 * c4 + 20.0 * c5 * dt) * dt) * dt,
    )


def way_made(progress: float) -> float:
    """Return the share of the way behind a foot after a share of its swing's time, both 0 to 1."""
    u = min(max(progress, 0.0), 1.0)
    return u * u * u * (10.0 + u * (-15.0 + 6.0 * u))


def parabola(way: float) -> float:
    """Return the height over the way made, both 0 to 1 (PPS section 3)."""
    return 4.0 * way * (1.0 - way)


def half_ellipse(way: float) -> float:
    """Return the height over the way made, both 0 to 1 (ARTH figure 3, its first half).

    A true ellipse starts upright, which no servo follows; its ends are rounded by `_ROUNDING` of its height.
    """
    chord = 4.0 * max(way * (1.0 - way), 0.0)
    return (math.sqrt(chord + _ROUNDING**2) - _ROUNDING) / (math.sqrt(1.0 + _ROUNDING**2) - _ROUNDING)


SWING_PATHS: dict[str, Callable[[float], float]] = {"parabola": parabola, "half_ellipse": half_ellipse}
