"""What a robot's files must fulfil beyond their schema, and what `robotwalk check` finds without motion."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from robotwalk.config.document import Document
from robotwalk.config.schema import GaitConfig, RobotConfig
from robotwalk.gait import Gait
from robotwalk.kinematics import Solution, chain_points, resting_angles, solver_for
from robotwalk.model import Leg, RobotModel
from robotwalk.swing import SWING_PATHS, way_made
from robotwalk.types import Vec3

_DIRECTIONS = 24  # in which strides are tried
_MOMENTS = tuple(index / 20.0 for index in range(21))  # of a swing


def require_consistent(document: Document, config: RobotConfig) -> None:
    """Compare sections with each other.

    Raises:
        ConfigError: feet and legs differ, or heights are out of order.
    """
    legs, feet = config.skeleton.legs, config.locomotion.feet
    for name in feet:
        if name not in legs:
            raise document.error(("locomotion", "feet", name), f"no such leg; there are {', '.join(legs)}")
    for name in legs:
        if name not in feet:
            raise document.error(("locomotion", "feet"), f"leg {name!r} is missing")
    height = config.locomotion.height_mm
    if not height.sit < height.lowest <= height.stand <= height.highest:
        raise document.error(
            ("locomotion", "height_mm"), "expected sit < lowest <= stand <= highest", height.model_dump())
    if height.sit < 0.5 * config.skeleton.body.box_mm[2]:
        raise document.error(("locomotion", "height_mm", "sit"), "the body would be in the ground", height.sit)


def require_sound_gait(document: Document, config: GaitConfig) -> None:
    """Check each foot's circle.

    Raises:
        ConfigError: sectors are empty, overlap, or leave no stance.
    """
    for foot, sectors in config.swing.items():
        ordered = sorted(sectors)
        for index, (start, end) in enumerate(ordered):
            following = ordered[index + 1][0] if index + 1 < len(ordered) else ordered[0][0] + 1.0
            if not start < end < following:
                raise document.error(
                    ("swing", foot), "each sector should be [start, end] in turns, end past start and before the next "
                    "sector's start", [list(sector) for sector in sectors])


def require_reachable(document: Document, model: RobotModel) -> None:
    """Check that the feet's rest positions can be reached, seated and standing.

    Raises:
        ConfigError: a leg has no inverse kinematics, is too short or too long, or a joint would leave its limits.
    """
    for height, name in ((model.heights.stand, "stand"), (model.heights.sit, "sit")):
        for leg in model.legs:
            target = leg.rest_foot._replace(z=model.foot_radius - height)
            solution = solver_for(leg).solve(*target)
            path = ("locomotion", "feet", leg.name, "rest_mm")
            got = document.value(path)
            posture = f"at the {name} height of {1000.0 * height:.0f} mm"
            if solution.miss > 1e-9:
                raise document.error(
                    path, f"unreachable stance: {posture} leg {leg.name} misses the foot's rest position by "
                    f"{1000.0 * solution.miss:.0f} mm", got)
            tight = min(_margins(leg, solution))
            if tight.margin < 0.0:
                angle, lower, upper = (math.degrees(value) for value in (tight.angle, tight.lower, tight.upper))
                raise document.error(
                    path, f"unreachable stance: {posture} joint {tight.joint} would be {angle:.1f} deg, outside its "
                    f"limits of {lower:.1f} to {upper:.1f} deg", got)


class Margin(NamedTuple):
    """How far a joint stays inside its limits, rad."""

    margin: float
    joint: str
    angle: float
    lower: float
    upper: float


class GaitReach(NamedTuple):
    """Whether a gait's longest strides stay within reach, at every height."""

    gait: str
    top_speed: float  # m/s straight ahead
    miss: float  # m beyond reach, 0 if none
    tightest: Margin


class Balance(NamedTuple):
    """Where the mass is over the feet that stand."""

    gait: str
    margin: float  # m from the centre of mass to the support polygon's edge, at worst; negative outside


def gait_reach(model: RobotModel, gait: Gait) -> GaitReach:
    """Try each leg's longest swings, in all directions, at all heights."""
    miss, tightest = 0.0, Margin(math.inf, "", 0.0, 0.0, 0.0)
    for leg, sectors in zip(model.legs, gait.feet, strict=True):
        solver = solver_for(leg)
        body_way = max(sector.length / sector.stance for sector in sectors)
        for target in _longest_swings(model, leg, body_way):
            solution = solver.solve(*target)
            miss = max(miss, solution.miss)
            tightest = min(tightest, *_margins(leg, solution))
    ahead = min(
        leg.max_stride / (stance * gait.fastest_period)
        for leg, stance in zip(model.legs, gait.longest_stance, strict=True))
    return GaitReach(gait.name, min(ahead, model.motion.speed), miss, tightest)


def balance(model: RobotModel, gait: Gait) -> Balance:
    """Return the worst static margin over a gait's circle, walking ahead at the longest stride."""
    centre = centre_of_mass(model, resting_angles(model, model.heights.stand))
    ends = [sector.start + sector.length for sectors in gait.feet for sector in sectors]
    worst = min(
        support_margin(list(_standing_feet(model, gait, (event + nudge) % 1.0)), centre)
        for event in (*gait.starts, *ends) for nudge in (-1e-6, 1e-6))
    return Balance(gait.name, worst)


def _standing_feet(model: RobotModel, gait: Gait, phase: float) -> Iterator[Vec3]:
    """Return the feet in stance at a phase, each as far along its stride as its needle says."""
    for foot, leg in enumerate(model.legs):
        if gait.sector_at(foot, phase) is None:
            sector = min(gait.feet[foot], key=lambda sector: (phase - sector.start) % 1.0)
            done = ((phase - sector.start - sector.length) % 1.0) / sector.stance
            yield leg.rest_foot._replace(x=leg.rest_foot.x + leg.max_stride * (0.5 - done))


def centre_of_mass(model: RobotModel, angles: Sequence[float]) -> Vec3:
    """Return the centre of mass in the base frame, m; a link's is at its middle, the body's at its origin."""
    x = y = z = 0.0
    for leg in model.legs:
        points = chain_points(leg, angles[leg.span])
        for joint, near, far in zip(leg.joints, points, points[1:], strict=False):
            x += joint.mass * 0.5 * (near.x + far.x)
            y += joint.mass * 0.5 * (near.y + far.y)
            z += joint.mass * 0.5 * (near.z + far.z)
        foot = points[-1]
        x, y, z = x + model.foot_mass * foot.x, y + model.foot_mass * foot.y, z + model.foot_mass * foot.z
    return Vec3(x / model.mass, y / model.mass, z / model.mass)


def support_margin(feet: Sequence[Vec3], point: Vec3) -> float:
    """Return how far a point lies inside the convex hull of the feet, seen from above, m; negative outside."""
    hull = _convex_hull([(foot.x, foot.y) for foot in feet])
    if len(hull) < 3:
        return -math.inf
    margin = math.inf
    for (ax, ay), (bx, by) in zip(hull, [*hull[1:], hull[0]], strict=True):
        ex, ey = bx - ax, by - ay
        margin = min(margin, (ex * (point.y - ay) - ey * (point.x - ax)) / math.hypot(ex, ey))
    return margin


def _convex_hull(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the hull counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(set(points))

    def chain(sequence: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        hull: list[tuple[float, float]] = []
        for p in sequence:
            while len(hull) >= 2 and (
                (hull[-1][0] - hull[-2][0]) * (p[1] - hull[-2][1]) - (hull[-1][1] - hull[-2][1]) * (p[0] - hull[-2][0])
            ) <= 0.0:
                hull.pop()
            hull.append(p)
        return hull[:-1]

    return chain(ordered) + chain(ordered[::-1]) if len(ordered) > 2 else list(ordered)


def _longest_swings(model: RobotModel, leg: Leg, body_way: float) -> Iterator[Vec3]:
    """Return points of a leg's longest swings through its rest position, ends included, in the base frame.

    During a swing the body moves on by `body_way` strides, evenly, while the foot starts and lands at rest: first
    it falls behind the stride's end.
    """
    path = SWING_PATHS[model.swing_path]
    for height in (model.heights.lowest, model.heights.stand, model.heights.highest):
        for index in range(_DIRECTIONS):
            angle = math.tau * index / _DIRECTIONS
            for moment in _MOMENTS:
                way = way_made(moment)
                offset = leg.max_stride * (way - 0.5 + body_way * (way - moment))
                yield Vec3(
                    leg.rest_foot.x + offset * math.cos(angle), leg.rest_foot.y + offset * math.sin(angle),
                    model.foot_radius - height + leg.lift * path(way))


def _margins(leg: Leg, solution: Solution) -> list[Margin]:
    return [
        Margin(min(angle - joint.lower, joint.upper - angle), joint.name, angle, joint.lower, joint.upper)
        for joint, angle in zip(leg.joints, solution.angles, strict=True)
    ]


