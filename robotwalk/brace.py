"""Draws the body back while a foot finds no ground: another one may stand on the brink of the same hole.

The centre of mass goes to where the robot would not tip if any one of the feet on that side gave way. As long as the
robot is about there, the body leans back, so that it is nearly there when the next foot finds nothing.
"""

import math
from collections.abc import Sequence

from robotwalk.stepping import Footfalls
from robotwalk.support import nearest_inside, support_polygon
from robotwalk.types import STILL, Pose, Twist

_MARGIN = 0.01  # m inside the feet that are left
_SPEED = 0.08  # m/s
_GAIN = 4.0  # 1/s
_FEWEST = 4  # feet, of which one may give way
_THERE = 1e-3  # m
_LEAN = 0.03  # m


def leaning_back(posture: Pose, way: float | None, yaw: float) -> Pose:
    """Return a posture farther back from where a foot found no ground, in a way in odom; as it is if none did."""
    if way is None:
        return posture
    return posture._replace(
        x=posture.x - _LEAN * math.cos(way - yaw), y=posture.y - _LEAN * math.sin(way - yaw))


def braced(falls: Footfalls, loads: Sequence[float], pose: Pose) -> Twist:
    """Return the twist of a body at `pose` on its way to where it is safe; none where there is no such place.

    Nor is there one before an obstacle. By the `loads` of all feet, N, the centre of mass is known.
    """
    borne = [(foot, load) for foot, load, stands in zip(falls.stood, loads, falls.planted, strict=True) if stands]
    total = sum(load for _, load in borne)
    obstacle = falls.giving_up is not None and falls.giving_up.kind == "obstacle"
    if falls.void is None or obstacle or len(borne) < _FEWEST or total <= 0.0:
        return STILL
    x = sum(load * foot.x for foot, load in borne) / total
    y = sum(load * foot.y for foot, load in borne) / total
    void_x, void_y = falls.void[0] - x, falls.void[1] - y
    sides = [
        side._replace(bound=side.bound + _MARGIN)
        for gone, _ in borne if (gone.x - x) * void_x + (gone.y - y) * void_y > 0.0
        for side in support_polygon(foot for foot, _ in borne if foot is not gone)]
    safe = nearest_inside(x, y, sides)
    if safe is None or math.dist(safe, (x, y)) < _THERE:
        return STILL
    dx, dy = safe[0] - x, safe[1] - y
    share = min(_GAIN, _SPEED / math.hypot(dx, dy))
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    return Twist(share * (c * dx + s * dy), share * (c * dy - s * dx), 0.0)
