"""Whether a robot fell, by what its motors push: on its feet, on its back, in a hand; and what is not believed."""

from collections.abc import Sequence

import pytest

from robotwalk import assembly
from robotwalk.config.safety import FallConfig
from robotwalk.controller import NOTHING_WANTED, Wanted
from robotwalk.falls import FallWatch
from robotwalk.kinematics import resting_angles
from robotwalk.statics import GRAVITY, LegMasses, LegStatics
from robotwalk.types import UP, JointState, Vec3

DT = 0.01  # s
DOWN = Vec3(0.0, 0.0, -1.0)


class Robot:
    """One that stands at rest; what its feet bear, and which way gravity pulls, is made up."""

    def __init__(self, name: str = "hexapod", height: float | None = None) -> None:
        blueprint = assembly.load(name)
        self.model, self.drives = blueprint.model, blueprint.drives
        self.watch = FallWatch(self.model, self.drives, FallConfig(), DT)
        self.angles = resting_angles(self.model, height or self.model.heights.stand)
        self.wanted = self._wanted()
        self.weight = self.model.mass * GRAVITY

    def _wanted(self) -> Wanted:
        legs = tuple(self._masses(self.angles, UP))
        return NOTHING_WANTED._replace(legs=legs, torques=[0.5] * len(self.angles))

    def _masses(self, angles: Sequence[float], up: Vec3) -> list[LegStatics]:
        return [LegMasses(leg, self.model.foot_mass).statics(angles[leg.span], up)[0] for leg in self.model.legs]

    def joints(self, loads: Sequence[float], up: Vec3 = UP, *, told: float = 1.0, valid: bool = True) -> JointState:
        """Return them, bearing these loads (N) and their own weight; told is what they tell of it."""
        efforts: list[float] = []
        for leg, statics, load in zip(self.model.legs, self._masses(self.angles, up), loads, strict=True):
            efforts += [
                told * (weight - load * lift) / drive.effort_torque
                for weight, lift, drive in zip(statics.weights, statics.lifts, self.drives[leg.span], strict=True)]
        count = len(efforts)
        return JointState(tuple(self.angles), (0.0,) * count, tuple(efforts), (valid,) * count, (0.0,) * count)

    def told_within(self, seconds: float, joints: JointState, *, up: bool = True) -> float | None:
        """Return after how long a fall was told, s."""
        for tick in range(round(seconds / DT)):
            if self.watch.step(None, joints, self.wanted, up=up) is not None:
                return tick * DT
        return None


@pytest.fixture
def robot() -> Robot:
    return Robot()


def on_three(robot: Robot) -> JointState:
    """Stand on the legs lf, rm and lr, whatever the controller believes."""
    return robot.joints([robot.weight / 3 if leg.name in ("lf", "rm", "lr") else 0.0 for leg in robot.model.legs])


def test_whichever_legs_bear_it_a_robot_on_its_feet_has_not_fallen(robot: Robot) -> None:
    assert robot.told_within(5.0, on_three(robot)) is None
    assert robot.told_within(5.0, robot.joints([robot.weight / 6] * 6)) is None
    assert robot.told_within(5.0, robot.joints([0.55 * robot.weight / 6] * 6)) is None, "friction hides some"


@pytest.mark.parametrize("up", [DOWN, Vec3(0.0, 1.0, 0.0), Vec3(1.0, 0.0, 0.0), UP])
def test_one_on_its_back_side_or_rear_or_in_a_hand_has(robot: Robot, up: Vec3) -> None:
    robot.told_within(2.0, on_three(robot))
    told = robot.told_within(4.0, robot.joints([0.0] * 6, up))
    assert told is not None
    assert told > 0.8, "not by a jolt"


def test_a_robot_that_should_lie_has_not_fallen(robot: Robot) -> None:
    robot.told_within(2.0, on_three(robot))
    assert robot.told_within(5.0, robot.joints([0.0] * 6), up=False) is None


def test_servos_that_tell_nothing_of_their_load_feign_no_fall(robot: Robot) -> None:
    assert robot.told_within(8.0, robot.joints([robot.weight / 6] * 6, told=0.0)) is None
    assert robot.told_within(8.0, robot.joints([robot.weight / 6] * 6, told=-1.0)) is None


def test_what_was_not_heard_is_not_believed(robot: Robot) -> None:
    robot.told_within(2.0, on_three(robot))
    assert robot.told_within(8.0, robot.joints([0.0] * 6, valid=False)) is None


def test_a_leg_that_is_out_is_no_leg_to_be_felt(robot: Robot) -> None:
    robot.told_within(2.0, on_three(robot))
    robot.watch.spare({0, 1, 2})
    robot.wanted = robot.wanted._replace(legs=robot.wanted.legs[1:])
    assert robot.told_within(5.0, robot.joints([0.0] + [robot.weight / 5] * 5)) is None
    assert robot.told_within(4.0, robot.joints([robot.weight] + [0.0] * 5)) is not None


def test_legs_so_straight_that_motors_bear_nothing_feign_no_fall() -> None:
    robot = Robot("quadruped", height=0.207)
    robot.told_within(2.0, robot.joints([robot.weight / 4] * 4))
    assert robot.told_within(8.0, robot.joints([0.0] * 4, DOWN)) is None
