"""What a foot does that found no ground where it was to touch down (ARTH sections 5.4 and 6.2).

It feels downwards; then around, by seeded probes in circles that grow (Duerr 2001: stereotypic searching movements),
or, if it is not to look around or was held back, nearer to where it stood; at last it goes back there, where there
was ground. Where another foot has found none before, it goes home at once: what it would come upon may be the brink.
"""

import math
from enum import Enum
from random import Random

from robotwalk.plumb import Turn
from robotwalk.proof import BRINK, Doubt, Rest
from robotwalk.settings import ContactSettings
from robotwalk.swing import Swing
from robotwalk.swing_paths import SwingPath
from robotwalk.types import Vec3

_FASTEST = 0.10  # m/s downwards; how deep a foot presses into what it finds in the time that it takes to notice
_CAREFUL = 0.06  # m/s downwards, of a foot that has to be sure
_GENTLE = 1.5  # m/s^2
_JOLT = 0.08  # s
_CIRCLES = (0.015, 0.030)  # m
_PROBES = 2  # in each circle
_AROUND = [radius for radius in _CIRCLES for _ in range(_PROBES)]
_PROBING_LIFT = 0.015  # m
_PROBING_DEPTH = 0.012  # m below where ground was expected: a shin deep down would lean on the edge that it came over
_DEEP = 0.5  # of its reach, deeper than which the foot goes down no small step
_PROBING = 0.3  # s for a probe
_SURE_AFTER = 0.15  # s
_STEADY = 0.04  # s over which a load is averaged at least: gears jolt
_STEPPING = 0.4  # s for a step nearer, or home
_NEARER = 0.5  # of the step


class Phase(Enum):
    """What a searching foot does."""

    DOWN = "down"
    AROUND = "around"
    NEARER = "nearer"
    HOME = "home"


class Search:
    """One foot in search of ground.

    Attributes:
        place: of its centre in odom, m.
        phase: what it does.
        done: whether it is back where it stood.
        rest: where it rests, if it has to prove what it comes down on.
    """

    def __init__(self, settings: ContactSettings, path: SwingPath, lift: float, stood: Vec3, target: Vec3,
                 random: Random, doubt: Doubt | None, *, held_back: bool) -> None:
        """Begin at `target`, where there should have been ground; the foot `stood` somewhere before.

        On a brink it feels less deep, and goes home. One that was held back on its way does not look around.
        """
        self.place = target
        self.phase = Phase.DOWN
        self.done = False
        self.rest = Rest()
        self._settings = settings
        self._reach = settings.reach_down if doubt is None else min(settings.reach_down, doubt.reach)
        self._brink = doubt is BRINK
        self._path, self._lift = path, lift
        self._stood, self._target = stood, target
        self._random = random
        self._speed = 0.0
        self._expected = target  # the place above the ground from where it feels down
        self._swing: Swing | None = None
        around = settings.search and doubt is not BRINK and not held_back
        self._probes = list(_AROUND) if around else []  # still to come: their radii, m
        self._steady_for = _JOLT  # s since it last set off anew
        self._load = 0.0  # N, averaged

    @property
    def feels(self) -> bool:
        """Whether what the foot feels is to be trusted: as it sets off anew, gears jolt."""
        return self._steady_for >= _JOLT

    @property
    def sure_after(self) -> float:
        """For how long the foot must feel something to stand on it, s."""
        return self._settings.sure_after if self.phase is Phase.DOWN else _SURE_AFTER

    @property
    def averages(self) -> bool:
        """Whether it feels down, slowly, for a load that lasts, however little of it there is at a time."""
        return self.phase is Phase.DOWN and self._settings.sure_after > 0.0

    def average(self, load: float, dt: float) -> float:
        """Take in what is felt, N; return its average over the time that a foot has to be sure."""
        self._load += (load - self._load) * min(dt / max(self._settings.sure_after, _STEADY), 1.0)
        return self._load

    @property
    def deep(self) -> bool:
        """Whether there is no ground where it was expected, nor a small step below it; a slow foot does not tell."""
        if self.averages:
            return False
        return self.phase is not Phase.DOWN or self._expected.z - self.place.z > _DEEP * self._settings.reach_down

    @property
    def _depth(self) -> float:
        return self._reach if self.phase is Phase.DOWN else min(self._reach, _PROBING_DEPTH)

    @property
    def gave_up(self) -> bool:
        """Whether there was no ground, below or around."""
        return self.phase in (Phase.NEARER, Phase.HOME)

    def turn(self, turn: Turn) -> None:
        """Go on where it is in the body's frame while odom is turned."""
        self.place, self._expected = turn.of(self.place), turn.of(self._expected)
        self._stood, self._target = turn.of(self._stood), turn.of(self._target)
        if self._swing is not None:
            self._swing.turn(turn)

    def step(self, dt: float) -> Vec3:
        """Go on by `dt` s and return where the foot is; it ends when the foot feels ground, or is `done`."""
        self._steady_for += dt
        if self._swing is None:
            left = max(self._depth - (self._expected.z - self.place.z), 0.0)
            fastest = _CAREFUL if self.averages else _FASTEST
            self._speed = min(self._speed + _GENTLE * dt, fastest, math.sqrt(2.0 * _GENTLE * left) + _GENTLE * dt)
            self.place = self.place._replace(z=self.place.z - self._speed * dt)
            if self._expected.z - self.place.z >= self._depth:
                self._give_up_below()
            return self.place
        self.place = self._swing.step(dt, _PROBING if self.phase is Phase.AROUND else _STEPPING)
        if self._swing.progress >= 1.0:
            self._swing = None
            self._steady_for = self._speed = self._load = 0.0
            self.done = self.phase is Phase.HOME
        return self.place

    def _give_up_below(self) -> None:
        """Go on elsewhere: around, or nearer, then home."""
        self._steady_for = 0.0
        if self._probes:
            self.phase = Phase.AROUND
            self._probe(self._probes.pop(0))
        elif self._brink or self.phase is not Phase.DOWN:
            self.phase = Phase.HOME
            self._go(self._stood)
        else:
            self._step_nearer()

    def _probe(self, radius: float) -> None:
        """Look so far around, m, from where ground was expected."""
        x, y, z = self._expected
        angle = self._random.uniform(-math.pi, math.pi)
        self._swing = Swing(self._path, _PROBING_LIFT + z - self.place.z, self.place)
        self._swing.retarget(Vec3(x + radius * math.cos(angle), y + radius * math.sin(angle), z))

    def _step_nearer(self) -> None:
        self.phase = Phase.NEARER
        (ax, ay, az), (bx, by, bz) = self._stood, self._target
        self._expected = Vec3(ax + _NEARER * (bx - ax), ay + _NEARER * (by - ay), az + _NEARER * (bz - az))
        self._go(self._expected)

    def _go(self, target: Vec3) -> None:
        self._swing = Swing(self._path, self._lift + max(target.z - self.place.z, 0.0), self.place)
        self._swing.retarget(target)
