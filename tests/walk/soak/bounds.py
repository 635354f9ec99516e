"""How fast a foot's target may move, seen from the body, in the worst of a robot's swings."""

import math

from robotwalk import assembly
from robotwalk.carriage import MOST_ROOM
from robotwalk.gait import Gait
from robotwalk.model import Leg, RobotModel
from robotwalk.types import Twist
from robotwalk.velocity import feasible

# What the body itself may do meanwhile: shift aside (0.05), rise (0.06), lean (0.35 rad/s at up to 0.25 m), sway.
_BODY = 0.25  # m/s
_AHEAD = 0.5  # of the largest stride, that a foot is set down ahead of rest
_DIRECTIONS = 16
_MOMENTS = 200


def fastest_target(blueprint: assembly.Blueprint) -> float:
    """Return the bound for one robot, m/s.

    The worst swing takes a foot from as far behind as one may be to as far ahead, in the shortest time, while the body
    goes on at the gait's highest speed.
    """
    model = blueprint.model
    return _BODY + max(
        _fastest(model, leg, gait, _body_speed(model, gait))
        for name, gait in blueprint.gaits.items() if name not in blueprint.refused for leg in model.legs)


def _body_speed(model: RobotModel, gait: Gait) -> float:
    """Return how fast the body passes over a foot at the most, m/s."""
    fastest, limits = 0.0, model.motion
    for index in range(_DIRECTIONS):
        angle = math.tau * index / _DIRECTIONS
        for turn in (0.0, limits.turn, -limits.turn):
            wanted = Twist(limits.speed * math.cos(angle), limits.speed * math.sin(angle), turn)
            fastest = max(fastest, *gait.foot_speeds(feasible(wanted, limits, gait)[0]))
    return fastest


def _fastest(model: RobotModel, leg: Leg, gait: Gait, body_speed: float) -> float:
    path, seconds = gait.swing_path or leg.swing_path, model.motion.min_swing
    way = (MOST_ROOM + _AHEAD) * leg.max_stride + body_speed * seconds
    points = [path.at(index / _MOMENTS) for index in range(_MOMENTS)]
    return max(
        math.hypot(way * point.way.velocity / seconds - body_speed, leg.lift * point.height.velocity / seconds)
        for point in points)
