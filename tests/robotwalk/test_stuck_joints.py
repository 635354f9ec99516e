"""What tells a joint that is held fast from one that lags, bears a load, or is not heard."""

import math

import pytest

from robotwalk.stuck_joints import StuckJoints
from robotwalk.types import DriveResponse, JointState

DT = 0.01  # s
DRIVE = DriveResponse(damping=0.044, inertia=0.0019, friction=0.0075, max_speed=5.5, stiffness=5.3)


def found(*, period: float, swing: float = 0.4, speed: float = 2.0, held: bool = False, load: float = 0.0,
          heard: bool = True) -> float | None:
    """Send a joint to and fro once a period, as a leg swings; return after how long it is taken for stuck, if it is.

    Its servo is slow: a third as fast as its data sheet says.
    """
    watch, here, pace, age = StuckJoints([DRIVE], DT), 0.0, 0.0, 0.0
    for tick in range(round(12.0 / DT)):
        phase = tick * DT % period / 0.25
        wanted = swing * math.sin(math.pi * phase) ** 2 if phase < 1.0 else 0.0
        rate = swing * math.pi / 0.25 * math.sin(2.0 * math.pi * phase) if phase < 1.0 else 0.0
        torque = load * math.sin(math.tau * tick * DT / period)
        goal = wanted + DRIVE.damping * rate + torque / DRIVE.stiffness
        if not held:
            for _ in range(10):
                push = (wanted + DRIVE.damping * rate - here - DRIVE.damping * pace) / DRIVE.inertia
                pace = max(-speed, min(pace + push * DT / 10, speed))
                here += pace * DT / 10
        age = 0.0 if heard else age + DT
        if watch.step([goal], [torque], JointState((here,), (0.0,), (0.0,), (heard,), (age,))):
            return tick * DT
    return None


@pytest.mark.parametrize("period", [0.5, 0.72, 0.8, 2.0, 4.0])  # 0.72 s: it once was sampled at the same phase always
def test_a_joint_that_is_held_is_found_and_one_that_lags_is_not(period: float) -> None:
    assert found(period=period) is None
    assert found(period=period, speed=0.4) is None
    after = found(period=period, held=True)
    assert after is not None
    assert after < period + 1.0


def test_a_joint_that_is_to_stand_still_is_not_stuck() -> None:
    assert found(period=1.0, swing=0.0, load=2.0, held=True) is None  # its goals go to and fro by 0.75 rad
    assert found(period=1.0, swing=0.1, held=True) is None


def test_a_joint_that_is_not_heard_is_not_stuck() -> None:
    assert found(period=0.5, held=True, heard=False) is None
