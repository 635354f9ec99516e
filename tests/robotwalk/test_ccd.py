"""Cyclic coordinate descent: any chain, its limits kept, beside the closed forms where there are some."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotwalk import assembly
from robotwalk.ccd import CyclicDescent
from robotwalk.chain import foot_position
from robotwalk.kinematics import closed_form_for, solver_for
from robotwalk.model import Axis, Joint, Leg
from robotwalk.types import Vec3

BODIES = {name: assembly.load(name).model.legs for name in ("hexapod", "quadruped")}
EXACT = 1e-6  # m

any_leg = st.sampled_from([leg for legs in BODIES.values() for leg in legs])
lengths = st.floats(0.03, 0.12)
rests = st.floats(-1.0, 1.0)
rooms = st.floats(0.3, 1.5)


def joints(axes: list[Axis], links: st.SearchStrategy[Vec3], *, knees: bool = True) -> st.SearchStrategy[Leg]:
    """Return legs of these axes, their links and limits at random; the knees, behind the second joint, bend one way."""
    rows = [
        st.tuples(links, st.just(0.9), st.floats(0.3, 0.7), rooms) if knees and index > 1 else
        st.tuples(links, rests, rooms, rooms) for index in range(len(axes))]

    def build(*drawn: tuple[Vec3, float, float, float]) -> Leg:
        chain = tuple(
            Joint(f"j{index}", axis, link, rest - below, rest + above, rest, 0.1, 0.01)
            for index, (axis, (link, rest, below, above)) in enumerate(zip(axes, drawn, strict=True)))
        return replace(BODIES["hexapod"][0], joints=chain)

    return st.builds(build, *rows)


arthropods = st.integers(3, 5).flatmap(
    lambda count: joints([Axis.YAW] + [Axis.PITCH] * (count - 1), st.builds(Vec3, lengths, st.just(0.0), st.just(0.0))))
odd = joints([Axis.YAW, Axis.ROLL, Axis.PITCH, Axis.PITCH, Axis.PITCH], st.builds(
    Vec3, lengths, st.floats(-0.03, 0.03), st.floats(-0.03, 0.03)), knees=False)
shares = st.lists(st.floats(0.05, 0.95), min_size=5, max_size=5)


def angles_at(leg: Leg, part: list[float]) -> list[float]:
    return [joint.lower + share * (joint.upper - joint.lower) for joint, share in zip(leg.joints, part, strict=False)]


def assert_within(leg: Leg, angles: tuple[float, ...]) -> None:
    assert all(joint.lower <= angle <= joint.upper for joint, angle in zip(leg.joints, angles, strict=True))


@settings(max_examples=60, derandomize=True)
@given(any_leg, shares)
def test_it_agrees_with_the_closed_form_wherever_there_is_one(leg: Leg, part: list[float]) -> None:
    wanted = angles_at(leg, part)
    foot = foot_position(leg, wanted)
    closed = solver_for(leg).solve(*foot)
    found = CyclicDescent(leg).solve(*foot)
    assert_within(leg, found.angles)
    assert math.dist(foot_position(leg, found.angles), foot) == pytest.approx(found.miss, abs=EXACT)
    # Drawn in past its first axis a leg faces away; near to that axis no solver's first joint knows where to turn.
    away = math.hypot(foot.y - leg.mount.y, (foot.x - leg.mount.x) if leg.joints[0].axis is Axis.YAW else (
        foot.z - leg.mount.z))
    facing = closed.angles == pytest.approx(wanted, abs=1e-6) and away > 0.06
    if facing and 0.15 < part[2] < 0.85 and abs(wanted[2]) > 0.45:  # not where the limits shorten it
        assert closed.miss == 0.0
        assert found.miss <= EXACT
        assert found.angles[2] == pytest.approx(closed.angles[2], abs=1e-3)


def followed(leg: Leg, part: list[float]) -> Iterator[float]:
    """Lead a foot from rest as its joints can go, in small steps; yield each miss, in m."""
    rest, goal = [joint.rest for joint in leg.joints], angles_at(leg, part)
    solver = CyclicDescent(leg)
    last: tuple[float, ...] | None = None
    for step in range(101):
        foot = foot_position(leg, [a + step / 100.0 * (b - a) for a, b in zip(rest, goal, strict=True)])
        found = solver.solve(*foot)
        assert_within(leg, found.angles)
        reached = foot_position(leg, found.angles)
        assert math.dist(solver.foot(found.angles), reached) < 1e-12
        assert math.dist(reached, foot) == pytest.approx(found.miss, abs=2e-7)
        assert last is None or math.dist(found.angles, last) < 1.0
        last = found.angles
        yield found.miss


@settings(max_examples=30, derandomize=True)
@given(arthropods, st.lists(st.floats(0.25, 0.75), min_size=5, max_size=5))
def test_a_leg_of_any_number_of_joints_follows_its_foot_wherever_it_can_go(leg: Leg, part: list[float]) -> None:
    misses = list(followed(leg, part))
    assert min(misses) <= EXACT
    # Near its ends a leg is shortened by up to 1/e of the last fiftieth of its reach.
    assert max(misses) <= 0.01 * sum(joint.link.x for joint in leg.joints)


@settings(max_examples=15, derandomize=True)
@given(odd, shares)
def test_an_odd_chain_keeps_its_limits_and_tells_by_how_much_it_misses(leg: Leg, part: list[float]) -> None:
    """Bent against its limits, such a chain may lose its target; it neither jumps nor claims to be there."""
    assert max(followed(leg, part)) < 0.2


def test_the_limits_are_those_about_the_rest_pose() -> None:
    leg = BODIES["hexapod"][1]
    coxa, femur, tibia = leg.joints
    # Rest 45 deg with +25/-11 is 34 to 70 deg absolute (ARTH section 4.2).
    narrow = replace(leg, joints=(coxa, femur, tibia._replace(
        lower=math.radians(34.0), upper=math.radians(70.0), rest=math.radians(45.0))))
    folded = foot_position(leg, [math.radians(angle) for angle in (0.0, -60.0, 120.0)])
    found = CyclicDescent(narrow).solve(*folded)
    assert math.degrees(found.angles[2]) == pytest.approx(70.0, abs=0.01)
    assert found.miss == pytest.approx(math.dist(foot_position(narrow, found.angles), folded))
    assert found.miss > 0.03


@pytest.mark.parametrize("solver", [
    pytest.param(lambda leg: solver_for(leg), id="closed form"), pytest.param(CyclicDescent, id="ccd")])
@pytest.mark.parametrize(("body", "ahead"), [("hexapod", (0.8, -0.6)), ("quadruped", (0.3, -0.954))])
def test_a_leg_is_shortened_smoothly_as_its_target_leaves_its_reach(
    body: str, ahead: tuple[float, float], solver: object
) -> None:
    assert callable(solver)
    leg = BODIES[body][0]
    joint = foot_position(replace(leg, joints=leg.joints[:1]), (leg.joints[0].rest,))
    found, step = solver(leg), 5e-4
    ways = []
    for index in range(1, 720):
        away = [component * index * step for component in ahead]
        c, s = math.cos(leg.yaw), math.sin(leg.yaw)
        target = Vec3(joint.x + c * away[0], joint.y + s * away[0], joint.z + away[1])
        foot = foot_position(leg, found.solve(*target).angles)
        ways.append(math.dist(foot, joint))
    slopes = [(b - a) / step for a, b in itertools.pairwise(ways)]
    # Within reach the foot goes as far as its target does; beyond, it comes to rest, and its speed never jumps.
    assert min(slopes) > -1e-4
    assert max(slopes) == pytest.approx(1.0, abs=1e-3)
    assert slopes[0] < 0.02
    assert slopes[-1] < 0.02
    assert max(abs(b - a) for a, b in itertools.pairwise(slopes)) < 0.25
    assert found.solve(*joint).miss > 0.0


@given(any_leg, *[st.floats(allow_nan=False, allow_infinity=False, min_value=-1e6, max_value=1e6)] * 3)
@settings(max_examples=30)
def test_any_target_has_an_answer_within_the_limits(leg: Leg, x: float, y: float, z: float) -> None:
    found = CyclicDescent(leg).solve(x, y, z)
    assert_within(leg, found.angles)
    assert math.isfinite(found.miss)


def test_one_file_chooses_the_solver() -> None:
    leg = BODIES["hexapod"][0]
    assert isinstance(solver_for(replace(leg, solver="ccd")), CyclicDescent)
    assert isinstance(solver_for(leg), type(closed_form_for(leg)))
    assert isinstance(solver_for(replace(leg, joints=(*leg.joints, leg.joints[-1]))), CyclicDescent)


def test_a_chain_with_a_joint_to_spare_comes_back_to_its_pose() -> None:
    """Round and round for a hundred strides, its pose does not wander off."""
    leg = BODIES["hexapod"][0]
    coxa, femur, tibia = leg.joints
    four = replace(leg, joints=(
        coxa, femur, tibia._replace(link=Vec3(0.08, 0.0, 0.0), rest=1.2),
        tibia._replace(link=Vec3(0.06, 0.0, 0.0), rest=0.6, lower=-0.4, upper=1.5)))
    solver, middle = CyclicDescent(four), foot_position(four, [joint.rest for joint in four.joints])
    poses = []
    for tick in range(100 * 60):
        angle = math.tau * tick / 60.0
        found = solver.solve(middle.x + 0.03 * math.cos(angle), middle.y - 0.03 * math.cos(angle),
                             middle.z + 0.02 * max(math.sin(angle), 0.0))
        assert found.miss <= EXACT
        if tick % 60 == 0:
            poses.append(found.angles)
    assert poses[-1] == pytest.approx(poses[20], abs=1e-4)
