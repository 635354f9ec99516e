"""Has standing feet share the robot's weight: of four feet on uneven ground one may hang in the air like a stool's leg.

Loads that balance the robot's weight differ from those due only by loads that balance each other. What is left of the
differences less their plane goes into the feet's heights, so the body neither rises nor tilts; three feet have
nothing to share; nor have feet whose loads differ no more than they do on flat ground, for friction hides a part of
them, and the body sways. A foot lifts off once all others bear: else the body would tip over to the one that does not.
"""

from collections.abc import Sequence

from robotwalk.contact import plane_of
from robotwalk.foot import Foot
from robotwalk.senses import Sense
from robotwalk.types import Vec3

_USUAL = 0.05  # of the weight, that a foot bears too little or too much on flat ground
_GIVE = 3e-3  # m/s per N beyond that
_FASTEST = 0.04  # m/s
_SMOOTHING = 0.1  # s; a jerk of the foot is itself felt as a load
_FEWEST = 4  # feet, of which one may hang
_LITTLE = 0.15  # of the weight; a foot that should bear less need not be felt, once it was since it was set down
_PATIENCE = 0.5  # s that a lift-off waits for the others in all
_MADE_UP = 0.03  # s of that, for which the swing makes up: the needle goes on


class LoadSharing:
    """Of one robot's feet."""

    def __init__(self, weight: float, feet: int) -> None:
        """Share a weight, N, among so many feet."""
        self._lacks = [0.0] * feet  # N that each bears too little, averaged
        self._usual = _USUAL * weight
        self._little = _LITTLE * weight
        self.waiting = False  # a lift-off did, in this tick, and the needle has to
        self._waited_for = 0.0  # s

    def step(self, feet: Sequence[Foot], senses: Sequence[Sense | None], loads: Sequence[float], dt: float) -> None:
        """Press those down that bear less than their `loads` (N), and draw up those that bear more, by a tick."""
        self.waiting = False
        standing: list[int] = []
        lacking: list[Vec3] = []
        for index, (foot, sense, load) in enumerate(zip(feet, senses, loads, strict=True)):
            if foot.sector is None and sense is not None:
                standing.append(index)
                lacking.append(Vec3(foot.place.x, foot.place.y, load - sense.push.z))
            else:
                self._lacks[index] = 0.0
        if len(standing) < _FEWEST:
            # At once: three of the ways that left the body level would tilt it.
            self._lacks = [0.0] * len(feet)
            return
        plane = plane_of(lacking)
        for index, lack in zip(standing, lacking, strict=True):
            self._lacks[index] += (lack.z - plane.at(lack) - self._lacks[index]) * min(dt / _SMOOTHING, 1.0)
        worst = max(map(abs, self._lacks))
        if worst > self._usual:
            give = min(_GIVE * (worst - self._usual), _FASTEST) / worst
            for index in standing:
                feet[index].press(give * self._lacks[index] * dt)

    def lets_go(
        self, foot: Foot, feet: Sequence[Foot], senses: Sequence[Sense | None], loads: Sequence[float], dt: float
    ) -> bool:
        """Tell whether a foot whose turn it is may lift off."""
        bear = all(
            other is foot or other.sector is not None or sense is None or sense.touching
            or (load < self._little and other.borne_for > 0.0)
            for other, sense, load in zip(feet, senses, loads, strict=True))
        if bear or self._waited_for >= _PATIENCE:
            self._waited_for = 0.0
            return True
        self._waited_for += dt
        self.waiting = self._waited_for > _MADE_UP
        return False
