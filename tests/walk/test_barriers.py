"""A block that is too high to step over: a plain walk stops in front of it, a behaviour goes round."""

from pathlib import Path

import pytest

from robotwalk.behaviours import KeepHeading
from robotwalk.estimator import Estimate
from robotwalk.testing import FakeRobot
from robotwalk.types import Command

BLOCK = """
schema: 1
name: block
description: a block of 150 mm, 0.3 m broad
lead_mm: 150
width_mm: 300
course:
  - {element: stairs, steps: 1, rise_mm: 150, tread_mm: 100}
  - {element: drop, depth_mm: 150}
"""


@pytest.fixture
def block(tmp_path: Path) -> str:
    path = tmp_path / "block.yaml"
    path.write_text(BLOCK)
    return str(path)


def test_a_plain_walk_stops_in_front_of_it_and_says_so(block: str) -> None:
    with FakeRobot("hexapod", terrain=block) as fake:
        fake.robot.stand()
        fake.robot.walk(vx=0.1, seconds=6.0)
        assert 0.05 < fake.base.x < 0.2
        stopped = fake.base
        fake.robot.walk(vx=0.1, seconds=1.0)  # it remembers
        assert abs(fake.base.x - stopped.x) < 0.02
        assert fake.max_tilt_deg < 15.0
        fake.robot.walk(vx=-0.1, seconds=1.5)
        assert fake.base.x < stopped.x - 0.08
        fake.robot.sit()
        kinds = [event.kind for event in fake.robot.events]
    assert kinds.count("obstacle") == 2
    assert "timeout" not in kinds


class _PastIt(KeepHeading):
    """Goes straight on until the block is behind."""

    def step(self, estimate: Estimate, dt: float) -> Command:
        self.done = estimate.pose.x > 0.65
        return super().step(estimate, dt)


def test_a_behaviour_goes_round_it(block: str) -> None:
    with FakeRobot("hexapod", terrain=block) as fake:
        fake.robot.stand()
        assert fake.robot.follow(_PastIt(0.0, speed=0.08, facing=0.0), seconds=45.0)
        assert fake.base.x > 0.55
        assert abs(fake.base.y) > 0.2
        assert not fake.fell
        assert "obstacle" in [event.kind for event in fake.robot.events]
