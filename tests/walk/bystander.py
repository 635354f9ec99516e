"""Looks at a simulated robot as a bystander would, all the time: how it lies, how its joints move, when it is safe."""

import math
from typing import NamedTuple

from robotwalk import assembly

from .joint_watch import JointWatch

_EVERY = 4  # physics steps
_STILL = 0.2  # rad/s of every joint; limp ones sink a little
_REST = 1_000_000_000  # ns
_DOWN = 0.01  # m above its seated height at which a body is down


class Seen(NamedTuple):
    """One look."""

    t: float  # s
    height: float  # m
    tilt: float  # rad
    speed: float  # rad/s of the fastest joint
    fastest: int  # which joint that is


class Bystander:
    """Looks on from now on."""

    def __init__(self, simulation: assembly.Simulation) -> None:
        self.seen: list[Seen] = []
        self.joints = JointWatch(simulation)
        self._world, self._model = simulation.world, simulation.robot.model
        self._steps, self._last = 0, simulation.world.truth()
        simulation.world.observers.append(self._look)

    def _look(self) -> None:
        self._steps += 1
        if self._steps % _EVERY:
            return
        truth, last = self._world.truth(), self._last
        self._last = truth
        dt = truth.time - last.time
        speeds = [abs(b - a) / dt for a, b in zip(last.joints, truth.joints, strict=True)]
        fastest = max(range(len(speeds)), key=speeds.__getitem__)
        tilt = max(abs(truth.base.roll), abs(truth.base.pitch))
        self.seen.append(Seen(truth.time, truth.base.z - truth.ground, tilt, speeds[fastest], fastest))

    def after(self, t: float) -> list[Seen]:
        """Return what was seen from a time on."""
        return [look for look in self.seen if look.t >= t]

    def largest_tilt(self) -> float:
        """Return it, deg."""
        return math.degrees(max(look.tilt for look in self.seen))

    def fastest_drop(self) -> float:
        """Return the fastest that the body came down, over a tenth of a second, m/s."""
        dt = self.seen[1].t - self.seen[0].t
        stride = max(round(0.1 / dt), 1)
        return max(
            (self.seen[i].height - self.seen[i + stride].height) / (stride * dt)
            for i in range(len(self.seen) - stride))

    def sees_it_down(self) -> bool:
        """Wait until all has come to rest; tell whether the body lies on the ground, upright, joints still."""
        clock = self._world.clock
        clock.wait((), clock.now() + _REST)
        last = self.seen[-1]
        return self._is_down(last) and math.degrees(last.tilt) < 6.0

    def safe_after(self, t: float) -> float:
        """Return how long after a time the body was down and its joints still, for good, s."""
        looks = self.after(t)
        while looks and self._is_down(looks[-1]):
            looks.pop()
        return looks[-1].t - t if looks else 0.0

    def _is_down(self, look: Seen) -> bool:
        return look.height < self._model.heights.sit + _DOWN and look.speed < _STILL
