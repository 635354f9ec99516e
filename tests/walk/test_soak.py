"""Ten of the sequences of `make soak`: no fall, no joint beyond its limits, no foot that jumps, little slip."""

import pytest

from .soak.run import run
from .soak.verdict import BOUNDS, slip, violations

_SEEDS = {
    "hexapod": (10, 11, 12, 218, 243),  # in the last two stretched legs gave beyond their limits under the body
    # A change of gait lifted a foot off before another had landed (348, 520); the pace rocked a body that leaned over
    # (477), and had it jump as it set off anew (465).
    "quadruped": (10, 348, 465, 477, 520),
}


@pytest.mark.timeout(400)
@pytest.mark.parametrize("robot", ["hexapod", "quadruped"])
def test_whatever_is_commanded_a_robot_walks_on(robot: str) -> None:
    outcomes = [run(robot, seed) for seed in _SEEDS[robot]]
    for outcome in outcomes:
        assert violations(outcome) == [], f"seed {outcome.seed}"
        assert len(outcome.slips) > 20
    assert slip(outcomes, 0.95) < BOUNDS[robot]
