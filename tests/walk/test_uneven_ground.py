"""The quadruped crawls over ground that is not level, without an IMU: its feet tell which way is down."""

import math

from robotwalk.testing import FakeRobot

from . import rig


def test_up_a_ramp_it_keeps_its_body_level() -> None:
    with FakeRobot("quadruped", terrain="ramp_8") as fake:
        pitches: list[float] = []
        fake.robot.stand()
        fake.robot.observers.append(lambda tick: pitches.append(math.degrees(fake.base.pitch)))
        fake.robot.walk(vx=0.04, seconds=15.0, gait="crawl")
        assert fake.base.x > 0.9 * 0.6
        assert fake.base.z > 0.18  # all feet are on it
        assert not fake.fell
    assert max(map(abs, pitches)) < 6.0  # 11 blind: 8 of the ramp, and it tips off its rear feet
    assert abs(sum(pitches[-300:]) / 300.0) < 3.0


def test_on_uneven_ground_all_its_feet_bear() -> None:
    report = rig.walk("quadruped", terrain="rough_15", speed=0.04, duration=25.0, gait="crawl", seed=7)
    assert not report["fell"]
    assert report["distance_m"] > 0.9 * 1.0
    assert report["max_tilt_deg"] < 6.5  # 8.2 while a foot that came down on a rise pressed on, and tipped the body


def test_turning_on_flat_ground_it_feels_no_ground_that_is_not_there() -> None:
    report = rig.walk("quadruped", turn=-rig.TURN, duration=9.0, gait="crawl")
    rig.assert_sound(report, tilt_deg=4.0)
    assert report["heading_change_deg"] < -0.85 * 180.0
