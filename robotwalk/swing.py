"""How a foot is carried over: along its path, and without a jump when the path, its end or its time change.

A quintic takes a motion to rest in a given time with the least jerk (Flash and Hogan 1985). Solved anew in each tick,
it takes up whatever a change of plan would make the foot jump by, and lets it die out until touchdown.
"""

from robotwalk.plumb import Turn
from robotwalk.swing_paths import Motion, SwingPath
from robotwalk.types import UP, Vec3

_STILL = Motion(0.0, 0.0, 0.0)
_NO_REST = (_STILL, _STILL, _STILL)
_SAME = 1e-9  # m


def least_jerk(motion: Motion, target: float, remaining: float, dt: float) -> Motion:
    """Go on for `dt` s on the quintic that comes to rest at `target` after `remaining` s."""
    if remaining <= dt:
        return Motion(target, 0.0, 0.0)
    p, v, a = motion
    r, inverse = remaining, 1.0 / remaining
    way = target - p - (v + 0.5 * a * r) * r
    dv, da = (v + a * r) * r, a * r * r
    cubed = inverse * inverse * inverse
    c3 = (10.0 * way + 4.0 * dv - 0.5 * da) * cubed
    c4 = (-15.0 * way - 7.0 * dv + da) * cubed * inverse
    c5 = (6.0 * way + 3.0 * dv - 0.5 * da) * cubed * inverse * inverse
    return Motion(
        p + (v + (0.5 * a + (c3 + (c4 + c5 * dt) * dt) * dt) * dt) * dt,
        v + (a + (3.0 * c3 + (4.0 * c4 + 5.0 * c5 * dt) * dt) * dt) * dt,
        a + (6.0 * c3 + (12.0 * c4 + 20.0 * c5 * dt) * dt) * dt,
    )


def way_made(progress: float) -> float:
    """Return the share of the way behind a foot after a share of its swing's time, both 0 to 1."""
    u = min(max(progress, 0.0), 1.0)
    return u * u * u * (10.0 + u * (-15.0 + 6.0 * u))


class Swing:
    """One foot's way from lift-off to touchdown and, if its path retracts and nothing was struck, back.

    The foot is at `start + way (target - start) + lift height up + rest`. What a new target, path, lift or duration
    would make it jump by, in position, velocity or acceleration, goes into the rest, which has died out at the end of
    the half of the path that the foot is on.

    Attributes:
        start, target: in one frame that stands still, m.
        progress: 0 at lift-off, 1 at the nominal touchdown, 2 back at the start.
        position: of the foot, m.
    """

    __slots__ = ("_lift", "_path", "_rest", "_seconds", "_up", "position", "progress", "start", "target")

    def __init__(self, path: SwingPath, lift: float, start: Vec3) -> None:
        """Lift off at `start`; the foot comes down there unless it is sent elsewhere."""
        self.start = self.target = self.position = start
        self.progress = 0.0
        self._path = path
        self._lift = lift  # m
        self._rest = _NO_REST
        self._seconds = 1.0  # of each half
        self._up = UP

    @property
    def velocity(self) -> Vec3:
        """The foot's, m/s; what a moving up axis adds is left out."""
        along, height = self._path.at(self.progress)
        way, rise = along.velocity / self._seconds, self._lift * height.velocity / self._seconds
        (sx, sy, sz), (tx, ty, tz), (ux, uy, uz) = self.start, self.target, self._up
        x, y, z = self._rest
        return Vec3(
            (tx - sx) * way + ux * rise + x.velocity, (ty - sy) * way + uy * rise + y.velocity,
            (tz - sz) * way + uz * rise + z.velocity)

    def retarget(self, target: Vec3) -> None:
        """Come down elsewhere; less than a nanometre is no change."""
        (x, y, z), (ax, ay, az), (bx, by, bz) = self._rest, self.target, target
        if abs(ax - bx) + abs(ay - by) + abs(az - bz) < _SAME:
            return
        if self.progress == 0.0:
            self.target = target
            return
        way, _ = self._path.at(self.progress)
        self._rest = self._kept(x, way, ax - bx), self._kept(y, way, ay - by), self._kept(z, way, az - bz)
        self.target = target

    def turn(self, turn: Turn) -> None:
        """Go on on the same way in the body's frame while odom is turned; so little that speeds need not be."""
        self.start, self.target, self.position = turn.of(self.start), turn.of(self.target), turn.of(self.position)

    def replace(self, path: SwingPath, lift: float) -> None:
        """Go on along another path, or with another lift, in m."""
        (way, height), (way_before, height_before) = path.at(self.progress), self._path.at(self.progress)
        dway = Motion(*(a - b for a, b in zip(way_before, way, strict=True)))
        dheight = Motion(*(self._lift * a - lift * b for a, b in zip(height_before, height, strict=True)))
        self._add_to_rest(dway, dheight)
        self._path, self._lift = path, lift

    def step(self, dt: float, seconds: float, up: Vec3 = UP) -> Vec3:
        """Go on by `dt` s and return where the foot is.

        Args:
            dt: s.
            seconds: that each half of the path takes, counted from its begin. It may change in mid-swing.
            up: the body's up axis, in the frame of the points.
        """
        if seconds != self._seconds:
            if self.progress not in (0.0, 1.0):
                self._take(seconds)
            self._seconds = seconds
        half = 1.0 if self.progress < 1.0 else 2.0
        remaining = (half - self.progress) * seconds
        # The end is met exactly, and a half begins no sooner than the tick after the other has ended.
        self.progress = self.progress + dt / seconds if remaining > dt else half
        if self._rest is not _NO_REST:
            rx, ry, rz = self._rest
            self._rest = _NO_REST if remaining <= dt else (
                least_jerk(rx, 0.0, remaining, dt), least_jerk(ry, 0.0, remaining, dt),
                least_jerk(rz, 0.0, remaining, dt))
        way, height = self._path.place(self.progress)
        rise = self._lift * height
        self._up = up
        (sx, sy, sz), (tx, ty, tz), (ux, uy, uz) = self.start, self.target, up
        x, y, z = sx + way * (tx - sx) + rise * ux, sy + way * (ty - sy) + rise * uy, sz + way * (tz - sz) + rise * uz
        if self._rest is not _NO_REST:
            rx, ry, rz = self._rest
            x, y, z = x + rx.position, y + ry.position, z + rz.position
        self.position = Vec3(x, y, z)
        return self.position

    def _take(self, seconds: float) -> None:
        """Put what another time of a half changes of the speed into the rest; the way made stays."""
        ratio = self._seconds / seconds
        first, second = 1.0 - ratio, 1.0 - ratio * ratio
        way, height = self._path.at(self.progress)
        dway = Motion(0.0, first * way.velocity, second * way.acceleration)
        dheight = Motion(0.0, self._lift * first * height.velocity, self._lift * second * height.acceleration)
        self._add_to_rest(dway, dheight)

    def _add_to_rest(self, dway: Motion, dheight: Motion) -> None:
        (sx, sy, sz), (tx, ty, tz), (ux, uy, uz) = self.start, self.target, self._up
        x, y, z = self._rest
        self._rest = (
            self._kept(self._kept(x, dway, tx - sx), dheight, ux),
            self._kept(self._kept(y, dway, ty - sy), dheight, uy),
            self._kept(self._kept(z, dway, tz - sz), dheight, uz))

    def _kept(self, rest: Motion, by_progress: Motion, factor: float) -> Motion:
        """Add a multiple of a motion by progress to one by time."""
        if factor == 0.0:
            return rest
        inverse = factor / self._seconds
        return Motion(
            rest.position + factor * by_progress.position, rest.velocity + inverse * by_progress.velocity,
            rest.acceleration + inverse / self._seconds * by_progress.acceleration)
