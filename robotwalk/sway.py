"""Shifts the body over the feet that stand, where the gait's file asks for it: the crawl of four legs needs that.

It looks ahead on the gait's circles: which feet will stand together, one stand after the other, and where. It
chooses the shift, nearest to the present one, that keeps the centre of mass a margin inside all those polygons,
for as many stands ahead as one shift can serve. The body goes there with least jerk, and no faster than the
standing feet can bear; lift-offs wait until it has arrived. The centre of mass is taken to be fixed in the body:
that of the standing robot.
"""

import math
from collections.abc import Iterable, Sequence

from robotwalk.body import advanced, placed, seen_from
from robotwalk.gait import GaitClock
from robotwalk.kinematics import resting_angles
from robotwalk.model import RobotModel
from robotwalk.stands import Stand, coming_stands
from robotwalk.stepping import Footfalls
from robotwalk.support import HalfPlane, centre_of_mass, nearest_inside, support_polygon
from robotwalk.swing import least_jerk
from robotwalk.swing_paths import Motion
from robotwalk.types import Pose, Twist, Vec3

_GRAVITY = 9.81  # m/s^2
_NEW_SHIFT = 3e-3  # m; a smaller change of aim does not start a shift anew
_FOLLOWING = 0.08  # s in which such a change is followed
_SHARE = 0.6  # of the room between the feet that a shift may use; joints give, and the body rocks
_GENTLEST = 0.3  # m/s^2
_RETURN = 1.0  # m/s^2, back to the course
_LEAST_JERK_PEAK = 10.0 / math.sqrt(3.0)  # largest acceleration x time^2 / way of a least-jerk motion from rest to rest
_AT_REST = 5e-4  # m
_ROUNDING = 1e-6  # s
_STILL = Motion(0.0, 0.0, 0.0)


class Sway:
    """The shift of one robot's body, along its own x and y."""

    def __init__(self, model: RobotModel) -> None:
        self._legs = model.legs
        self._centre = centre_of_mass(model, resting_angles(model, model.heights.stand))
        self._x = self._y = _STILL
        self._aim = (0.0, 0.0)
        self._begun_for = self._begun_at = (0.0, 0.0)  # the last shift's aim and start
        self._elapsed = 0.0  # s since then
        self._left = 0.0  # s until the aim shall be reached
        self._situation: object = None  # for which the aim was chosen
        self._waiting = False
        self._serves = True  # the aim serves the next lift-off, whatever is in the air now

    @property
    def at_rest(self) -> bool:
        """Tell whether the body is on its course again."""
        return self._aim == (0.0, 0.0) and math.hypot(self._x.position, self._y.position) <= _AT_REST

    def release(self, until_lift_off: float) -> bool:
        """Aim for no shift at all; tell whether lift-offs, the next in `until_lift_off` s, have to wait for it."""
        self._situation = None
        self._head_for((0.0, 0.0), 0.0)
        self._take_time(_RETURN)
        return self._left > until_lift_off + _ROUNDING

    def plan(
        self, clock: GaitClock, footfalls: Footfalls, course: Pose, pose: Pose, twist: Twist, until_lift_off: float
    ) -> bool:
        """Aim for the feet that will stand; tell whether lift-offs have to wait for the shift.

        Args:
            clock: the needle of a gait that asks for balance.
            footfalls: the feet.
            course: of the body, in odom.
            pose: of the body without the shift, in odom, but its height is that over the feet.
            twist: in force.
            until_lift_off: s to the next one.
        """
        balance = clock.gait.balance
        assert balance is not None
        posture = (pose.x - course.x, pose.y - course.y, pose.yaw - course.yaw)
        # In steady motion a plan holds; while the needle waits, the body moves on.
        planted, support = footfalls.planted, clock.gait.support_at(clock.phase)
        situation = (clock.gait, support, planted, twist, posture)
        if self._waiting or situation != self._situation:
            self._situation = situation
            level = pose._replace(roll=0.0, pitch=0.0)
            stands = coming_stands(self._legs, clock, footfalls, course, twist)
            aim, served = self._best_aim(stands, level, twist, balance.margin)
            self._serves = served > 1 or all(planted) or planted == clock.gait.supports[support].standing
            self._head_for(aim, until_lift_off)
            self._take_time(min(balance.acceleration, self._firmest(footfalls, advanced(level, twist, until_lift_off))))
        # After a change of gait a foot may be due on the other side before the one in the air has landed.
        self._waiting = self._left > until_lift_off + _ROUNDING or (until_lift_off == 0.0 and not self._serves)
        return self._waiting

    def step(self, pose: Pose, dt: float) -> Pose:
        """Advance by `dt` s; return the body's pose in odom, shifted."""
        if self._aim == (0.0, 0.0) and self._x == self._y == _STILL:
            return pose
        remaining = max(self._left, _FOLLOWING)
        self._x = least_jerk(self._x, self._aim[0], remaining, dt)
        self._y = least_jerk(self._y, self._aim[1], remaining, dt)
        self._elapsed += dt
        self._left = max(self._left - dt, 0.0)
        x, y = placed(pose, (self._x.position, self._y.position, 0.0))
        return pose._replace(x=x, y=y)

    def _head_for(self, aim: tuple[float, float], seconds: float) -> None:
        """Change the aim; if that begins a new shift, it shall take `seconds`."""
        self._aim = aim
        if math.dist(aim, self._begun_for) > _NEW_SHIFT:
            self._begun_for = aim
            self._begun_at = self._x.position, self._y.position
            self._elapsed, self._left = 0.0, seconds

    def _take_time(self, acceleration: float) -> None:
        """Lengthen a shift under way that would be firmer than this, m/s^2."""
        if self._elapsed == 0.0 or self._left > 0.0:
            whole = math.sqrt(_LEAST_JERK_PEAK * math.dist(self._aim, self._begun_at) / acceleration)
            self._left = max(self._left, whole - self._elapsed)

    def _best_aim(
        self, stands: Iterable[Stand], level: Pose, twist: Twist, margin: float
    ) -> tuple[tuple[float, float], int]:
        """Return the shift nearest to the present aim that serves as many of the stands, in order, as one shift can.

        Second comes how many it serves.
        """
        planes: list[HalfPlane] = []
        aim: tuple[float, float] | None = None
        served = 0
        for stand in stands:
            allowed = self._allowed(stand, level, twist, margin)
            planes += allowed
            nearest = nearest_inside(*self._aim, planes) if allowed else None
            if nearest is None:
                # Where the first stand allows nothing, its feet are in a line or too near each other.
                return aim or self._middle(stand, level, twist), served
            aim, served = nearest, served + 1
        return aim or self._aim, served

    def _allowed(self, stand: Stand, level: Pose, twist: Twist, margin: float) -> list[HalfPlane]:
        """Return where the shift must lie, so that a stand bears the body from its begin to its end."""
        allowed = []
        for time in (stand.begin, stand.end):
            for nx, ny, bound in support_polygon(seen_from(advanced(level, twist, time), stand.feet)):
                reached = nx * self._centre.x + ny * self._centre.y
                allowed.append(HalfPlane(nx, ny, bound + margin - reached))
        return allowed

    def _middle(self, stand: Stand, level: Pose, twist: Twist) -> tuple[float, float]:
        feet = seen_from(advanced(level, twist, 0.5 * (stand.begin + stand.end)), stand.feet)
        count = max(len(feet), 1)
        return (sum(foot.x for foot in feet) / count - self._centre.x,
                sum(foot.y for foot in feet) / count - self._centre.y)

    def _firmest(self, footfalls: Footfalls, level: Pose) -> float:
        """Return how firmly the body may start for its aim and brake there, m/s^2, if it is at `level` then.

        A centre of mass at height h that brakes with a presses on the ground h a / g ahead of itself; when it
        starts, as far behind. That point, the zero-moment point, must stay well between the feet.
        """
        dx, dy = self._aim[0] - self._begun_at[0], self._aim[1] - self._begun_at[1]
        way = math.hypot(dx, dy)
        if way < _NEW_SHIFT:
            return math.inf
        x, y = self._centre.x + self._aim[0], self._centre.y + self._aim[1]
        room = math.inf
        for nx, ny, bound in support_polygon(seen_from(level, _on_ground(footfalls))):
            inside = nx * x + ny * y - bound
            along = (nx * dx + ny * dy) / way
            if along < -_ROUNDING:  # a side ahead of the aim
                room = min(room, -inside / along)
            elif along > _ROUNDING:  # a side behind the start
                room = min(room, inside / along - way)
        return max(_SHARE * _GRAVITY * room / (level.z + self._centre.z), _GENTLEST)


def _on_ground(footfalls: Footfalls) -> Sequence[Vec3]:
    """Return where the feet stand or will be set down."""
    return [Vec3(x, y, 0.0) for x, y in footfalls.footprints]
