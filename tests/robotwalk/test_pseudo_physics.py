"""The particles on their pogo sticks, against the figures of PPS section 4."""

import math
from collections.abc import Sequence

import pytest

from robotwalk.gait import Sector
from robotwalk.pseudo_physics import GRAVITY, Particle, Stage, mean_height, step_at

RATE = 200
HALF = (Sector(0.0, 0.5, 0.5),)
LONG_SWING = (Sector(0.0, 2.0 / 3.0, 1.0 / 3.0),)


def heights(sectors: Sequence[Sector], period: float, turns: int = 1) -> list[float]:
    """Tick a particle from rest, and return its heights once it is steady, from the phase 0 on."""
    particle, phase, ticks = Particle(), 0.0, round(period * RATE)
    seen = []
    for tick in range((6 + turns) * ticks):
        if tick >= 6 * ticks:
            seen.append(particle.height)
        particle.tick(sectors, phase, period, 1.0 / RATE)
        phase = ((tick + 1) % ticks) / ticks
    return seen


def test_figure_9_a_stance_is_half_reception_half_propulsion() -> None:
    """(a) swing as long as stance, (b) swing two thirds of the circle."""
    for sectors, borders in ((HALF, (0.5, 0.75)), (LONG_SWING, (2 / 3, 5 / 6))):
        first, second = borders
        phases = (0.01, first - 0.01, first + 0.01, second - 0.01, second + 0.01, 0.99)
        stages = [step_at(sectors, phase).stage for phase in phases]
        assert stages == [stage for stage in (Stage.SWING, Stage.RECEPTION, Stage.PROPULSION) for _ in range(2)]
        assert step_at(sectors, borders[0]).left == pytest.approx(borders[1] - borders[0])


def test_figure_10a_with_equal_swing_and_stance_the_height_is_nearly_a_sine() -> None:
    seen = heights(HALF, 0.8)
    size = len(seen)
    mean = sum(seen) / size
    s = 2.0 / size * sum(h * math.sin(math.tau * k / size) for k, h in enumerate(seen))
    c = 2.0 / size * sum(h * math.cos(math.tau * k / size) for k, h in enumerate(seen))
    power = sum((h - mean) ** 2 for h in seen)
    assert 0.5 * size * (s * s + c * c) / power > 0.99
    assert mean == pytest.approx(0.0, abs=0.01 * max(seen))


def test_figure_10b_with_a_long_swing_the_height_is_ballistic_arcs() -> None:
    period = 0.9
    seen, ground = heights(LONG_SWING, period, turns=2), GRAVITY
    flying = seen[3:round(period * RATE * 2 / 3) - 3]
    bends = [(a - 2.0 * b + c) * RATE * RATE for a, b, c in zip(flying, flying[1:], flying[2:], strict=False)]
    assert bends == pytest.approx([-ground] * len(bends), rel=1e-6)
    # Down at the preferred height, as it was thrown up from there; the stance is short and deep.
    assert seen[0] == pytest.approx(0.0, abs=0.02)
    assert max(seen) == pytest.approx(ground * (period * 2 / 3) ** 2 / 8.0, rel=0.05)
    assert min(seen) > -0.5 * max(seen) - 0.02
    assert mean_height(LONG_SWING) * period * period == pytest.approx(sum(seen) / len(seen), abs=0.01)


def test_figure_11_the_body_moves_by_the_mean_of_its_feet() -> None:
    """Two feet in antiphase cancel each other; with a quarter between them, a smaller sine of the same period stays."""
    first = heights(HALF, 0.8, turns=2)
    size = len(first) // 2

    def body(shift: int) -> list[float]:
        return [0.5 * (first[k] + first[k + shift]) for k in range(size)]

    assert max(map(abs, body(size // 2))) < 0.01 * max(first)
    quarter = body(size // 4)
    assert 0.6 * max(first) < max(quarter) < 0.8 * max(first)
    assert quarter.index(max(quarter)) == pytest.approx((first.index(max(first)) - size // 8) % size, abs=2)


@pytest.mark.parametrize("phase", [0.0, 0.1, 0.49, 0.55, 0.8, 0.99])
def test_a_particle_may_begin_in_steady_motion(phase: float) -> None:
    period = 0.8
    steady, ticked = Particle.steady(HALF, phase, period), heights(HALF, period)
    assert steady.height == pytest.approx(ticked[round(phase * period * RATE)], abs=0.005)
