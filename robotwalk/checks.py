"""What a robot's files must fulfil beyond their schema, and what `robotwalk check` finds without motion."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from robotwalk.chain import foot_position
from robotwalk.config.document import Document
from robotwalk.config.gait_schema import AnyGaitConfig, GaitConfig
from robotwalk.config.schema import RobotConfig
from robotwalk.controller import Controller
from robotwalk.estimator import Estimate
from robotwalk.gait import Gait
from robotwalk.kinematics import closed_form_for, resting_angles, solver_for
from robotwalk.model import Leg, RobotModel
from robotwalk.reach import Solution
from robotwalk.supervisor import State
from robotwalk.support import centre_of_mass, support_margin
from robotwalk.swing_paths import SwingPath
from robotwalk.types import LEVEL, Command, Twist, Vec3

_DIRECTIONS = 24  # in which strides are tried
_TICK = 0.01  # s
REACHED = 1e-4  # m; a foot that misses its target by less is there
_SETTLING = 3.0  # s until a walk is steady
_MOMENTS = tuple(index / 20.0 for index in range(21))  # of a swing


def require_consistent(document: Document, config: RobotConfig) -> None:
    """Compare sections with each other.

    Raises:
        ConfigError: feet and legs differ, heights are out of order, or two things would tilt the body.
    """
    legs, feet = config.skeleton.legs, config.locomotion.feet
    for name in feet:
        if name not in legs:
            raise document.error(("locomotion", "feet", name), f"no such leg; there are {', '.join(legs)}")
    for name in legs:
        if name not in feet:
            raise document.error(("locomotion", "feet"), f"leg {name!r} is missing")
    for name in config.locomotion.reaction.weights:
        if name not in legs:
            raise document.error(
                ("locomotion", "reaction", "weights", name), f"no such leg; there are {', '.join(legs)}")
    orientation, levelling = config.locomotion.orientation, config.locomotion.levelling
    if levelling is not None and orientation is not None and orientation.share > 0.0:
        raise document.error(
            ("locomotion", "levelling"), "by the IMU or by the feet: this excludes orientation, unless its share is 0")
    height = config.locomotion.height_mm
    if not height.sit < height.lowest <= height.stand <= height.highest:
        raise document.error(
            ("locomotion", "height_mm"), "expected sit < lowest <= stand <= highest", height.model_dump())
    if height.sit < 0.5 * config.skeleton.body.box_mm[2]:
        raise document.error(("locomotion", "height_mm", "sit"), "the body would be in the ground", height.sit)


def require_sound_gait(document: Document, config: AnyGaitConfig) -> None:
    """Check each foot's circle.

    Raises:
        ConfigError: sectors are empty, overlap, or leave no stance.
    """
    if not isinstance(config, GaitConfig):
        return  # a formula gives sound circles
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
        ConfigError: a leg has no closed form though one is asked for, is too short or too long, or a joint would leave
            its limits.
    """
    for leg in model.legs:
        if leg.solver == "closed_form" and closed_form_for(leg) is None:
            axes = ", ".join(joint.axis.name.lower() for joint in leg.joints)
            raise document.error(
                ("locomotion", "solver"), f"leg {leg.name} has no closed form for the chain ({axes}); known: yaw, "
                "pitch, pitch with links along x; roll, pitch, pitch with links along y, -z, -z and a knee bent at "
                "rest; any chain has ccd", leg.solver)
    for height, name in ((model.heights.stand, "stand"), (model.heights.sit, "sit")):
        for leg in model.legs:
            target = leg.rest_foot._replace(z=model.foot_radius - height)
            solution = solver_for(leg).solve(*target)
            path = ("locomotion", "feet", leg.name, "rest_mm")
            got = document.value(path)
            posture = f"at the {name} height of {1000.0 * height:.0f} mm"
            if solution.miss > REACHED:
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
    # m from the centre of mass to the support polygon's edge, at worst; negative outside. None: there are moments
    # without a polygon, and the gait is balanced only by its motion.
    margin: float | None


def gait_reach(model: RobotModel, gait: Gait) -> GaitReach:
    """Try each leg's longest swings, in all directions, at all heights."""
    miss, tightest = 0.0, Margin(math.inf, "", 0.0, 0.0, 0.0)
    for leg, stride, sectors in zip(model.legs, gait.strides, gait.feet, strict=True):
        solver = solver_for(leg)
        body_way = max(sector.length / sector.stance for sector in sectors)
        for target in _longest_swings(model, leg, stride, gait.swing_path or leg.swing_path, body_way):
            solution = solver.solve(*target)
            miss = max(miss, solution.miss)
            tightest = min(tightest, *_margins(leg, solution))
    return GaitReach(gait.name, gait_speed(model, gait), miss, tightest)


def gait_speed(model: RobotModel, gait: Gait) -> float:
    """Return how fast a gait can go straight ahead, m/s."""
    ahead = min(
        stride / (stance * gait.fastest_period)
        for stride, stance in zip(gait.strides, gait.longest_stance, strict=True))
    return min(ahead, model.motion.speed)


def balance(model: RobotModel, gait: Gait) -> Balance:
    """Return the least static margin of a steady walk, straight on at top speed, as the controller poses the robot."""
    if min(sum(support.standing) for support in gait.supports) < 3:
        return Balance(gait.name, None)
    ahead = Command(Twist(gait_speed(model, gait), 0.0, 0.0))
    controller = Controller(model, {gait.name: gait}, gait.name)
    controller.start(resting_angles(model, model.heights.sit))
    at_start = Estimate(LEVEL, len(model.legs))
    while not controller.step(State.STAND, Command(), at_start, _TICK).standing:
        pass
    worst = math.inf
    settling = round((_SETTLING + gait.slowest_period) / _TICK)
    for tick in range(settling + round(gait.slowest_period / _TICK)):
        wanted = controller.step(State.WALK, ahead, at_start, _TICK)
        if tick >= settling:
            feet = [
                foot_position(leg, wanted.angles[leg.span])
                for leg, planted in zip(model.legs, wanted.planted, strict=True) if planted]
            worst = min(worst, support_margin(feet, centre_of_mass(model, wanted.angles)))
    return Balance(gait.name, worst)


def _longest_swings(
    model: RobotModel, leg: Leg, stride: float, path: SwingPath, body_way: float
) -> Iterator[Vec3]:
    """Return points of a leg's longest swings through its rest position, ends included, in the base frame.

    During a swing the body moves on by `body_way` strides, evenly, while the foot starts and lands at rest: first
    it falls behind the stride's end.
    """
    for height in (model.heights.lowest, model.heights.stand, model.heights.highest):
        for index in range(_DIRECTIONS):
            angle = math.tau * index / _DIRECTIONS
            for moment in _MOMENTS:
                point = path.at(moment)
                way = point.way.position
                offset = stride * (way - 0.5 + body_way * (way - moment))
                yield Vec3(
                    leg.rest_foot.x + offset * math.cos(angle), leg.rest_foot.y + offset * math.sin(angle),
                    model.foot_radius - height + leg.lift * point.height.position)


def _margins(leg: Leg, solution: Solution) -> list[Margin]:
    return [
        Margin(min(angle - joint.lower, joint.upper - angle), joint.name, angle, joint.lower, joint.upper)
        for joint, angle in zip(leg.joints, solution.angles, strict=True)
    ]


