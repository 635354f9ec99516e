"""From the speed that is asked for to the speed that robot and gait can do."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotwalk.gait import Gait
from robotwalk.model import RobotModel
from robotwalk.types import STILL, Command, Twist
from robotwalk.velocity import VelocityShaper, feasible

from .conftest import PerfectRobot

DT = 0.01
ACCELERATION, TURN_ACCELERATION = 0.3, math.radians(120.0)  # of the hexapod

twists = st.builds(Twist, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-3.0, 3.0))
gait_names = st.sampled_from(["tripod", "ripple", "wave"])


@given(twists, gait_names)
def test_scaling_keeps_the_direction_and_the_arcs_radius(
    hexapod: RobotModel, gaits: dict[str, Gait], wanted: Twist, name: str
) -> None:
    twist, scale = feasible(wanted, hexapod.motion, gaits[name])
    assert 0.0 < scale <= 1.0
    assert twist == pytest.approx(tuple(scale * component for component in wanted))


@given(twists, gait_names)
def test_what_is_feasible_is_within_all_limits(
    hexapod: RobotModel, gaits: dict[str, Gait], wanted: Twist, name: str
) -> None:
    gait = gaits[name]
    twist, _ = feasible(wanted, hexapod.motion, gait)
    assert math.hypot(twist.vx, twist.vy) <= 0.25 + 1e-9
    assert abs(twist.wz) <= math.radians(60.0) + 1e-9
    strides = [
        speed * gait.period(twist) * stance
        for speed, stance in zip(gait.foot_speeds(twist), gait.longest_stance, strict=True)
    ]
    assert max(strides) <= 0.1 + 1e-9


def test_what_can_be_done_is_not_changed(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    for wanted in (STILL, Twist(0.1, 0.05, 0.2), Twist(-0.249, 0.0, 0.0), Twist(0.0, 0.0, 1.04)):
        assert feasible(wanted, hexapod.motion, gaits["tripod"]) == (wanted, 1.0)


def test_each_limit_cuts(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    twist, scale = feasible(Twist(0.3, 0.4, 0.0), hexapod.motion, gaits["tripod"])
    assert (*twist, scale) == pytest.approx((0.15, 0.2, 0.0, 0.5))  # 0.25 m/s at most
    twist, scale = feasible(Twist(0.0, 0.0, -2.0), hexapod.motion, gaits["tripod"])
    assert (twist.wz, scale) == pytest.approx((-1.047198, 0.523599))  # 60 deg/s at most
    twist, _ = feasible(Twist(0.2, 0.0, 0.0), hexapod.motion, gaits["wave"])
    assert 0.06 < twist.vx <= 0.06667  # 100 mm in the 1.5 s that five other swings take


@given(st.lists(st.tuples(twists, st.integers(1, 60)), min_size=1, max_size=6), st.sampled_from([0.01, 0.02, 0.004]))
def test_accelerations_are_bounded_whatever_is_asked_for(
    hexapod: RobotModel, gaits: dict[str, Gait], script: list[tuple[Twist, int]], dt: float
) -> None:
    shaper = VelocityShaper(hexapod.motion)
    for wanted, ticks in script:
        for _ in range(ticks):
            before = shaper.twist
            twist = shaper.step(wanted, gaits["tripod"], dt).twist
            assert math.hypot(twist.vx - before.vx, twist.vy - before.vy) <= ACCELERATION * dt * (1.0 + 1e-9)
            assert abs(twist.wz - before.wz) <= TURN_ACCELERATION * dt * (1.0 + 1e-9)


def test_a_start_takes_its_time_and_goes_straight(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    shaper = VelocityShaper(hexapod.motion)
    for _ in range(33):
        twist = shaper.step(Twist(0.08, -0.06, 0.1), gaits["tripod"], DT).twist
        assert twist.vy == pytest.approx(-0.75 * twist.vx)
        assert twist.wz == pytest.approx(1.25 * twist.vx)
    assert math.hypot(twist.vx, twist.vy) == pytest.approx(0.099)
    assert shaper.step(Twist(0.08, -0.06, 0.1), gaits["tripod"], DT).twist == Twist(0.08, -0.06, 0.1)


def test_the_slower_axis_sets_the_pace(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    shaper = VelocityShaper(hexapod.motion)
    twist = shaper.step(Twist(0.01, 0.0, 1.0), gaits["tripod"], DT).twist
    assert twist == pytest.approx((0.01 * TURN_ACCELERATION * DT, 0.0, TURN_ACCELERATION * DT))


def test_a_stop_ends_in_stillness_itself(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    shaper = VelocityShaper(hexapod.motion)
    for _ in range(100):
        shaper.step(Twist(0.1, 0.1, 0.3), gaits["tripod"], DT)
    for _ in range(100):
        shaper.step(STILL, gaits["tripod"], DT)
    assert shaper.twist == STILL


def test_another_gait_has_another_top_speed(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    shaper, wanted = VelocityShaper(hexapod.motion), Twist(0.2, 0.0, 0.0)
    assert shaper.step(wanted, gaits["tripod"], DT).scale == 1.0
    assert shaper.step(wanted, gaits["wave"], DT).scale < 0.34
    assert shaper.step(Twist(0.02, 0.0, 0.0), gaits["wave"], DT).scale == 1.0


def test_feet_that_cannot_follow_hold_it_back(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    shaper = VelocityShaper(hexapod.motion)
    for _ in range(200):
        shaped = shaper.step(Twist(0.2, 0.0, 0.2), gaits["tripod"], DT, 0.25)
    assert shaped.twist == pytest.approx((0.05, 0.0, 0.05))
    assert shaped.scale == 1.0


def test_the_speed_changes_only_while_a_foot_pushes(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    """In tripod: in the second half of each half turn (PPS section 4); what slows the body down waits for nothing."""
    robot = PerfectRobot(hexapod, gaits)
    robot.walk(Command(Twist(0.05, 0.0, 0.0)), 2.0)
    robot.command = Command(Twist(0.2, 0.0, 0.0))
    robot.tick()  # the needle has just passed a touchdown, which is seen in the next tick
    before, changed = robot.tick().wanted.twist.vx, set()
    for frame in robot.run(4.0):
        if frame.wanted.twist.vx > before:
            changed.add(robot.controller._clock.phase % 0.5)
        before = frame.wanted.twist.vx
    assert before > 0.18
    assert changed
    assert all(phase > 0.24 or phase < 0.02 for phase in changed)
    stopping = []
    for _ in range(50):  # at every phase of half a turn
        robot.walk(Command(Twist(0.1, 0.0, 0.0)), 2.01)
        robot.command = Command()
        stopping.append(robot.tick().wanted.twist.vx)
    assert max(stopping) < 0.0999


def test_a_robot_sets_off_at_once(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    robot = PerfectRobot(hexapod, gaits)
    robot.walk(Command(), 0.1)
    frames = robot.walk(Command(Twist(0.1, 0.0, 0.0)), 0.4)
    assert frames[-1].wanted.twist.vx == pytest.approx(0.1)
