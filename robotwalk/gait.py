"""When each foot swings: a needle that turns on each foot's circle (PPS section 3).

The phase is the needle's angle in turns, one for all feet. A coloured sector of a foot's circle is a swing,
the rest is stance. The period follows the speed: the stride lengthens first, up to the largest that each leg
may take, then the cadence rises (ARTH section 5.2: step duration is linked to speed).
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.config.schema import GaitConfig
from robotwalk.errors import UsageError
from robotwalk.model import RobotModel
from robotwalk.types import Twist

# The period follows a new gait or speed no faster than by this factor a second, so that no foot jumps.
_PERIOD_SLEW = 4.0


class Sector(NamedTuple):
    """One swing on a foot's circle, in turns."""

    start: float  # in [0, 1)
    length: float  # in (0, 1)
    stance: float  # from its end to the foot's next lift-off

    def progress(self, phase: float) -> float:
        """Return how far into the sector the needle is, 0 to 1; outside it, 1 or more."""
        return ((phase - self.start) % 1.0) / self.length


class Gait:
    """A gait fitted to a robot's legs."""

    def __init__(self, config: GaitConfig, model: RobotModel) -> None:
        """Match the feet of a gait with those of a robot.

        Raises:
            UsageError: the gait is for other feet.
        """
        legs = [leg.name for leg in model.legs]
        if set(config.swing) != set(legs):
            raise UsageError(
                f"gait {config.name!r} is for the feet {', '.join(sorted(config.swing))}; "
                f"robot {model.name!r} has {', '.join(sorted(legs))}")
        self.name = config.name
        self.slowest_period = config.slowest_period_s
        self.feet = tuple(_sectors(config.swing[leg]) for leg in legs)
        self.longest_stance = tuple(max(sector.stance for sector in sectors) for sectors in self.feet)
        shortest_swing = min(sector.length for sectors in self.feet for sector in sectors)
        self.fastest_period = min(model.motion.min_swing / shortest_swing, self.slowest_period)
        self.most_swinging = max(
            sum(self.sector_at(foot, start) is not None for foot in range(len(legs))) for start in self.starts)
        self._model = model

    @property
    def starts(self) -> list[float]:
        """The phases at which some foot lifts off, sorted."""
        return sorted({sector.start for sectors in self.feet for sector in sectors})

    def sector_at(self, foot: int, phase: float) -> Sector | None:
        """Return the swing that a foot's needle is in, if any."""
        for sector in self.feet[foot]:
            if (phase - sector.start) % 1.0 < sector.length:
                return sector
        return None

    def until_lift_off(self, foot: int, phase: float) -> float:
        """Return how far the needle is from a foot's next lift-off, in turns."""
        return min((sector.start - phase) % 1.0 for sector in self.feet[foot])

    def largest_scale(self, twist: Twist) -> float:
        """Return by how much a twist may be multiplied before a leg's stride is too long, even hurrying."""
        scale = math.inf
        for leg, stance, speed in zip(self._model.legs, self.longest_stance, self.foot_speeds(twist), strict=True):
            if speed > 0.0:
                scale = min(scale, leg.max_stride / (speed * stance * self.fastest_period))
        return scale

    def period(self, twist: Twist) -> float:
        """Return the period for a twist, s: the slowest, unless a stride would be longer than its leg's."""
        period = self.slowest_period
        for leg, stance, speed in zip(self._model.legs, self.longest_stance, self.foot_speeds(twist), strict=True):
            if speed > 0.0:
                period = min(period, leg.max_stride / (speed * stance))
        return max(period, self.fastest_period)

    def foot_speeds(self, twist: Twist) -> list[float]:
        """Return how fast the body passes over each foot's rest position, m/s."""
        vx, vy, wz = twist
        return [math.hypot(vx - wz * leg.rest_foot.y, vy + wz * leg.rest_foot.x) for leg in self._model.legs]


class GaitClock:
    """The needle. Feet in the air keep their own time, so a change of gait moves none of them."""

    def __init__(self, gait: Gait) -> None:
        self.gait = gait
        self.phase = gait.starts[0]
        self.period = gait.slowest_period

    def advance(self, twist: Twist, dt: float, bearable: float) -> None:
        """Turn the needle by one tick at the cadence for this twist, faster while the feet cannot bear it."""
        wanted = max(self.gait.period(twist) * bearable, self.gait.fastest_period)
        slew = _PERIOD_SLEW**dt
        self.period = min(max(wanted, self.period / slew), self.period * slew)
        self.phase = (self.phase + dt / self.period) % 1.0

    def change(self, gait: Gait, phase: float) -> None:
        """Go on with another gait from a phase of its circle."""
        self.gait = gait
        self.phase = phase

    def rewind(self) -> None:
        """Put the needle to the next lift-off, for a start from standing."""
        self.phase = min(self.gait.starts, key=lambda start: (start - self.phase) % 1.0)


def _sectors(spans: Sequence[tuple[float, float]]) -> tuple[Sector, ...]:
    """Turn the spans (start, end) of a foot's circle into sectors, each with the stance behind it."""
    ordered = sorted(spans)
    following = [*(start for start, _ in ordered[1:]), ordered[0][0] + 1.0]
    return tuple(
        Sector(start, end - start, after - end) for (start, end), after in zip(ordered, following, strict=True))
