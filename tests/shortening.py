"""What a leg does about a target that it cannot reach."""

import math

import pytest

from robotwalk.types import Vec3


def assert_shortened(
    joint: Vec3, foot: Vec3, target: Vec3, miss: float, shortest: float, longest: float
) -> None:
    """The foot lies on the line from the joint to the target, within the last fiftieth of the leg's reach."""
    assert math.dist(foot, target) == pytest.approx(miss, abs=1e-9)
    length, wanted, soft = math.dist(joint, foot), math.dist(joint, target), 0.02 * (longest - shortest)
    on_ray = [j + (t - j) * length / wanted for j, t in zip(joint, target, strict=True)]
    assert math.dist(foot, on_ray) < 1e-6
    if 2.0 * wanted > shortest + longest:
        assert longest - soft * math.exp(-1.0) - 2e-6 < length < longest
    else:
        assert shortest < length < shortest + soft * math.exp(-1.0) + 2e-6
