"""Goals that undo how a servo follows."""

import math

import pytest

from robotwalk.feedforward import Feedforward
from robotwalk.types import DriveResponse

DT, FINE = 0.01, 100
DRIVE = DriveResponse(damping=0.05, inertia=0.0008, friction=0.0, max_speed=6.0)


def least_jerk(seconds: float) -> float:
    u = min(seconds / 0.5, 1.0)
    return 0.8 * u**3 * (10.0 - 15.0 * u + 6.0 * u * u)


def largest_error(feedforward: bool) -> float:
    """Move a joint by 0.8 rad in 0.5 s; the servo holds each goal for a tick."""
    forward = Feedforward([DRIVE])
    forward.reset([0.0])
    q = speed = worst = 0.0
    for tick in range(100):
        wanted = least_jerk(tick * DT)
        goal = forward.step([wanted], [0.0], DT)[0] if feedforward else wanted
        for fine in range(FINE):
            speed += (goal - q - DRIVE.damping * speed) / DRIVE.inertia * DT / FINE
            q += speed * DT / FINE
            worst = max(worst, abs(q - least_jerk(tick * DT + (fine + 1) * DT / FINE)))
    return worst


def test_a_servo_follows_much_closer_with_it() -> None:
    # Without, the joint lags by damping x speed: 0.05 s x 3 rad/s. With it, what is left is the tick itself.
    assert largest_error(feedforward=False) > 0.13
    assert largest_error(feedforward=True) < 0.04


def test_the_goal_leads_by_damping_and_inertia() -> None:
    forward = Feedforward([DRIVE, DriveResponse(0.0, 0.0, 0.0, 6.0)])
    forward.reset([0.1, 0.2])
    assert forward.step([0.1, 0.2], [0.0, 0.0], DT) == pytest.approx([0.1, 0.2])
    # From rest to 1 rad/s in one tick: 0.05 s x 1 rad/s and 0.0008 s^2 x 100 rad/s^2 ahead.
    assert forward.step([0.11, 0.21], [0.0, 0.0], DT) == pytest.approx([0.11 + 0.05 + 0.08, 0.21])
    assert forward.step([0.12, 0.22], [0.0, 0.0], DT) == pytest.approx([0.12 + 0.05, 0.22])
    assert forward.step([0.12, 0.22], [0.0, 0.0], DT) == pytest.approx([0.12 - 0.08, 0.22])
    assert forward.step([0.12, 0.22], [0.0, 0.0], DT) == pytest.approx([0.12, 0.22])


def test_the_goal_leads_by_friction_in_the_direction_of_motion_and_not_at_rest() -> None:
    forward = Feedforward([DriveResponse(0.0, 0.0, 0.02, 6.0)])
    forward.reset([0.0])
    assert [forward.step([q], [0.0], DT)[0] for q in (0.01, 0.0, 0.0)] == pytest.approx([0.01 + 0.02, -0.02, 0.0])
    # Slower than 0.1 rad/s, a share of it: there is no step as a joint starts or turns back.
    assert forward.step([0.0005], [0.0], DT)[0] == pytest.approx(0.0005 + 0.5 * 0.02)


def test_reset_forgets_the_motion_before() -> None:
    forward = Feedforward([DRIVE])
    forward.reset([0.0])
    forward.step([math.pi], [0.0], DT)
    forward.reset([1.0])
    assert forward.step([1.0], [0.0], DT) == [1.0]


def test_the_goal_leads_by_what_the_joint_bears() -> None:
    forward = Feedforward([DRIVE._replace(stiffness=5.0), DRIVE])  # the second is as stiff as can be
    forward.reset([0.1, 0.1])
    assert forward.step([0.1, 0.1], [0.3, 0.3], DT) == pytest.approx([0.16, 0.1])


def test_lag_and_load_are_left_alone_where_a_robots_file_says_so() -> None:
    drive = DRIVE._replace(friction=0.01, stiffness=8.0)

    def goal(**systems: bool) -> float:
        forward = Feedforward([drive], **systems)
        forward.reset([0.0])
        return forward.step([0.01], [0.4], DT)[0]

    lag, load = 0.05 * 1.0 + 0.0008 * 100.0 + 0.01, 0.05
    assert goal() == pytest.approx(0.01 + lag + load)
    assert goal(lag=False) == pytest.approx(0.01 + load)
    assert goal(load=False) == pytest.approx(0.01 + lag)
    assert goal(lag=False, load=False) == pytest.approx(0.01)
