"""The tilt that a body's weight on its feet tells, against the tilt that the loads were reckoned for."""

import math

import pytest

from robotwalk import assembly
from robotwalk.contact import Felt
from robotwalk.kinematics import resting_angles
from robotwalk.statics import GRAVITY, shared_loads, up_in_base
from robotwalk.support import Masses
from robotwalk.tilt_by_load import TiltByLoad
from robotwalk.types import LEVEL, Tilt, Vec3

DT = 0.01


class Standing:
    """A quadruped that stands at rest on a slope, its feet's loads balanced."""

    def __init__(self) -> None:
        self.model = assembly.load("quadruped").model
        self.plumb = TiltByLoad(self.model)
        self.centre, self.feet = Masses(self.model).centre_and_feet(
            resting_angles(self.model, self.model.heights.stand))

    def settle(self, tilt: Tilt, told: Tilt, seconds: float, *, deaf: bool = False) -> Tilt:
        up = up_in_base(tilt.roll, tilt.pitch)
        ground = [foot._replace(z=foot.z - self.model.foot_radius) for foot in self.feet]  # that lies as the body does
        loads = shared_loads(ground, [1.0] * 4, self.centre, self.model.mass * GRAVITY, up)
        felt = [Felt(Vec3(load * up.x, load * up.y, load * up.z), load, touching=True, sure=True) for load in loads]
        pose = LEVEL._replace(roll=told.roll, pitch=told.pitch)
        for _ in range(round(seconds / DT)):
            found = self.plumb.step([None, *felt[1:]] if deaf else felt, self.feet, self.centre, pose, DT)
        return found


@pytest.mark.parametrize("roll", [-6.0, 0.0, 8.0])
@pytest.mark.parametrize("pitch", [-8.0, 0.0, 5.0])
def test_the_tilt_is_found_by_the_loads(roll: float, pitch: float) -> None:
    tilt = Tilt(math.radians(roll), math.radians(pitch))
    assert Standing().settle(tilt, Tilt(0.0, 0.0), 8.0) == pytest.approx(tilt, abs=math.radians(0.6))


def test_what_the_body_is_told_is_known_at_once_and_nothing_is_learnt_from_feet_that_do_not_tell() -> None:
    body = Standing()
    slope = Tilt(0.0, math.radians(-8.0))
    before = body.settle(slope, Tilt(0.0, 0.0), 8.0)
    told = Tilt(math.radians(2.0), math.radians(6.0))
    assert body.settle(Tilt(0.0, 0.0), told, DT, deaf=True) == pytest.approx(
        (before.roll + told.roll, before.pitch + told.pitch))
