"""Random sequences of commands that a driver may give: each robot and seed has its own, always the same."""

import math
from collections.abc import Sequence
from random import Random
from typing import NamedTuple

from robotwalk import assembly
from robotwalk.controller import twist_of
from robotwalk.estimator import Estimate
from robotwalk.model import RobotModel
from robotwalk.settings import MotionLimits
from robotwalk.types import LEVEL, STILL, Command, Pose, Twist

SECONDS = 20.0
_SHORTEST, _LONGEST = 0.3, 5.0  # s that a command lasts
_BEYOND = 1.5  # times what the robot can do: commands are scaled
_SHIFT, _RISE, _LEAN, _TWIST = 0.03, 0.02, math.radians(10), math.radians(15)  # of a posture, largest
_PERIODS = 0.3, 4.0  # s


class Episode(NamedTuple):
    """A command, and for how long it lasts."""

    seconds: float
    command: Command


def sequence(blueprint: assembly.Blueprint, seed: int) -> list[Episode]:
    """Return the episodes of a seed, 20 s in all."""
    model = blueprint.model
    rng = Random(f"{model.name} {seed}")
    gaits = [name for name in blueprint.gaits if name not in blueprint.refused]
    command = Command(_twist(rng, model.motion), gait=rng.choice(gaits))
    episodes, left = [], SECONDS
    while left > 0.0:
        seconds = min(rng.uniform(_SHORTEST, _LONGEST), left)
        episodes.append(Episode(seconds, command))
        left -= seconds
        for _ in range(rng.choice((1, 1, 2, 3))):
            command = _changed(command, model, gaits, rng)
    return episodes


def _changed(command: Command, model: RobotModel, gaits: Sequence[str], rng: Random) -> Command:
    """Return a command with something else in it."""
    vx, vy, wz = command.twist
    kind = rng.choice((
        "twist", "twist", "reverse", "stop", "turn", "heading", "height", "gait", "gait", "period", "posture"))
    if kind == "twist":
        return command._replace(twist=_twist(rng, model.motion), heading=None)
    if kind == "reverse":
        return command._replace(twist=Twist(-vx, -vy, -wz))
    if kind == "stop":
        return command._replace(twist=STILL, heading=None)
    if kind == "turn":  # on the spot
        return command._replace(twist=Twist(0.0, 0.0, _signed(rng, _BEYOND * model.motion.turn)), heading=None)
    if kind == "heading":
        return command._replace(heading=_signed(rng, math.pi))
    if kind == "height":
        return command._replace(height=rng.uniform(model.heights.lowest, model.heights.highest))
    if kind == "gait":
        return command._replace(gait=rng.choice(gaits))
    if kind == "period":
        return command._replace(period=rng.choice((None, rng.uniform(*_PERIODS))))
    return command._replace(posture=rng.choice((LEVEL, Pose(
        _signed(rng, _SHIFT), _signed(rng, _SHIFT), _signed(rng, _RISE),
        _signed(rng, _LEAN), _signed(rng, _LEAN), _signed(rng, _TWIST)))))


def _twist(rng: Random, limits: MotionLimits) -> Twist:
    """Return a twist in any direction, some of them straight ahead, some without a turn."""
    speed = rng.uniform(0.0, _BEYOND * limits.speed)
    direction = rng.choice((0.0, math.pi, _signed(rng, math.pi), _signed(rng, math.pi)))
    turn = rng.choice((0.0, _signed(rng, _BEYOND * limits.turn)))
    return twist_of(speed, direction, turn)


def _signed(rng: Random, largest: float) -> float:
    return rng.uniform(-largest, largest)


class Driver:
    """Gives the commands of a sequence, one after the other."""

    def __init__(self, episodes: Sequence[Episode]) -> None:
        self.done = False
        self._episodes = list(episodes)
        self._left = episodes[0].seconds

    def step(self, estimate: Estimate, dt: float) -> Command:
        """Return what to do in this tick."""
        while self._left <= 0.0 and len(self._episodes) > 1:
            del self._episodes[0]
            self._left += self._episodes[0].seconds
        self._left -= dt
        return self._episodes[0].command
