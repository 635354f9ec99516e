"""A foot that rises and slides with two waves, skewed so that swing and stance take different shares (PARAM, Gait).

Both waves have the period 2 pi. The bias b skews them alike: at 0 they are plain sines, over 0 the foot stands for
longer than it swings, below 0 it swings for longer. Whether a foot is in the air, `lift` alone decides: the two waves
change sides at slightly different moments (PARAM says so), and a planted foot that followed `slide` would be dragged.
"""

import math
from functools import lru_cache

from robotwalk.swing_paths import Motion, PathPoint

_NO_SKEW = 1e-4  # of a bias; below it the plain sine differs by less than 1e-4, and the formulae lose their digits


def lift(x: float, bias: float) -> float:
    """Return the up-down wave at x (rad), -1 to 1; the foot is in the air where it is positive."""
    if abs(bias) < _NO_SKEW:
        return math.sin(x)
    # 2 (k^sin x - 1/k) / (k - 1/k) - 1 with k = e^b
    return (math.exp(bias * math.sin(x)) - math.cosh(bias)) / math.sinh(bias)


def slide(x: float, bias: float) -> float:
    """Return the front-back wave at x (rad), scaled to -1 to 1."""
    k = 2.0 / math.pi * math.atan(bias)
    if abs(k) < _NO_SKEW:
        return math.sin(x)
    # The largest value of atan(k sin x / (1 - k cos x)) is at cos x = k.
    return math.atan2(k * math.sin(x), 1.0 - k * math.cos(x)) / math.asin(k)


@lru_cache(maxsize=64)
def lift_off(bias: float) -> float:
    """Return the first x at which a foot of this bias leaves the ground, rad; it lands at pi less that."""
    if abs(bias) < _NO_SKEW:
        return 0.0
    return math.asin(math.log(math.cosh(bias)) / bias)


def swing_share(bias: float) -> float:
    """Return the share of its cycle that a foot is in the air."""
    return 0.5 - lift_off(bias) / math.pi


def skewed(progress: float, bias: float) -> PathPoint:
    """Return the point of a swing by both waves, as a curve of `robotwalk.swing_paths`; the way leads from 0 to 1."""
    start = lift_off(bias)
    turn = math.pi - 2.0 * start  # rad of the wave in a swing
    x = start + progress * turn
    begin, end = slide(start - 0.5 * math.pi, bias), slide(0.5 * math.pi - start, bias)
    way, rate, bend = _slide_motion(x - 0.5 * math.pi, bias)
    height = _lift_motion(x, bias)
    length = end - begin
    return PathPoint(
        Motion((way - begin) / length, rate * turn / length, bend * turn * turn / length),
        Motion(max(height.position, 0.0), height.velocity * turn, height.acceleration * turn * turn))


def _lift_motion(x: float, bias: float) -> Motion:
    s, c = math.sin(x), math.cos(x)
    if abs(bias) < _NO_SKEW:
        return Motion(s, c, -s)
    scale = math.exp(bias * s) / math.sinh(bias)
    return Motion(lift(x, bias), bias * c * scale, bias * (bias * c * c - s) * scale)


def _slide_motion(x: float, bias: float) -> Motion:
    k, s, c = 2.0 / math.pi * math.atan(bias), math.sin(x), math.cos(x)
    if abs(k) < _NO_SKEW:
        return Motion(s, c, -s)
    above, below, largest = k * (c - k), 1.0 + k * (k - 2.0 * c), math.asin(k)
    return Motion(
        slide(x, bias), above / below / largest, -k * s * (below + 2.0 * above) / (below * below) / largest)
