"""The one gate before the servos. Nothing bypasses it, and what it cuts is counted.

Each goal is held inside the joint's position range, below a speed and below an acceleration. A goal that is
not a number is refused: the joint brakes and stays. So does a leg that would meet another one or the body.
"""

import math
from collections import Counter
from collections.abc import Collection, Sequence
from typing import NamedTuple

from robotwalk.self_collision import SelfCollision


class JointLimit(NamedTuple):
    """What one joint's goal may do."""

    lower: float  # rad
    upper: float  # rad
    speed: float  # rad/s
    acceleration: float  # rad/s^2


class Gate:
    """Holds goals inside their limits, from the first goal on."""

    def __init__(
        self, names: Sequence[str], limits: Sequence[JointLimit], collision: SelfCollision | None = None
    ) -> None:
        self._names = tuple(names)
        self._limits = tuple(limits)
        self._collision = collision
        self._goals: Sequence[float] = ()
        self._speeds: list[float] = []
        self.cuts: Counter[tuple[str, str]] = Counter()  # (joint, what) -> goals cut

    def reset(self, positions: Sequence[float]) -> None:
        """Start from where the joints are, at rest; from there speed and acceleration are counted."""
        self._goals = positions
        self._speeds = [0.0] * len(self._limits)
        if self._collision is not None:
            self._collision.reset()

    def take(self, found: Collection[int], positions: Sequence[float]) -> None:
        """Go on from where some joints are, at rest: their servos never had the goals that they were sent last."""
        goals = list(self._goals)
        for index in found:
            goals[index], self._speeds[index] = positions[index], 0.0
        self._goals = goals

    def step(self, goals: Sequence[float], dt: float) -> tuple[float, ...]:
        """Return goals that may be sent, `dt` s after the last ones."""
        allowed, speeds = [], []
        rows = zip(goals, self._goals, self._speeds, self._limits, strict=True)
        for index, (goal, last, speed, limit) in enumerate(rows):
            lower, upper, top_speed, acceleration = limit
            wanted, change = (goal - last) / dt, acceleration * dt
            # One test for the usual case; it also fails for whatever is not a number.
            if not (
                lower <= goal <= upper and -top_speed <= wanted <= top_speed
                and -change <= wanted - speed <= change
            ):
                goal = self._cut(index, goal, dt)
                wanted = (goal - last) / dt
            allowed.append(goal)
            speeds.append(wanted)
        if self._collision is not None:
            for leg in self._collision.step(allowed, speeds, dt):
                for index in range(leg.start, leg.stop):
                    self._count(index, "collision")
                    allowed[index] = self._braked(index, dt)
                    speeds[index] = (allowed[index] - self._goals[index]) / dt
        self._goals, self._speeds = allowed, speeds
        return tuple(allowed)

    def _cut(self, index: int, goal: float, dt: float) -> float:
        """Return the nearest goal that one joint may have, and count what stood against the wanted one."""
        limit, last, speed = self._limits[index], self._goals[index], self._speeds[index]
        if not math.isfinite(goal):
            self._count(index, "not a number")
            goal = last
        elif not limit.lower <= goal <= limit.upper:
            self._count(index, "position")
            goal = min(max(goal, limit.lower), limit.upper)
        wanted = (goal - last) / dt
        if abs(wanted) > limit.speed:
            self._count(index, "speed")
            wanted = math.copysign(limit.speed, wanted)
        change = limit.acceleration * dt
        if abs(wanted - speed) > change:
            self._count(index, "acceleration")
            wanted = speed + math.copysign(change, wanted - speed)
        return _in_range(last + wanted * dt, last, limit)

    def _braked(self, index: int, dt: float) -> float:
        """Return the goal with which one joint brakes as hard as it may."""
        limit, last, speed = self._limits[index], self._goals[index], self._speeds[index]
        slower = math.copysign(max(abs(speed) - limit.acceleration * dt, 0.0), speed)
        return _in_range(last + slower * dt, last, limit)

    def _count(self, index: int, what: str) -> None:
        self.cuts[self._names[index], what] += 1


def _in_range(goal: float, last: float, limit: JointLimit) -> float:
    """Return a goal that is in a joint's range, or no farther out than the last one: braking has no say in that."""
    return min(max(goal, min(limit.lower, last)), max(limit.upper, last))
