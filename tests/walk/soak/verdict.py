"""What a sequence may not do, and what many of them came to."""

import math
from collections.abc import Sequence

from .run import Outcome

# m of slip in a step, the 95th percentile
BOUNDS = {"hexapod": 5e-3, "quadruped": 7e-3, "octopod": 5e-3, "pentapod": 5e-3}


def violations(outcome: Outcome) -> list[str]:
    """Return what a single sequence violated, in words."""
    found = []
    joint, speed = outcome.joint, outcome.speed
    if outcome.fell is not None:
        found.append(f"fell at {outcome.fell.time:.2f} s ({outcome.fell.where})")
    if outcome.stopped is not None:
        found.append(outcome.stopped)
    if joint.value > 0.0:
        found.append(f"{joint.where} was {math.degrees(joint.value):.1f} deg beyond its limit at {joint.time:.2f} s")
    if speed.value > outcome.speed_bound:
        found.append(
            f"the target of {speed.where} moved at {speed.value:.2f} m/s, not {outcome.speed_bound:.2f}, "
            f"at {speed.time:.2f} s")
    return found


def slip(outcomes: Sequence[Outcome], share: float) -> float:
    """Return the slip, m, that this share of all steps stayed below."""
    return _share([slip.distance for outcome in outcomes for slip in outcome.slips], share)


def summary(robot: str, outcomes: Sequence[Outcome]) -> tuple[str, bool]:
    """Return the figures of all sequences of a robot, in words, and whether they slipped as little as they should."""
    p95, bound = slip(outcomes, 0.95), BOUNDS[robot]
    steps = sum(len(outcome.slips) for outcome in outcomes)
    far = max((step.distance, outcome.seed, step.time) for outcome in outcomes for step in outcome.slips)
    joint = max(outcomes, key=lambda outcome: outcome.joint.value)
    speed = max(outcomes, key=lambda outcome: outcome.speed.value)
    tilt = max(outcomes, key=lambda outcome: outcome.tilt.value)
    falls = [outcome.seed for outcome in outcomes if outcome.fell is not None]
    ways = _share([step.way for outcome in outcomes for step in outcome.slips], 0.95)
    return (
        f"{robot}: {len(outcomes)} sequences, {steps} steps; {len(falls)} falls{_listed(falls)}\n"
        f"  slip of a step: median {1e3 * slip(outcomes, 0.5):.1f} mm, p95 {1e3 * p95:.1f} (bound {1e3 * bound:.0f}), "
        f"p99 {1e3 * slip(outcomes, 0.99):.1f}, largest {1e3 * far[0]:.0f} (seed {far[1]}, {far[2]:.1f} s); "
        f"to and fro p95 {1e3 * ways:.1f}\n"
        f"  joints: {sum(outcome.joint.value > 0.0 for outcome in outcomes)} sequences with one beyond its limit, "
        f"the farthest {math.degrees(joint.joint.value):.1f} deg (seed {joint.seed}, {joint.joint.where})\n"
        f"  fastest target of a foot {speed.speed.value:.2f} m/s (seed {speed.seed}), bound {speed.speed_bound:.2f}; "
        f"largest tilt {math.degrees(tilt.tilt.value):.0f} deg (seed {tilt.seed})"), p95 < bound


def _listed(seeds: Sequence[int]) -> str:
    return f" (seeds {', '.join(map(str, seeds))})" if seeds else ""


def _share(values: Sequence[float], share: float) -> float:
    ordered = sorted(values)
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)]
