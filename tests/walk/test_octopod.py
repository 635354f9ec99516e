"""The octopod walks in MuJoCo on two buses at once, judged by what its body really does."""

import math
from functools import partial
from itertools import pairwise
from typing import Any

import pytest

from robotwalk import assembly

from . import rig

walk = partial(rig.walk, "octopod")


def assert_sound(report: dict[str, Any]) -> None:
    rig.assert_sound(report, tilt_deg=1.0)


@pytest.mark.parametrize("degrees", [0, 180, 90, -45])
def test_it_walks_in_any_direction_by_alternating_tetrapods_if_nothing_is_said(degrees: float) -> None:
    report = walk(speed=0.08, direction=math.radians(degrees), duration=10.0 if degrees == 0 else 5.0)
    assert_sound(report)
    assert report["gait"] == "tetrapod"
    assert report["distance_m"] == pytest.approx(0.08 * report["duration_s"], rel=0.06)
    assert abs(report["lateral_drift_m"]) < 0.02
    assert abs(report["heading_change_deg"]) < 2.0
    assert "limits" not in [event["kind"] for event in report["events"]]


def test_neighbours_and_partners_across_the_body_swing_in_turn() -> None:
    blueprint = assembly.load("octopod")
    legs, gait = [leg.name for leg in blueprint.model.legs], blueprint.gaits["tetrapod"]
    sides = [[legs.index(f"{side}{place}") for place in ("f", "mf", "mr", "r")] for side in "lr"]
    for pair in [*zip(*sides, strict=True), *(near for side in sides for near in pairwise(side))]:
        assert not gait.lifts_together(set(pair))
    assert {sum(support.standing) for support in gait.supports} == {4}


def test_it_turns_on_the_spot() -> None:
    report = walk(turn=-rig.TURN, duration=4.5)
    assert_sound(report)
    assert report["heading_change_deg"] == pytest.approx(-90.0, rel=0.04)
    assert math.hypot(report["displacement"]["x"], report["displacement"]["y"]) < 0.01


def test_it_walks_by_a_wave_of_its_own_eight_feet() -> None:
    report = walk(speed=0.02, gait="wave", duration=8.0)
    assert_sound(report)
    assert report["distance_m"] == pytest.approx(0.16, rel=0.10)


def test_two_buses_take_no_longer_than_one() -> None:
    """Both carry the same bytes, at the same time: an exchange lasts as long as the wire time of one."""
    report = walk(speed=0.08, duration=0.5)
    left, right = assembly.bus_loads(assembly.load("octopod"), 100)
    assert (left.servos, right.servos) == (12, 12)
    assert report["bus"]["left"] == report["bus"]["right"]
    assert report["timing"]["bus_us"]["p50"] == pytest.approx(1e6 * left.wire_s, rel=0.05)
