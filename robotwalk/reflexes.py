"""What feet do about the ground that they feel (ARTH sections 5.4, 6.2, 7.1).

One that is struck on its way down stands there; one that is held back steps higher; one that finds nothing searches,
and so does one that has lost what it stood on. Each surprise has all feet step higher for a while.
"""

import math
from enum import Enum
from random import Random

from robotwalk.barriers import GivingUp
from robotwalk.foot import Foot
from robotwalk.gait import Sector
from robotwalk.proof import BRINK
from robotwalk.search import Phase, Search
from robotwalk.senses import Sense
from robotwalk.settings import ContactSettings
from robotwalk.swing import Swing
from robotwalk.types import Vec3

_COMING_DOWN = 0.5  # of a swing, from where on a load is a touchdown
_AS_EXPECTED = 8e-3  # m; a foot struck this near the ground that was expected goes on to it
_AS_FELT = 3e-3  # m; ground this near to where it was expected is there
_BUMP_UNTIL = 0.85  # of a swing; later it is the ground
_BUMP = 0.1  # of the weight, that pushes a foot back on its way: it is struck
_STEEP = 0.7  # of a load; pushed back by more than this, a foot would slip off what it struck
_FIRM = 0.2  # of the weight; a leg that comes down in the air may feign half as much
_FIRM_FOR = 0.015  # s
_HARD = 0.5  # of the weight, which no leg feigns: it is struck, though it may go on downwards as the body tips away
_FALLING = 0.08  # m/s downwards, at which a foot stands on nothing, whatever a leg that speeds up may feign
_THROUGH = 1.9e-3  # m below its goal that a foot swings if nothing stops it; as it swings back, it feigns a load
_FOLLOWS = 0.05  # s in which a foot comes to where it was told to be, and is felt to stand there
_BEARS = 0.07  # of the weight, on the average: it stands
_LOST = 0.12  # of the weight, that a foot should bear of which nothing is felt: it has lost its ground
_LOST_FOR = 0.12  # s of that; loads pass from foot to foot in less
_STRUCK_FOR = 0.025  # s; gears with backlash jolt, too, but not for long
_BUMPS = 3  # in one swing, after which the foot stands where it is
_HIGHER = 0.02  # m that each of them adds to the lift
_CALMING = 0.9  # of that stays after each step without a surprise
_BACK = 0.03  # m that a foot draws back when it is struck; more than it lags behind as it sets off again
_LEAST_WAY = 0.01  # m; a shorter step has no way along which a foot could be held back
_DRAWN_BACK = 0.25  # of a swing, in which it rises more than it goes ahead; by then it has drawn back


class _Below(Enum):
    """What a searching foot feels below it."""

    NOTHING = "nothing"
    SOMETHING = "something"  # it keeps still: ground stays, a jolt does not, and a brink gives way
    GROUND = "ground"


class Reflexes:
    """Of one robot's feet.

    Attributes:
        caution: m added to the lift of every foot where the ground has surprised.
    """

    def __init__(self, contact: ContactSettings, weight: float) -> None:
        """React by the settings of a robot that weighs so much, N."""
        self.caution = 0.0
        self._contact = contact
        self._weight = weight
        self._random = Random(0)

    def feel(self, foot: Foot, swing: Swing, sector: Sector, sense: Sense, dt: float) -> None:
        """React to what a swinging foot feels."""
        contact = self._contact
        if swing.progress >= 1.0:
            if contact.reach_down == 0.0 or self._stands(foot, sense):
                foot.anchor(foot.target)
                self.caution *= _CALMING
            else:
                self._search(foot, foot.place)
                if contact.sure_after > 0.0:
                    foot.landing_for = _FOLLOWS
                else:
                    foot.overdue = True
            return
        if not foot.free:  # from what it stood on, or from what it was struck by: it lags behind as it draws back
            drawn_back = foot.bumps == 0 or swing.progress >= _DRAWN_BACK or not self._struck(foot, sense)
            foot.free = drawn_back and not sense.touching
            return
        struck = self._struck(foot, sense) and (swing.progress <= _BUMP_UNTIL or _above(foot, sense) > _AS_EXPECTED)
        foot.struck_for = foot.struck_for + dt if struck else 0.0
        if contact.step_over and foot.struck_for > _STRUCK_FOR:
            self._step_over(foot, sector, sense)
        elif contact.early_touchdown and swing.progress >= _COMING_DOWN and self._lands(foot, sense, dt):
            above = _above(foot, sense)
            if above > _AS_EXPECTED:
                self._be_surprised(above)
                foot.anchor(sense.place)

    def keep_ground(self, foot: Foot, sector: Sector, load: float, dt: float) -> None:
        """Have a standing foot, that should bear a load, N, feel for the ground again that it has lost."""
        sense = foot.sense
        if sense is not None and sense.touching:
            foot.borne_for += dt
        if sense is None or not self._contact.slip or sense.touching or load < _LOST * self._weight:
            foot.lost_for = 0.0
            return
        foot.lost_for += dt
        if foot.lost_for >= _LOST_FOR:
            foot.sector, foot.overdue = sector, True
            self._search(foot, foot.place)

    def go_on_searching(self, foot: Foot, search: Search, dt: float) -> None:
        """Search on, until the foot feels ground or is back where it stood."""
        sense = foot.sense
        if foot.landing_for > 0.0 and sense is not None:
            self._land(foot, search, sense, dt)
            return
        if sense is not None:
            below = self._below(foot, search, sense, dt)
            if below is _Below.GROUND:
                self._stand(foot, search, sense)
            if below is not _Below.NOTHING:
                return
        foot.move(search.step(dt), dt)
        if search.done:
            foot.plant(foot.stood)
        elif foot.swing is None and search.phase is not Phase.DOWN:
            # It stood here, and here is nothing any more: it steps anew.
            assert foot.sector is not None
            foot.search, foot.share = None, foot.sector.length
            foot.rise(foot.place, foot.leg.lift + self.caution)

    def _below(self, foot: Foot, search: Search, sense: Sense, dt: float) -> _Below:
        """Return what a searching foot feels below it."""
        touching = search.feels and sense.sure
        foot.touched_for = foot.touched_for + dt if touching else 0.0
        lasting = foot.touched_for >= search.sure_after
        if search.averages:
            bears = search.average(sense.push.z, dt) > _BEARS * self._weight
            return _Below.GROUND if bears or (touching and lasting) else _Below.NOTHING
        doubt = foot.doubt
        if doubt is not None and foot.swing is not None:
            felt, share = sense.place, search.average(sense.push.z, dt) / self._weight
            lasting = search.rest.step(felt, doubt.slack, dt) >= doubt.rests_for
            touching = search.feels and sense.touching and doubt.bears(share, foot.place, felt)
        if not touching:
            return _Below.NOTHING
        return _Below.GROUND if lasting else _Below.SOMETHING

    def _stand(self, foot: Foot, search: Search, sense: Sense) -> None:
        """Have a searching foot stand where it found ground."""
        felt = search.rest.place or sense.place
        self._be_surprised(abs(foot.target.z - felt.z) - _AS_FELT)
        # A foot that feels straight down is where it is told to be; one that swings lags behind.
        if foot.swing is None:  # it stood, and stands again a little lower
            foot.anchor(search.place)
            return
        (x, y, _), (_, _, z) = search.place, foot.target
        off = felt.z - z
        foot.anchor(Vec3(x, y, z if abs(off) <= _AS_FELT else z + off))

    def _step_over(self, foot: Foot, sector: Sector, sense: Sense) -> None:
        """Draw a foot back from what it struck and carry it on higher; at last stand in front of it."""
        foot.bumps += 1
        foot.overdue = True
        self._be_surprised(self._contact.caution)
        if foot.bumps > _BUMPS:
            foot.draw_to(sense.place)
            self._search(foot, sense.place)
            return
        dx, dy = foot.target.x - foot.stood.x, foot.target.y - foot.stood.y
        back = _BACK / (math.hypot(dx, dy) or 1.0)
        foot.share = sector.length
        x, y, z = sense.place
        foot.rise(Vec3(x - back * dx, y - back * dy, z), foot.leg.lift + foot.bumps * _HIGHER)

    def _stands(self, foot: Foot, sense: Sense) -> bool:
        """Tell whether a foot at the end of its swing has met the ground that was expected there."""
        if self._contact.sure_after == 0.0:
            return sense.touching and foot.doubt is not BRINK
        foot.fell = foot.fell or sense.place.z - foot.place.z < -_THROUGH
        # What it meets may throw it off again, or a body that leans away: then one measurement has told of it.
        met = sense.touching or (foot.landing_for > 0.0 and sense.push.z > _FIRM * self._weight)
        return met and _above(foot, sense) <= _AS_FELT and not foot.fell

    def _land(self, foot: Foot, search: Search, sense: Sense, dt: float) -> None:
        """Have a foot that lags behind its goals come down; it looks for ground only if that takes too long."""
        if self._stands(foot, sense):
            foot.anchor(foot.target)
            self.caution *= _CALMING
            return
        foot.landing_for -= dt
        foot.overdue = foot.landing_for <= 0.0
        foot.move(search.step(dt), dt)

    def _lands(self, foot: Foot, sense: Sense, dt: float) -> bool:
        """Tell whether a foot on its way down is struck by ground; one that has to be sure, by a load that lasts."""
        sure_after = self._contact.sure_after
        if sure_after == 0.0:
            return sense.sure
        if not sense.sure:
            foot.touched_for = 0.0
            return False
        if sense.push.z > _HARD * self._weight:
            return True
        z = sense.place.z
        fell, foot.felt_at = foot.felt_at - z, z
        foot.touched_for = foot.touched_for + dt if fell < _FALLING * dt or foot.touched_for == 0.0 else dt
        if foot.touched_for <= _FIRM_FOR:
            return False
        return foot.touched_for >= sure_after or sense.push.z > _FIRM * self._weight

    def _struck(self, foot: Foot, sense: Sense) -> bool:
        """Tell whether something holds a foot back on its way."""
        least = _BUMP * self._weight
        if sense.strength <= least:
            return False
        dx, dy = foot.target.x - foot.stood.x, foot.target.y - foot.stood.y
        way = math.hypot(dx, dy)
        if way <= _LEAST_WAY:
            return False
        x, y, z = sense.push
        return -(x * dx + y * dy) / way > max(least, _STEEP * z)

    def _be_surprised(self, by: float) -> None:
        self.caution = max(self.caution, min(by, self._contact.caution))

    def _search(self, foot: Foot, place: Vec3) -> None:
        """Begin a search at a place where there should have been ground."""
        foot.search = Search(
            self._contact, foot.path, foot.leg.lift, foot.stood, place, self._random, foot.doubt,
            held_back=foot.bumps > _BUMPS)


def _above(foot: Foot, sense: Sense) -> float:
    """Return how far above its target a foot is, m, as its joints tell."""
    return sense.place.z - foot.target.z


def giving_up(foot: Foot) -> GivingUp | None:
    """Return what keeps a searching foot from going its way, if it has given up."""
    if foot.bumps > _BUMPS or (foot.search is not None and foot.search.gave_up and foot.bumps == 0):
        return GivingUp("obstacle" if foot.bumps else "edge", foot.way)
    return None
