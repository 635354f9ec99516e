"""Levelling against a plant of one line: ground that slopes, and a body that follows what it is told, late."""

import math
from collections import deque
from itertools import pairwise

import pytest

from robotwalk.levelling import Levelling
from robotwalk.settings import LevellingSettings
from robotwalk.types import LEVEL, Pose, Tilt

SETTINGS = LevellingSettings(36.0, 12.0, math.radians(12.0))
DT = 0.01


class Ground:
    """A slope in roll and pitch; `late` ticks pass before the body is where it was told to be."""

    def __init__(self, roll: float, pitch: float, late: int = 8) -> None:
        self.roll, self.pitch = roll, pitch
        self.told: deque[Pose] = deque([LEVEL], maxlen=late)
        self.levelling = Levelling(SETTINGS)

    def settle(self, seconds: float, wanted: Pose = LEVEL, valid: bool = True) -> list[tuple[float, float]]:
        """Return the body's roll and pitch against gravity, tick by tick."""
        tilts = []
        for _ in range(round(seconds / DT)):
            tilt = self.roll + self.told[0].roll, self.pitch + self.told[0].pitch
            tilts.append(tilt)
            self.told.append(self.levelling.step(wanted, self.told[-1], Tilt(*tilt) if valid else None, DT))
        return tilts


def test_the_body_becomes_level_without_swinging() -> None:
    tilts = Ground(math.radians(5.0), math.radians(-8.0)).settle(4.0)
    assert tilts[-1] == pytest.approx((0.0, 0.0), abs=math.radians(0.1))
    assert max(pitch for _, pitch in tilts) < math.radians(0.8)  # from -8 deg


def test_a_posture_that_is_asked_for_is_not_levelled_away() -> None:
    posture = LEVEL._replace(roll=math.radians(3.0))
    tilts = Ground(0.0, math.radians(6.0)).settle(4.0, posture)
    assert tilts[-1] == pytest.approx((posture.roll, 0.0), abs=math.radians(0.1))


def test_the_correction_has_a_limit_and_leaves_it_at_once() -> None:
    ground = Ground(0.0, math.radians(20.0))
    assert ground.settle(6.0)[-1][1] == pytest.approx(math.radians(8.0), abs=1e-6)
    ground.pitch = 0.0
    assert ground.settle(2.0)[-1][1] == pytest.approx(0.0, abs=math.radians(1.0))


def test_without_valid_data_it_eases_back() -> None:
    ground = Ground(0.0, math.radians(-8.0))
    ground.settle(4.0)
    assert not ground.levelling.at_rest
    tilts = ground.settle(3.0, valid=False)
    assert tilts[-1][1] == pytest.approx(ground.pitch, abs=math.radians(0.2))
    assert ground.levelling.at_rest
    steps = [abs(after[1] - before[1]) for before, after in pairwise(tilts)]
    assert max(steps) < math.radians(0.4)
