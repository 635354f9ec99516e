"""Every gait of the library on the robots that it fits walks at its speed, judged by what the body really does.

Those that have tests of their own (tripod, tetrapod of eight, trot, crawl) are left out.
"""

import math

import pytest

from . import rig

# What is asked of the quadruped, whose gaits are balanced only by their motion, and of the others.
OFF = {"quadruped": 0.18}
ELSE_OFF = 0.12


@pytest.mark.parametrize(("robot", "gait", "speed", "direction", "tilt"), [
    ("hexapod", "tetrapod", 0.08, 0.0, 2.0),
    ("hexapod", "stroll", 0.08, 0.0, 2.0),
    ("octopod", "ripple", 0.05, 0.0, 1.0),
    ("pentapod", "wave", 0.04, 0.0, 1.0),
    ("pentapod", "wave", 0.04, 90.0, 1.0),
    ("quadruped", "wave", 0.04, 0.0, 4.0),
    ("quadruped", "amble", 0.08, 0.0, 6.0),
    ("quadruped", "pace", 0.08, 0.0, 9.0),
])
def test_it_walks_at_the_speed_that_is_asked_for(
    robot: str, gait: str, speed: float, direction: float, tilt: float
) -> None:
    report = rig.walk(robot, gait=gait, speed=speed, direction=math.radians(direction), duration=7.0)
    rig.assert_sound(report, tilt_deg=tilt)
    assert report["distance_m"] == pytest.approx(speed * report["duration_s"], rel=OFF.get(robot, ELSE_OFF))
    assert abs(report["lateral_drift_m"]) < 0.03
    assert abs(report["heading_change_deg"]) < 5.0
    cuts = [event["text"] for event in report["events"] if event["kind"] == "limits"]
    assert not any("position" in text for text in cuts)
