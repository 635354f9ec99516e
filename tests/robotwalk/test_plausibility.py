"""What a gait asks of the servos, and which gaits are refused for it."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotwalk import assembly
from robotwalk.config.gait_schema import GaitConfig
from robotwalk.errors import UsageError
from robotwalk.gait import Gait, Sector
from robotwalk.model import RobotModel
from robotwalk.plausibility import falling, plausibility, strongest_push
from robotwalk.pseudo_physics import GRAVITY, Particle, Stage, steady_effort, step_at
from robotwalk.types import Command, Strength, Vec3


def foot(*spans: tuple[float, float]) -> tuple[Sector, ...]:
    starts = [start for start, _ in spans]
    following = [*starts[1:], starts[0] + 1.0]
    return tuple(
        Sector(start, end - start, after - end) for (start, end), after in zip(spans, following, strict=True))


@given(st.floats(0.1, 0.9), st.floats(0.2, 3.0))
def test_a_foot_pushes_with_gravity_by_its_duty(swing: float, period: float) -> None:
    effort = steady_effort(foot((0.2, 0.2 + swing)), period)
    assert effort.acceleration == pytest.approx(GRAVITY / (1.0 - swing), rel=1e-4)
    assert effort.speed == pytest.approx(0.5 * GRAVITY * swing * period, rel=1e-4)


def test_of_two_unequal_steps_the_shorter_stance_asks_for_more() -> None:
    effort = steady_effort(foot((0.0, 0.25), (0.35, 0.6)), 1.0)
    assert effort.acceleration > steady_effort(foot((0.0, 0.25), (0.5, 0.75)), 1.0).acceleration > 2.0 * GRAVITY - 1e-6


@pytest.mark.parametrize("rate", [50, 100, 200, 1000])
def test_what_a_ticking_foot_needs_is_that_at_any_rate(rate: int) -> None:
    """Once it is steady: the particle that ticks never needs more than a few per cent over what was judged."""
    circle, period, particle, phase, largest = foot((0.0, 0.4)), 0.8, Particle(), 0.0, 0.0
    for tick in range(12 * rate):
        step = step_at(circle, phase)
        given = particle.advance(step, period, 1.0 / rate)
        if tick > 8 * rate and step.left * period > 2.0 / rate and step.stage is not Stage.SWING:
            largest = max(largest, given)
        phase = (phase + 1.0 / (rate * period)) % 1.0
    assert largest == pytest.approx(steady_effort(circle, period).acceleration, rel=0.15)


def test_a_leg_pushes_by_its_weakest_joint(hexapod: RobotModel) -> None:
    """The femur lies 83 mm behind the foot of a standing hexapod, the tibia 25 mm."""
    blueprint = assembly.load("hexapod")
    leg, strengths = hexapod.legs[0], [Strength(1.4, 6.0)] * 3
    standing = [joint.rest for joint in leg.joints]
    push = strongest_push(leg, standing, strengths)
    assert push.force == pytest.approx(0.5 * 1.4 / 0.083, rel=0.02)
    assert strongest_push(leg, standing, [Strength(1.4, 6.0), Strength(0.7, 6.0), Strength(1.4, 6.0)]).force \
        == pytest.approx(0.5 * push.force)
    assert strongest_push(leg, standing, [Strength(1.4, 12.0)] * 3).speed == pytest.approx(2.0 * push.speed)
    assert blueprint.strengths[0].stall_torque == 1.4


def test_on_what_a_body_falls() -> None:
    ahead, behind, middle = Vec3(0.1, 0.0, 0.0), Vec3(-0.1, 0.0, 0.0), Vec3(0.0, 0.0, 0.0)
    assert falling([], middle, 1.0, 0.15) == GRAVITY
    assert falling([ahead, behind], middle, 1.0, 0.15) == 0.0
    assert falling([ahead], middle, 1.0, 0.1) == pytest.approx(0.5 * GRAVITY)
    assert falling([ahead, Vec3(0.1, 0.2, 0.0)], middle, 0.0, 0.1) == 0.0
    triangle = [Vec3(0.1, 0.1, 0.0), Vec3(0.1, -0.1, 0.0), Vec3(0.3, 0.0, 0.0)]
    assert falling(triangle, middle, 1.0, 0.1) == pytest.approx(0.5 * GRAVITY)


def test_the_library_on_the_bundled_robots() -> None:
    refused = {robot: set(assembly.load(robot).refused) for robot in ("hexapod", "octopod", "pentapod", "quadruped")}
    assert refused == {
        "hexapod": set(), "octopod": set(), "pentapod": set(),
        "quadruped": {"bound", "gallop", "rotary_gallop", "pronk"}}
    judged = assembly.load("quadruped").plausibilities
    assert judged["pronk"].load > judged["bound"].load > 2.0
    assert judged["trot"].load < 0.6


def test_feet_that_all_swing_on_one_side_are_refused_unless_the_body_rocks(hexapod: RobotModel) -> None:
    sides = {leg.name: [[0.0, 0.4]] if leg.name.startswith("l") else [[0.5, 0.9]] for leg in hexapod.legs}
    strengths = [Strength(3.0, 6.0)] * 18

    def load(rocking: float) -> float:
        config = GaitConfig.model_validate({
            "schema": 1, "name": "sides", "description": "", "slowest_period_s": 1.0, "swing": sides,
            "rocking": rocking})
        return plausibility(hexapod, Gait(config, hexapod), strengths).load

    assert load(0.0) > 2.0
    assert load(0.9) < 1.0


def test_weaker_servos_refuse_what_stronger_ones_do() -> None:
    robot = assembly.load("hexapod")
    tripod, model = robot.gaits["tripod"], robot.model
    loads = [plausibility(model, tripod, [Strength(torque, 6.0)] * 18).load for torque in (0.7, 1.4, 2.8)]
    assert loads == pytest.approx([2.0 * loads[1], loads[1], 0.5 * loads[1]])
    heavy = replace(model, body_mass=model.body_mass + model.mass)
    assert plausibility(heavy, tripod, robot.strengths).load == pytest.approx(2.0 * loads[1], rel=0.02)
    assert math.isfinite(loads[0])


def test_a_refused_gait_never_starts() -> None:
    with pytest.raises(UsageError, match=r"quadruped cannot pronk: it asks for 4\.00 times what the servos can give"):
        assembly.simulate("quadruped").robot.command(Command(gait="pronk"))
