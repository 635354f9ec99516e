"""Feet that step without a clock, on perfect joints: whatever is asked, none jumps, strays, or leaves its turn."""

import itertools
import math
import random
from typing import Any

import pytest

from robotwalk.body import placed
from robotwalk.config.document import Document
from robotwalk.config.gait_schema import SteppingConfig
from robotwalk.errors import ConfigError
from robotwalk.foot import Foot
from robotwalk.free_stepping import at, circles, passing
from robotwalk.gait import Gait
from robotwalk.gait_rules import fitted, read_gait
from robotwalk.model import RobotModel
from robotwalk.types import LEVEL, STILL, Command, Pose, Twist, Vec3
from robotwalk.velocity import feasible

from .conftest import PerfectRobot, load_gait, load_model

AHEAD = Twist(0.1, 0.0, 0.0)
SWING = 0.4  # s
GROUPS = {
    "hexapod": [["lf", "rm", "lr"], ["rf", "lm", "rr"]],
    "quadruped": [["lf", "rr"], ["rf", "lr"]],
    "pentapod": [["f"], ["lr"], ["rf"], ["lf"], ["rr"]],
    "octopod": [["lf", "rr"], ["rmf", "lmr"], ["lmf", "rmr"], ["rf", "lr"]],
}


def config(groups: list[list[str]], **keys: Any) -> SteppingConfig:
    return SteppingConfig.model_validate({
        "schema": 1, "kind": "stepping", "name": "free", "description": "", "slowest_period_s": 1.0, "groups": groups,
        "allowed": [(-1, 0.4), (0, 0.3), (1, 0.3)], "overshoot": 1.0, "largest_angle_deg": 20, "escape": 1.2, **keys})


def gait_of(model: RobotModel, **keys: Any) -> Gait:
    return Gait(circles(config(GROUPS[model.name], **keys)), model)


def walker(name: str, **keys: Any) -> PerfectRobot:
    model = load_model(name)
    return PerfectRobot(model, {"free": gait_of(model, **keys)}, "free")


def lift_offs(frames: list[Any]) -> list[tuple[float, int]]:
    """Return (s, foot) of every lift-off."""
    return [
        (tick / 100.0, foot) for tick, (a, b) in enumerate(itertools.pairwise(frames), start=1)
        for foot, (was, now) in enumerate(zip(a.wanted.planted, b.wanted.planted, strict=True)) if was and not now]


@pytest.mark.parametrize("name", GROUPS)
@pytest.mark.parametrize("seed", range(2))
def test_whatever_is_asked_no_foot_jumps_and_no_more_are_lifted_than_a_group_has(name: str, seed: int) -> None:
    robot, chance = walker(name), random.Random(seed)
    model, most = robot.model, max(map(len, GROUPS[name]))
    robot.stand_up()
    frames = []
    for _ in range(9):
        twist = Twist(chance.uniform(-0.15, 0.15), chance.uniform(-0.1, 0.1), chance.uniform(-0.7, 0.7))
        frames += robot.walk(Command(chance.choice([twist, twist, STILL])), chance.uniform(0.2, 1.2))
    nearest = min(math.dist(a.rest_foot[:2], b.rest_foot[:2]) for a, b in itertools.combinations(model.legs, 2))
    joints = model.joints
    for before, after in itertools.pairwise(frames):
        assert sum(not stands for stands in after.wanted.planted) <= most
        assert after.wanted.reach_error < 1e-4
        for foot, leg in enumerate(model.legs):
            moved = math.dist(before.feet[foot], after.feet[foot])
            if before.wanted.planted[foot] and after.wanted.planted[foot]:
                assert moved < 1e-6
            # Of a way of 1.1 strides, and what the body makes of it, in the least time: 1.9 times its mean speed.
            assert moved < 1.9 * (1.5 * leg.max_stride + 2.0 * leg.lift) / model.motion.min_swing * robot.dt
        for a, b in itertools.combinations(after.feet_in_base, 2):
            assert math.dist(a[:2], b[:2]) > 0.5 * nearest, "legs tangle"
        assert all(j.lower < angle < j.upper for j, angle in zip(joints, after.wanted.angles, strict=True))
    robot.stand_up()
    for foot, leg in zip(robot.tick().feet_in_base, model.legs, strict=True):
        assert math.dist(foot[:2], leg.rest_foot[:2]) < 2e-3, "at rest when it stands"


@pytest.mark.parametrize("name", GROUPS)
@pytest.mark.parametrize(("twist", "alike"), [
    (Twist(-0.5, -1.0, 0.0), True), (Twist(0.0, 0.0, 1.0), True),
    (Twist(0.3, 0.0, 1.0), False)])  # on an arc inner feet let turns pass
def test_groups_take_turns_evenly_and_the_body_is_not_held_up(name: str, twist: Twist, alike: bool) -> None:
    robot = walker(name)
    fastest, _ = feasible(twist, robot.model.motion, gait_of(robot.model))
    twist = Twist(*(0.8 * part for part in fastest))
    frames = robot.walk(Command(twist), 14.0)[600:]
    assert all(frame.wanted.twist == pytest.approx(twist) for frame in frames)
    names = [leg.name for leg in robot.model.legs]
    group_of = {names.index(leg): index for index, group in enumerate(GROUPS[name]) for leg in group}
    turns = [(when, {group_of[foot] for _, foot in feet})
             for when, feet in itertools.groupby(lift_offs(frames), key=lambda lift: lift[0])]
    order = [group for _, groups in turns for group in groups]
    count = len(GROUPS[name])
    assert len(order) > count
    assert all(len(groups) == 1 for _, groups in turns)
    if not alike:
        return
    for part in range(len(order) - count + 1):
        assert len(set(order[part:part + count])) == count, "each in turn"
    gaps = [b - a for (a, _), (b, _) in itertools.pairwise(turns)]
    assert max(gaps) < 1.5 * min(gaps)


def test_a_foot_steps_where_its_leg_is_allowed_to_and_past_rest_as_far() -> None:
    curve = [(-1.0, 0.5), (0.0, 0.3), (1.0, 0.2)]
    robot = walker("hexapod", allowed_of={"lm": curve}, overshoot=0.5, escape=1.1)
    frames = robot.walk(Command(Twist(0.06, 0.0, 0.0)), 10.0)[400:]
    for foot, (back, ahead) in ((0, (0.4, 0.15)), (1, (0.5, 0.1))):
        leg = robot.model.legs[foot]
        offsets = [
            (frame.feet_in_base[foot].x - leg.rest_foot.x) / leg.max_stride
            for frame in frames if frame.wanted.planted[foot]]
        assert max(offsets) == pytest.approx(ahead, abs=0.03)
        # One that is late waits for no one; one that has time left comes along with its group.
        assert -back - 0.03 < min(offsets) < -0.2


def standing(model: RobotModel, **offsets: tuple[float, float]) -> list[Foot]:
    """Return feet that stand so far off rest, in shares of their strides, the body at the origin."""
    feet = []
    for leg in model.legs:
        x, y = placed(LEVEL, leg.rest_foot)
        dx, dy = offsets.get(leg.name, (0.0, 0.0))
        feet.append(Foot(leg))
        feet[-1].plant(Vec3(x + dx * leg.max_stride, y + dy * leg.max_stride, model.foot_radius))
    return feet


def lift(gait: Gait, feet: list[Foot], *names: str) -> None:
    for index, foot in enumerate(feet):
        if foot.leg.name in names:
            foot.lift_off(gait.feet[index][0], 0.4, None, foot.leg.lift)


def due(gait: Gait, feet: list[Foot], twist: Twist = AHEAD) -> set[str]:
    assert gait.free is not None
    return {feet[index].leg.name for index in gait.free.due(feet, LEVEL, twist, SWING)}


def test_the_escape_distance_lets_a_leg_step_whatever_the_turn(hexapod: RobotModel) -> None:
    gait = gait_of(hexapod)
    for back, escapes in ((0.47, set()), (0.49, {"rr"})):  # allowed 0.4, escape 1.2 times that
        feet = standing(hexapod, rr=(-back, 0.0))
        lift(gait, feet, "lf")
        assert due(gait, feet) == escapes
    feet = standing(hexapod, rr=(-0.49, 0.0))
    lift(gait, feet, "lf", "rm", "lr")
    assert due(gait, feet) == set(), "three are in the air already"
    feet = standing(hexapod, lm=(-0.49, 0.0))
    lift(gait, feet, "lf", "lr")
    assert due(gait, feet) == set(), "the left side would hang"


def test_an_angle_about_the_body_is_too_far_where_the_distance_is_not(hexapod: RobotModel) -> None:
    # The middle foot, 10 mm off along x: less than it may be, but an angle about the body.
    x, y = hexapod.legs[1].rest_foot[:2]
    degrees = math.degrees(math.atan2(0.1 * hexapod.legs[1].max_stride, math.hypot(x, y)))
    slow = Twist(0.0, 0.0, 0.01)
    feet = standing(hexapod, lm=(0.1, 0.0))
    assert "lm" in due(gait_of(hexapod, largest_angle_deg=0.99 * degrees), feet, slow)
    assert due(gait_of(hexapod, largest_angle_deg=1.01 * degrees), feet, slow) == set()


def test_standing_still_each_foot_off_rest_steps_back_group_by_group(hexapod: RobotModel) -> None:
    gait = gait_of(hexapod)
    feet = standing(hexapod, lf=(0.1, 0.0), lr=(0.0, 0.1), rf=(0.1, 0.1))
    assert due(gait, feet, STILL) in ({"lf", "lr"}, {"rf"})
    assert due(gait, standing(hexapod, lf=(0.01, 0.0)), STILL) == set()


@pytest.mark.parametrize("twist", [AHEAD, Twist(-0.1, 0.05, 0.0), Twist(0.0, 0.0, -0.5), Twist(0.05, 0.0, 0.4)])
def test_a_foot_is_set_down_past_rest_the_way_the_body_goes_over_it(hexapod: RobotModel, twist: Twist) -> None:
    gait = gait_of(hexapod)
    assert gait.free is not None
    course = Pose(0.3, -0.2, 0.1, 0.0, 0.0, 0.7)
    for index, leg in enumerate(hexapod.legs):
        x, y = placed(course, leg.rest_foot)
        tx, ty = gait.free.footprint(index, leg, course, twist, 0.0)
        ux, uy = passing(leg, twist)
        speed = math.hypot(ux, uy)
        wanted = min(at(config(GROUPS["hexapod"]).allowed, ux / speed) * leg.max_stride, 0.5 * speed)
        assert math.hypot(tx - x, ty - y) == pytest.approx(wanted)
        assert math.remainder(math.atan2(ty - y, tx - x) - math.atan2(uy, ux) - 0.7, math.tau) == pytest.approx(0.0)


def test_a_walk_changes_between_a_clock_and_none_without_a_jump(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    robot = PerfectRobot(hexapod, {**gaits, "free": gait_of(hexapod)}, "free")
    frames = []
    for gait in ("tripod", "free", "ripple", "free", "wave", "free"):
        frames += robot.walk(Command(Twist(0.05, 0.0, 0.1), gait=gait), 4.0)
    for before, after in itertools.pairwise(frames):
        assert max(math.dist(a, b) for a, b in zip(before.feet, after.feet, strict=True)) < 0.012
        assert sum(after.wanted.planted) >= 3
    assert frames[-1].wanted.twist == pytest.approx((0.05, 0.0, 0.1))


def test_the_bundled_ones_are_for_the_feet_that_they_name() -> None:
    for name in ("hexapod", "quadruped"):
        gait = load_gait(f"free-{name}", load_model(name))
        assert gait.free is not None
    quadruped = load_model("quadruped")
    assert fitted(config(GROUPS["hexapod"]), quadruped.legs) is None


@pytest.mark.parametrize(("old", "new", "complaint"), [
    ("groups: [[a, b], [c]]", "groups: [[a, b], [a]]", "each leg should be in one group, not a in several"),
    ("groups: [[a, b], [c]]", "groups: [[a, b, c]]", r"free\.yaml:4:9: groups: "),
    ("[[-1, 0.4], [1, 0.3]]", "[[-0.9, 0.4], [1, 0.3]]", r"free\.yaml:5:10: allowed: should go from -1, straight back"),
    ("[[-1, 0.4], [1, 0.3]]", "[[-1, 0.4], [1, 0.6]]", r"free\.yaml:5:26: allowed\.1\.1: .*0\.5.*\(got 0\.6\)"),
    ("escape: 1.2", "escape: 1.5", "escape times what is allowed should be 0.55 strides at most, not 0.6"),
    ("escape: 1.2", "escape: 1.2\nrocking: 0.5", "neither balance nor rocking is for stepping"),
    ("escape: 1.2", "escape: 1.2\nallowed_of: {d: [[-1, 0.4], [1, 0.3]]}", "allowed_of names legs .* no group: d"),
])
def test_a_broken_file(old: str, new: str, complaint: str) -> None:
    text = "\n".join([
        "schema: 1", "kind: stepping", "name: free", "groups: [[a, b], [c]]", "allowed: [[-1, 0.4], [1, 0.3]]",
        "escape: 1.2", "description: x", "slowest_period_s: 1", "overshoot: 1", "largest_angle_deg: 20"])
    read_gait(Document.parse(text, "free.yaml"))
    assert old in text
    with pytest.raises(ConfigError, match=complaint):
        read_gait(Document.parse(text.replace(old, new), "free.yaml"))
