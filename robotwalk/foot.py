"""One foot: where it stands and, in the air, its way."""

import math

from robotwalk.gait import Sector
from robotwalk.model import Leg
from robotwalk.plumb import Turn
from robotwalk.proof import Doubt
from robotwalk.search import Search
from robotwalk.senses import Sense
from robotwalk.swing import Swing
from robotwalk.swing_paths import SwingPath
from robotwalk.types import Pose, Vec3

_AT_REST = 1.5e-3  # m; a foot this near its rest position need not step
_NEAR_REST = 10e-3  # m, where feet stand as they find the ground
_DRAWN = 0.6  # m/s, the fastest that it is drawn to where it was felt to be; its servos would not follow a jump
_SETTLING = 0.05  # s in which a foot that was told to be elsewhere comes to rest where it stands
_NOT_OFF = Vec3(0.0, 0.0, 0.0)


class Foot:
    """One foot's place in odom.

    Attributes:
        leg: on which it is.
        place: of its centre, m, as it is told to be.
        target: where it stands or is being carried to.
        stood: where it stood before the swing under way, or stands.
        sense: what it feels; None while that is not known or not asked for.
        swing, sector, share, path, lift: the swing under way, whose it is, the turns of the needle that it takes, m.
        search: under way after a swing that found no ground.
        spent: the sector already used in this turn of the needle.
        free: whether it has left the ground in this swing.
        struck_for: for how long something has held it back, s.
        bumps: how often it was struck on its way in it.
        overdue: whether its swing takes longer than its sector.
        touched_for: for how long it has felt something while it searches, s.
        felt_at: how high it was when it was last felt to be struck in a swing, m.
        found: whether it stands where it found ground, not where it was sent.
        recalled: whether it is to step back to rest, wherever it was told to stand.
        landing_for: for how long it may still be on its last way down after its swing, as it lags behind, s.
        fell: whether nothing stopped it there.
        doubt: of the ground to which it is carried, if it has to prove itself.
        hindering: whether waiting for its turn would over-stretch it, and so holds the body back.
        borne_for: for how long it has been felt to stand since it was set down, s.
        lost_for: for how long it has stood without the load that it should bear, s.
        off: what is left of the way to where a swing or a search has begun anew, m.
    """

    def __init__(self, leg: Leg) -> None:
        self.leg = leg
        self.place = self.target = self.stood = Vec3(0.0, 0.0, 0.0)
        self.sense: Sense | None = None
        self.swing: Swing | None = None
        self.sector: Sector | None = None
        self.share = 0.0
        self.lift = leg.lift
        self.path = leg.swing_path
        self.search: Search | None = None
        self.spent: Sector | None = None
        self.free = False
        self.struck_for = 0.0
        self.bumps = 0
        self.overdue = False
        self.lost_for = self.touched_for = self.borne_for = self.landing_for = 0.0
        self.felt_at = 0.0
        self.found = self.hindering = self.recalled = self.fell = False
        self.doubt: Doubt | None = None
        self.off = _NOT_OFF

    @property
    def way(self) -> float:
        """The way of its step, rad in odom."""
        return math.atan2(self.target.y - self.stood.y, self.target.x - self.stood.x)

    def plant(self, place: Vec3) -> None:
        """Stand at `place`."""
        self.place = self.target = self.stood = place
        self.found = False
        self._land()

    def anchor(self, place: Vec3) -> None:
        """Stand at `place`, where it was felt to be; it comes to rest there."""
        self.found = place is not self.target
        self.target = self.stood = place
        self._land()

    def _land(self) -> None:
        self.swing = self.sector = self.search = None
        self.recalled = False
        self.bumps = 0
        self.overdue = self.fell = False
        self.lost_for = self.touched_for = self.borne_for = self.landing_for = 0.0

    def turn(self, turn: Turn) -> None:
        """Stay where it is below the body while odom is turned; at rest, it may then be beside its rest position."""
        self.found = True
        at_target = self.place is self.target
        self.place, self.stood, self.target = turn.of(self.place), turn.of(self.stood), turn.of(self.target)
        if at_target:
            self.place = self.target
        if self.swing is not None:
            self.swing.turn(turn)
        if self.search is not None:
            self.search.turn(turn)

    def press(self, by: float) -> None:
        """Stand lower by so much, m."""
        self.target = self.stood = self.target._replace(z=self.target.z - by)
        self.place = self.place._replace(z=self.place.z - by)

    def settle(self, dt: float) -> None:
        """Come to rest where it stands."""
        if self.place is not self.target:
            (x, y, z), (tx, ty, tz) = self.place, self.target
            way = math.dist(self.place, self.target)
            share = min(dt / _SETTLING, _DRAWN * dt / way, 1.0) if way > 0.0 else 1.0
            if way < 1e-5:
                self.place = self.target
            else:
                self.place = Vec3(x + share * (tx - x), y + share * (ty - y), z + share * (tz - z))

    def offset(self, course: Pose) -> tuple[float, float]:
        """Return where the foot is from its rest position, in the body's axes, m."""
        place, rest = self.place, self.leg.rest_foot
        dx, dy = place.x - course.x, place.y - course.y
        c, s = math.cos(course.yaw), math.sin(course.yaw)
        return c * dx + s * dy - rest.x, c * dy - s * dx - rest.y

    def displacement(self, course: Pose) -> float:
        """Return how far the foot is from its rest position, m."""
        return math.hypot(*self.offset(course))

    def at_rest(self, course: Pose) -> bool:
        """Tell whether the foot is so near its rest position that it need not step."""
        return not self.recalled and self.displacement(course) <= (_NEAR_REST if self.found else _AT_REST)

    def lift_off(self, sector: Sector, share: float, path: SwingPath | None, lift: float) -> None:
        """Begin a swing, along another path than the leg's own if there is one."""
        self.path = path or self.leg.swing_path
        self.sector = sector
        self.share = share
        self.stood = self.place
        self.bumps = 0
        self.rise(self.place, lift)

    def rise(self, start: Vec3, lift: float) -> None:
        """Begin the swing, or begin it anew from somewhere near its way."""
        self.draw_to(start)
        self.lift = lift
        self.free = False
        self.struck_for = 0.0
        self.swing = Swing(self.path, lift, start)

    def draw_to(self, start: Vec3) -> None:
        """Begin anew at `start`, but come there from where it is told to be."""
        (x, y, z), (sx, sy, sz) = self.place, start
        self.off = _NOT_OFF if self.place is start else Vec3(x - sx, y - sy, z - sz)

    def move(self, place: Vec3, dt: float) -> None:
        """Be at `place`, or as near to it as it has been drawn by now."""
        if self.off is _NOT_OFF:
            self.place = place
            return
        x, y, z = self.off
        way = math.hypot(x, y, z)
        left = max(way - _DRAWN * dt, 0.0)
        self.off = Vec3(x * left / way, y * left / way, z * left / way) if left > 0.0 else _NOT_OFF
        self.place = Vec3(place.x + self.off.x, place.y + self.off.y, place.z + self.off.z)

    def slowest(self, shortest: float) -> float:
        """Return the least time for the swing, s, if an ordinary one takes `shortest`: servos have a speed."""
        return shortest * max(self.lift / self.leg.lift, 1.0)
