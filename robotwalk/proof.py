"""Has a foot prove ground of which there is reason to doubt: off a corner it would slip once it bears the body.

What a foot comes down on has to bear a part of the weight, and to hold it from below: a shin that leans on an edge
pushes the foot aside. On a brink a foot may bear that for a while and creep: there it has to stay where it rests.
"""

import math
from typing import NamedTuple

from robotwalk.types import Vec3

_SHARE = 0.2  # of the weight
_ASIDE = 3e-3  # m that a foot may be beside where it is sent, while nothing is below it


class Doubt(NamedTuple):
    """What a foot asks of the ground that it comes down on."""

    steepness: float  # of what holds it, as seen from where it is sent
    stops_at: float  # m above where it is sent: whatever it bears, it goes no deeper
    slack: float  # m that it may move and is still at rest
    rests_for: float  # s
    reach: float  # m below where ground was expected: deeper down there is none to stand on

    def bears(self, share: float, told: Vec3, felt: Vec3) -> bool:
        """Tell whether a foot is held that is felt to be at `felt`, not where it is told, and bears so much."""
        above = felt.z - told.z
        aside = math.hypot(felt.x - told.x, felt.y - told.y)
        return (share > _SHARE or above > self.stops_at) and above + _ASIDE > self.steepness * aside


# Beyond where all other feet stand.
NEW_GROUND = Doubt(steepness=1.0, stops_at=16e-3, slack=0.0, rests_for=0.0, reach=math.inf)
# Where another foot found none.
BRINK = Doubt(steepness=2.0, stops_at=8e-3, slack=2.5e-3, rests_for=0.1, reach=12e-3)


class Rest:
    """Where a foot rests.

    Attributes:
        place: in odom, m; None before it was felt.
    """

    def __init__(self) -> None:
        self.place: Vec3 | None = None
        self._lasts = 0.0

    def step(self, felt: Vec3, slack: float, dt: float) -> float:
        """Take in where the foot is felt to be, and how far it may move, m; return for how long it has rested, s."""
        if self.place is None or math.dist(felt, self.place) > slack:
            self.place, self._lasts = felt, 0.0
        else:
            self._lasts += dt
        return self._lasts
