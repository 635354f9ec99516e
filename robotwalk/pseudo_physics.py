"""What each foot does for the body's height: one particle a foot, on a pogo stick of its own (PPS section 4).

In the first half of its stance, the reception, a foot brings its falling particle to rest; in the second, the
propulsion, it throws it up so that it flies for as long as the foot swings and comes down at the preferred height.
Each foot acts as if it were alone. In steady motion the foot's acceleration is near g / duty.

PPS sets the take-off speed by its equation 5c over propulsion and swing together, which leaves the mean height far
above the preferred one. Here the particle is aimed at the preferred height at touchdown, so nothing drifts.
"""

from collections.abc import Iterator, Sequence
from enum import Enum
from functools import lru_cache
from typing import NamedTuple

from robotwalk.gait import Sector

GRAVITY = 9.81  # m/s^2
_INSTANT = 1e-7  # s
_TURNS = 50  # after which a motion is steady


class Stage(Enum):
    """What a foot is doing (PPS figure 9)."""

    RECEPTION = "reception"
    PROPULSION = "propulsion"
    SWING = "swing"


class Step(NamedTuple):
    """Where in its step a foot is."""

    stage: Stage
    left: float  # turns until the stage's end
    swing: float  # turns of the swing under way, or of the next


class Effort(NamedTuple):
    """What a foot's steady motion takes."""

    acceleration: float  # m/s^2, the largest that the foot gives its particle
    speed: float  # m/s, the fastest take-off


def step_at(sectors: Sequence[Sector], phase: float) -> Step:
    """Return where in its step a foot with these swings is."""
    begun = 0
    if len(sectors) > 1:
        begun = min(range(len(sectors)), key=lambda index: (phase - sectors[index].start) % 1.0)
    sector = sectors[begun]
    since = (phase - sector.start) % 1.0 - sector.length
    if since < 0.0:
        return Step(Stage.SWING, -since, sector.length)
    half, following = 0.5 * sector.stance, sectors[(begun + 1) % len(sectors)].length
    if since < half:
        return Step(Stage.RECEPTION, half - since, following)
    return Step(Stage.PROPULSION, max(sector.stance - since, 0.0), following)


def foot_acceleration(stage: Stage, height: float, speed: float, left: float, swing: float) -> float:
    """Return what a foot gives its particle, m/s^2 upwards.

    Args:
        stage: the foot's.
        height: of the particle over the preferred height, m.
        speed: of the particle, m/s upwards.
        left: s until the stage's end, more than 0.
        swing: s that the next swing takes.
    """
    if stage is Stage.SWING:
        return 0.0
    if stage is Stage.RECEPTION:
        return GRAVITY - speed / left
    take_off = (0.5 * GRAVITY * swing * swing - height - 0.5 * speed * left) / (swing + 0.5 * left)
    return GRAVITY + (take_off - speed) / left


class Particle:
    """The particle of one foot."""

    def __init__(self) -> None:
        """Begin at rest at the preferred height."""
        self.height = 0.0  # m over the preferred height
        self.speed = 0.0  # m/s

    @classmethod
    def steady(cls, sectors: Sequence[Sector], phase: float, period: float) -> "Particle":
        """Return one in steady motion, where it is at a phase."""
        particle = cls()
        for _ in range(_TURNS):
            list(_turn(particle, sectors, period))
        turns = (phase - _touchdown(sectors)) % 1.0
        for step in _stages(sectors):
            particle.advance(step, period, min(turns, step.left) * period)
            turns -= step.left
            if turns <= 0.0:
                break
        return particle

    def advance(self, step: Step, period: float, dt: float) -> float:
        """Go on for `dt` s of a stage that is not over by then; return the foot's acceleration, m/s^2."""
        if dt <= 0.0:
            return 0.0
        left = max(step.left * period, dt)
        given = foot_acceleration(step.stage, self.height, self.speed, left, step.swing * period)
        change = (given - GRAVITY) * dt
        self.height += (self.speed + 0.5 * change) * dt
        self.speed += change
        return given

    def tick(self, sectors: Sequence[Sector], phase: float, period: float, dt: float) -> None:
        """Go on for `dt` s from a phase, through as many stages as that takes."""
        while dt > _INSTANT:
            step = step_at(sectors, phase)
            span = min(max(step.left * period, _INSTANT), dt)
            self.advance(step, period, span)
            phase = (phase + span / period) % 1.0
            dt -= span


def steady_effort(sectors: Sequence[Sector], period: float) -> Effort:
    """Return what a foot's motion takes once it is steady: stage by stage, in each of which it is constant."""
    particle = Particle.steady(sectors, _touchdown(sectors), period)
    efforts = list(_turn(particle, sectors, period))
    return Effort(max(effort.acceleration for effort in efforts), max(effort.speed for effort in efforts))


@lru_cache(maxsize=256)
def mean_height(sectors: tuple[Sector, ...]) -> float:
    """Return the mean height of a foot's steady particle at a period of 1 s, m; it grows with the period squared."""
    particle = Particle.steady(sectors, _touchdown(sectors), 1.0)
    total = 0.0
    for step in _stages(sectors):
        height, speed = particle.height, particle.speed
        given = particle.advance(step, 1.0, step.left)
        # The integral of a parabola.
        total += step.left * (height + step.left * (0.5 * speed + step.left * (given - GRAVITY) / 6.0))
    return total


def _touchdown(sectors: Sequence[Sector]) -> float:
    return sectors[0].start + sectors[0].length


def _stages(sectors: Sequence[Sector]) -> Iterator[Step]:
    """Yield the stages of a turn, whole, from the first touchdown on."""
    for index, sector in enumerate(sectors):
        following, half = sectors[(index + 1) % len(sectors)].length, 0.5 * sector.stance
        yield Step(Stage.RECEPTION, half, following)
        yield Step(Stage.PROPULSION, half, following)
        yield Step(Stage.SWING, following, following)


def _turn(particle: Particle, sectors: Sequence[Sector], period: float) -> Iterator[Effort]:
    """Turn a foot's needle once; yield what each stage took, and its last speed."""
    for step in _stages(sectors):
        given = particle.advance(step, period, step.left * period)
        yield Effort(given, particle.speed)
