"""The small hexapod walks in MuJoCo on four buses at once, judged by what its body really does."""

import math
from functools import partial
from typing import Any

import pytest

from robotwalk import assembly

from . import rig

walk = partial(rig.walk, "hexapod_xl330")


def assert_sound(report: dict[str, Any]) -> None:
    rig.assert_sound(report, tilt_deg=3.0)


@pytest.mark.parametrize("degrees", [0, 90, -135])
def test_its_soft_servos_hold_the_speed_in_any_direction(degrees: float) -> None:
    """Without the feed-forward of friction it comes a sixth short."""
    report = walk(speed=0.05, direction=math.radians(degrees), duration=5.0)
    assert_sound(report)
    assert report["gait"] == "tripod"
    assert report["distance_m"] == pytest.approx(0.25, rel=0.08)
    assert abs(report["lateral_drift_m"]) < 0.02
    assert abs(report["heading_change_deg"]) < 3.0


def test_it_turns_on_the_spot() -> None:
    report = walk(turn=rig.TURN, duration=4.5)
    assert_sound(report)
    assert report["heading_change_deg"] == pytest.approx(90.0, rel=0.05)


def test_four_buses_take_no_longer_than_the_longest() -> None:
    report = walk(speed=0.05, duration=0.5)
    loads = assembly.bus_loads(assembly.load("hexapod_xl330"), 100)
    assert [(load.servos, load.baud) for load in loads] == [(n, 4_000_000) for n in (6, 6, 3, 3)]
    assert report["timing"]["bus_us"]["p50"] == pytest.approx(1e6 * max(load.wire_s for load in loads), rel=0.05)
