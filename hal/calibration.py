"""Radians <-> encoder ticks for one joint."""

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Calibration:
    """How a servo sits in its joint: angle = zero + direction x (ticks - centre) x radians_per_tick.

    Attributes:
        direction: +1 if the joint's angle grows with the encoder's ticks, -1 if it falls.
        zero: the joint's angle when the encoder is at its centre, rad.
        centre: the encoder's ticks at the middle of its range.
        radians_per_tick: the angle of one tick, rad.
    """

    direction: int
    zero: float
    centre: int
    radians_per_tick: float

    def __post_init__(self) -> None:
        if self.direction not in (1, -1):
            raise ValueError(f"direction is +1 or -1, not {self.direction}")
        if not math.isfinite(self.zero):
            raise ValueError(f"zero is a finite angle, not {self.zero}")
        if not 0.0 < self.radians_per_tick < math.inf:
            raise ValueError(f"radians_per_tick is positive and finite, not {self.radians_per_tick}")

    def ticks(self, angle: float) -> int:
        """Return the ticks nearest to `angle` (rad). Raises ValueError on NaN and inf."""
        ticks = self.centre + self.direction * (angle - self.zero) / self.radians_per_tick
        if not math.isfinite(ticks):
            raise ValueError(f"no encoder shows an angle of {angle} rad")
        return round(ticks)

    def angle(self, ticks: int) -> float:
        """Return the joint's angle, rad."""
        return self.zero + self.direction * (ticks - self.centre) * self.radians_per_tick

    def speed(self, counts: int, rad_per_s_per_count: float) -> float:
        """Return the joint's speed, rad/s, from the counts of the servo's velocity register."""
        return self.direction * counts * rad_per_s_per_count
