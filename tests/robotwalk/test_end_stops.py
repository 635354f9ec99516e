"""A joint that is driven on by what nobody foresaw is held before its limit, on a drive of each bundled robot."""

import math

import pytest

from robotwalk import assembly
from robotwalk.end_stops import EndStops
from robotwalk.types import DriveResponse, JointState

DT = 0.01  # s, of a tick
FINE = 20  # steps of the physics in it
LOW, HIGH = -1.5, 1.5  # rad
GOALS_END = HIGH - math.radians(2.5)
DRIVE = DriveResponse(0.04, 0.002, 0.0, 6.0, stiffness=5.0, effort_torque=1.4)


def measured(position: float, speed: float = 0.0, *, valid: bool = True) -> JointState:
    return JointState((position,), (speed,), (0.0,), (valid,), (0.0,))


def driven(drive: DriveResponse, load: float, *, guarded: bool, seconds: float = 1.0) -> list[float]:
    """Return where one joint is that is sent to where goals end and bears `load` (N m, outwards) from 0.1 s on, rad.

    Its servo gives no more than it can. A goal made of what was measured arrives a tick later.
    """
    stops = EndStops([(LOW, HIGH)], [drive], DT)
    position, speed, goal, ahead = GOALS_END, 0.0, GOALS_END, GOALS_END
    most = drive.effort_torque
    places: list[float] = []
    for tick in range(round(seconds / DT)):
        goal, ahead = ahead, GOALS_END
        if guarded:
            ahead, = stops.step([GOALS_END], measured(position, speed), ())
        for _ in range(FINE):
            pull = min(max(drive.stiffness * (goal - position), -most), most)
            torque = pull + (load if tick * DT >= 0.1 else 0.0) - drive.stiffness * drive.damping * speed
            speed += torque / (drive.stiffness * drive.inertia) * DT / FINE
            position += speed * DT / FINE
        places.append(position)
    return places


@pytest.mark.parametrize("robot", ["hexapod", "quadruped", "hexapod_ax12", "hexapod_xl330"])
def test_a_load_that_would_push_a_joint_beyond_its_limit_is_borne_before_it(robot: str) -> None:
    drive = assembly.load(robot).drives[0]
    load = drive.stiffness * math.radians(4.5)  # the servo alone gives by so much
    assert driven(drive, load, guarded=False)[-1] > HIGH + math.radians(1.5)
    places = driven(drive, load, guarded=True)
    assert max(places) < HIGH
    # It comes to rest there, at a fourth of that, or half where the drive is so light that it would swing.
    settled = places[50:]
    assert max(settled) - min(settled) < math.radians(0.15)
    assert settled[-1] < GOALS_END + math.radians(4.5 / 2.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_goals_yield_inwards_only_and_only_near_the_end(side: float) -> None:
    stops = EndStops([(LOW, HIGH)], [DRIVE], DT)
    goals = [side * GOALS_END]
    assert stops.step(goals, measured(0.0, side * 3.0), ()) is goals
    assert stops.step(goals, measured(side * GOALS_END, -side * 3.0), ()) is goals
    late, = stops.step(goals, measured(side * (GOALS_END - 0.05), side * 3.0), ())
    assert 0.1 < side * (goals[0] - late) < 0.2
    beyond, = stops.step(goals, measured(side * (HIGH + 0.2)), ())
    assert side * (goals[0] - beyond) == pytest.approx(math.radians(20.0))
    # A failed read is no place, and what swings back is not slowed down.
    assert stops.step(goals, measured(side * HIGH, valid=False), ()) is goals
    assert stops.step(goals, measured(side * HIGH, -side * 5.0), ()) == stops.step(goals, measured(side * HIGH), ())


def test_a_joint_that_is_found_beyond_its_limit_does_not_leap_and_the_wall_follows_it_in() -> None:
    for taken_over in (True, False):
        stops = EndStops([(LOW, HIGH)], [DRIVE], DT)
        reseeded = () if taken_over else (0,)
        if taken_over:
            stops.reset((HIGH + 0.08,))
        held = [HIGH + 0.08]
        assert stops.step(held, measured(HIGH + 0.08), reseeded) is held
        assert stops.step(held, measured(HIGH), ()) is held
        back, = stops.step(held, measured(HIGH + 0.02), ())
        assert held[0] - back == pytest.approx(3.0 * 0.02)
        assert stops.step(held, measured(0.5), ()) is held
        assert stops.step(held, measured(HIGH), ())[0] == pytest.approx(held[0] - 3.0 * math.radians(2.5))
