"""The body in MuJoCo is the robot of the file."""

import math

import mujoco
import numpy as np
import pytest

from robotwalk import assembly
from robotwalk.chain import chain_points
from robotwalk.checks import centre_of_mass
from robotwalk.kinematics import resting_angles
from sim_backend.world import steps_per_tick


@pytest.fixture(scope="module")
def simulation() -> assembly.Simulation:
    return assembly.simulate("hexapod")


def test_the_mass_is_that_of_the_file(simulation: assembly.Simulation) -> None:
    assert simulation.world.world.model.body_mass.sum() == pytest.approx(2.35)
    assert simulation.robot.model.mass == pytest.approx(2.35)


def test_every_joint_origin_and_foot_is_where_forward_kinematics_says(simulation: assembly.Simulation) -> None:
    world, model = simulation.world.world, simulation.robot.model
    data = mujoco.MjData(world.model)
    rng = np.random.default_rng(1)
    for _ in range(20):
        angles = [rng.uniform(joint.lower, joint.upper) for joint in model.joints]
        data.qpos[:7] = 0, 0, 0, 1, 0, 0, 0
        data.qpos[7:] = angles
        mujoco.mj_kinematics(world.model, data)
        for leg in model.legs:
            points = chain_points(leg, angles[leg.span])
            for joint, point in zip(leg.joints, points, strict=False):
                assert data.body(joint.name).xpos == pytest.approx(point, abs=1e-9)
            assert data.geom(f"{leg.name}_foot").xpos == pytest.approx(points[-1], abs=1e-9)


def test_the_centre_of_mass_is_where_the_checks_think(simulation: assembly.Simulation) -> None:
    world, model = simulation.world.world, simulation.robot.model
    angles = resting_angles(model, model.heights.stand)
    data = mujoco.MjData(world.model)
    data.qpos[:7] = 0, 0, 0, 1, 0, 0, 0
    data.qpos[7:] = angles
    mujoco.mj_forward(world.model, data)
    # The last capsule is a foot's radius shorter than its link.
    assert centre_of_mass(model, angles) == pytest.approx(data.subtree_com[1], abs=2e-3)


def test_servos_bring_their_friction_and_armature_to_the_joints_that_carry_a_load() -> None:
    simulation = assembly.simulate("hexapod")
    with simulation.robot as robot:
        robot.stand()
        model = simulation.world.world.model
        knees = [model.joint(leg.joints[2].name).dofadr[0] for leg in simulation.robot.model.legs]
        assert model.dof_armature[knees] == pytest.approx(np.full(6, 0.010))
        assert model.dof_frictionloss[knees] == pytest.approx(np.full(6, 0.04))
        assert model.dof_damping[knees] == pytest.approx(np.full(6, 0.008))


@pytest.mark.parametrize(("rate", "steps"), [(100, 4), (200, 2), (150, 3), (400, 1), (500, 1), (50, 8), (30, 14)])
def test_a_tick_has_a_whole_number_of_steps_none_longer_than_2_5_ms(rate: int, steps: int) -> None:
    assert steps_per_tick(rate) == steps
    assert 1.0 / (rate * steps) <= 0.0025 + 1e-12


@pytest.mark.parametrize("rate", [100, 150, 200])
def test_physics_and_ticks_keep_pace_exactly(rate: int) -> None:
    simulation = assembly.simulate("hexapod", rate_hz=rate)
    steps: list[int] = []
    model = simulation.world.world.model
    with simulation.robot as robot:
        robot.observers.append(lambda tick: steps.append(round(simulation.world.truth().time / model.opt.timestep)))
        robot.stand()
        ticks = np.diff(steps)  # until here: a pause may take its time
    assert set(ticks) == {steps_per_tick(rate)}


def test_yaw_is_counted_on_past_a_whole_turn(simulation: assembly.Simulation) -> None:
    simulation = assembly.simulate("hexapod")
    world = simulation.world.world
    mujoco.mj_resetData(world.model, world.data)
    world.data.qpos[2] = 5.0
    world.data.qvel[5] = 30.0  # rad/s, spinning in free fall
    for index in range(200):
        world.step(index)
    assert world.truth().base.yaw == pytest.approx(15.0, rel=0.15)
    assert world.truth().base.yaw > 2.0 * math.pi


def test_a_limp_robot_stays_as_it_sits() -> None:
    """Dry friction holds the legs: half a minute later every joint is still 0.3 rad inside its limits."""
    simulation = assembly.simulate("hexapod")
    simulation.world.clock.wait((), 30_000_000_000)
    for joint, angle in zip(simulation.robot.model.joints, simulation.world.truth().joints, strict=True):
        assert joint.lower + 0.3 <= angle <= joint.upper - 0.3, joint.name
