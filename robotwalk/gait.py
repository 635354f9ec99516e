"""When each foot swings: a needle that turns on each foot's circle (PPS section 3).

The phase is the needle's angle in turns, one for all feet. A coloured sector of a foot's circle is a swing,
the rest is stance. The period follows the speed: the stride lengthens first, up to the largest that each leg
may take, then the cadence rises (ARTH section 5.2: step duration is linked to speed).
"""

import math
from collections.abc import Sequence, Set
from functools import partial
from typing import NamedTuple

from robotwalk.config.gait_schema import GaitConfig
from robotwalk.errors import UsageError
from robotwalk.free_stepping import FreeStepping, SteppingCircles
from robotwalk.model import RobotModel
from robotwalk.oscillator import skewed
from robotwalk.swing_paths import SwingPath
from robotwalk.types import Twist

# The period follows a new gait or speed no faster than by this factor a second, so that no foot jumps.
_PERIOD_SLEW = 4.0
# The fastest swing is this much longer than the shortest that the robot can do: a landing is seen in the next tick,
# and a sector without any slack would be over before the foot that waited for it lifts off.
_SLACK = 1.05
_SAME = 1e-6  # turns
_NO_SPEED = 1e-9  # m/s; slower is standing still


class Sector(NamedTuple):
    """One swing on a foot's circle, in turns."""

    start: float  # in [0, 1)
    length: float  # in (0, 1)
    stance: float  # from its end to the foot's next lift-off

    def progress(self, phase: float) -> float:
        """Return how far into the sector the needle is, 0 to 1; outside it, 1 or more."""
        return ((phase - self.start) % 1.0) / self.length


class Balance(NamedTuple):
    """How a gait keeps the centre of mass over its standing feet."""

    margin: float  # m to the edge of their polygon
    acceleration: float  # m/s^2, the largest of a shift of the body


class Support(NamedTuple):
    """A part of the circle in which the same feet stand."""

    start: float  # in [0, 1)
    length: float  # turns
    standing: tuple[bool, ...]  # by foot

    def left(self, phase: float) -> float:
        """Return how far the needle is from its end, in turns; more than `length` outside it."""
        return (self.start + self.length - phase) % 1.0


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
        self.feet = tuple(_sectors(config.swing[leg]) for leg in legs)
        self.strides = tuple(config.stride_share * leg.max_stride for leg in model.legs)  # m, the largest
        self._sideways = config.sideways_mps or math.inf
        self.sideways_acceleration = config.sideways_mps2 or math.inf  # m/s^2
        self._ahead, self._askew = model.motion.speed, config.askew_mps
        self.longest_stance = tuple(max(sector.stance for sector in sectors) for sectors in self.feet)
        shortest_swing = min(sector.length for sectors in self.feet for sector in sectors)
        self.fastest_period = max(_SLACK * model.motion.min_swing / shortest_swing, config.fastest_period_s or 0.0)
        self.slowest_period = max(config.slowest_period_s, self.fastest_period)
        self.balance = None if config.balance is None else Balance(
            config.balance.margin_mm * 1e-3, config.balance.acceleration_mps2)
        self.rocking = config.rocking
        # None: the legs' own
        self.swing_path = None if config.bias is None else SwingPath(partial(skewed, bias=config.bias))
        self.supports = self._supports()
        self._together = [
            {foot for foot, stands in enumerate(support.standing) if not stands} for support in self.supports]
        # In between, fewer than three feet stand: the body tips, the longer the farther.
        self.tips = min(sum(support.standing) for support in self.supports) < 3
        self.dynamic = self.tips or self.rocking > 0.0  # balanced only by its motion
        # None: the needle tells when a foot lifts off
        self.free: FreeStepping | None = None
        if isinstance(config, SteppingCircles):
            self.free = FreeStepping(config.stepping, model, self.slowest_period)
        self._rests = tuple((leg.rest_foot.x, leg.rest_foot.y) for leg in model.legs)

    @property
    def starts(self) -> list[float]:
        """The phases at which some foot lifts off, sorted."""
        return sorted({sector.start for sectors in self.feet for sector in sectors})

    def _supports(self) -> tuple[Support, ...]:
        """Cut the circle at every lift-off and touchdown."""
        ends = {(sector.start + sector.length) % 1.0 for sectors in self.feet for sector in sectors}
        cuts: list[float] = []
        for cut in sorted(ends.union(self.starts)):
            if not cuts or cut - cuts[-1] > _SAME:  # the end of one swing may be the start of another
                cuts.append(cut)
        if cuts[0] + 1.0 - cuts[-1] <= _SAME:
            cuts.pop()
        supports = []
        for start, end in zip(cuts, [*cuts[1:], cuts[0] + 1.0], strict=True):
            middle = 0.5 * (start + end) % 1.0
            standing = tuple(self.sector_at(foot, middle) is None for foot in range(len(self.feet)))
            supports.append(Support(start, end - start, standing))
        return tuple(supports)

    def support_at(self, phase: float) -> int:
        """Return the index of the support that the needle is in."""
        return min(range(len(self.supports)), key=lambda index: (phase - self.supports[index].start) % 1.0)

    def sector_at(self, foot: int, phase: float) -> Sector | None:
        """Return the swing that a foot's needle is in, if any."""
        for sector in self.feet[foot]:
            if (phase - sector.start) % 1.0 < sector.length:
                return sector
        return None

    def lifts_together(self, feet: Set[int]) -> bool:
        """Tell whether these feet are in the air together at some phase."""
        return any(feet <= together for together in self._together)

    def until_lift_off(self, foot: int, phase: float) -> float:
        """Return how far the needle is from a foot's next lift-off, in turns."""
        return min([(sector.start - phase) % 1.0 for sector in self.feet[foot]])

    def largest_scale(self, twist: Twist, part: float = 1.0) -> float:
        """Return by how much a twist may be multiplied before a leg's stride is too long, even hurrying.

        The longest is a `part` of what it is else. A gait may have a largest speed to a side, and askew, too.
        """
        scale = self._sideways / abs(twist.vy) if abs(twist.vy) > _NO_SPEED else math.inf
        if self._askew is not None:
            scale = min(scale, self._askew_scale(twist, self._askew))
        for stride, stance, speed in zip(self.strides, self.longest_stance, self.foot_speeds(twist), strict=True):
            if speed > _NO_SPEED:
                scale = min(scale, part * stride / (speed * stance * self.fastest_period))
        return scale

    def _askew_scale(self, twist: Twist, askew: float) -> float:
        """Return by how much a twist may be multiplied before a foot passes over the ground too fast for its direction.

        Velocities end in half an ellipse ahead, as long as the robot's largest speed, and half a circle behind.
        """
        vx, vy, wz = twist
        most = 0.0
        for x, y in self._rests:
            ux, uy = vx - wz * y, vy + wz * x
            most = max(most, math.hypot(ux / (self._ahead if ux > 0.0 else askew), uy / askew))
        return 1.0 / most if most > 0.0 else math.inf

    def period(self, twist: Twist, wanted: float | None = None, part: float = 1.0) -> float:
        """Return the period for a twist, s: the `wanted` or slowest, unless a stride would be longer than its leg's.

        A gait whose body tips in between cannot be slower than its file has it.
        """
        period = self.slowest_period if wanted is None or (self.tips and wanted > self.slowest_period) else wanted
        for stride, stance, speed in zip(self.strides, self.longest_stance, self.foot_speeds(twist), strict=True):
            if speed > _NO_SPEED:
                period = min(period, part * stride / (speed * stance))
        return max(period, self.fastest_period)

    def foot_speeds(self, twist: Twist) -> list[float]:
        """Return how fast the body passes over each foot's rest position, m/s."""
        vx, vy, wz = twist
        return [math.hypot(vx - wz * y, vy + wz * x) for x, y in self._rests]


class GaitClock:
    """The needle. Feet in the air keep their own time, so a change of gait moves none of them."""

    def __init__(self, gait: Gait) -> None:
        self.gait = gait
        self.phase = gait.starts[0]
        self.period = gait.slowest_period

    def advance(
        self, twist: Twist, dt: float, bearable: float, period: float | None = None, part: float = 1.0
    ) -> None:
        """Turn the needle by one tick at the cadence for this twist, faster while the feet cannot bear it.

        `period` is the wanted one, s; it changes the needle's speed, and never its place. Strides are a `part` of what
        they may be else.
        """
        wanted = max(self.gait.period(twist, period, part) * bearable, self.gait.fastest_period)
        slew = _PERIOD_SLEW**dt
        self.period = min(max(wanted, self.period / slew), self.period * slew)
        self.phase = (self.phase + dt / self.period) % 1.0

    def change(self, gait: Gait, phase: float) -> None:
        """Go on with another gait from a phase of its circle."""
        self.gait = gait
        self.phase = phase

    def rewind(self, foot: int | None = None) -> None:
        """Put the needle to the next lift-off, of one foot or any, at the slowest cadence: a start from standing."""
        starts = self.gait.starts if foot is None else [sector.start for sector in self.gait.feet[foot]]
        self.period = self.gait.slowest_period
        self.phase = min(starts, key=lambda start: (start - self.phase) % 1.0)


def _sectors(spans: Sequence[tuple[float, float]]) -> tuple[Sector, ...]:
    """Turn the spans (start, end) of a foot's circle into sectors, each with the stance behind it."""
    ordered = sorted(spans)
    following = [*(start for start, _ in ordered[1:]), ordered[0][0] + 1.0]
    return tuple(
        Sector(start, end - start, after - end) for (start, end), after in zip(ordered, following, strict=True))
