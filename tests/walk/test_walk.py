"""The hexapod walks in MuJoCo through real servo bytes, judged by what its body really does."""

import math
from functools import partial
from typing import Any

import pytest

from . import rig

walk = partial(rig.walk, "hexapod")


def assert_sound(report: dict[str, Any]) -> None:
    rig.assert_sound(report, tilt_deg=4.0)


@pytest.mark.parametrize(("degrees", "tolerance"), [(0, 0.10), (180, 0.10), (90, 0.12), (-45, 0.12)])
def test_tripod_walks_a_metre_in_any_direction(degrees: float, tolerance: float) -> None:
    report = walk(speed=0.10, direction=math.radians(degrees))
    assert_sound(report)
    assert report["gait"] == "tripod"
    assert report["distance_m"] == pytest.approx(1.0, rel=tolerance)
    assert abs(report["lateral_drift_m"]) < 0.05
    assert abs(report["heading_change_deg"]) < 3.0
    assert report["odometry"]["distance_m"] == pytest.approx(report["distance_m"], rel=0.05)
    states = [event["text"] for event in report["events"] if event["kind"] == "state"]
    assert states == ["ready", "stand", "walk", "stand", "sit", "stop"]
    assert "limits" not in [event["kind"] for event in report["events"]], "no goal is cut"


@pytest.mark.parametrize(("gait", "speed"), [("ripple", 0.08), ("wave", 0.04)])
def test_the_other_gaits_hold_their_speed(gait: str, speed: float) -> None:
    report = walk(speed=speed, gait=gait)
    assert_sound(report)
    assert report["distance_m"] == pytest.approx(10.0 * speed, rel=0.10)
    assert abs(report["lateral_drift_m"]) < 0.05


def test_turning_on_the_spot() -> None:
    report = walk(turn=math.radians(20), duration=9.0)
    assert_sound(report)
    assert report["heading_change_deg"] == pytest.approx(180.0, rel=0.10)
    assert math.hypot(report["displacement"]["x"], report["displacement"]["y"]) < 0.03


def test_an_arc_closes_a_circle_of_the_right_radius() -> None:
    report = walk(speed=0.06, turn=math.radians(15), duration=24.0)
    assert_sound(report)
    assert report["heading_change_deg"] == pytest.approx(360.0, rel=0.05)
    radius = report["distance_m"] / math.radians(report["heading_change_deg"])
    assert radius == pytest.approx(0.06 / math.radians(15), rel=0.10)
    assert math.hypot(report["displacement"]["x"], report["displacement"]["y"]) < 0.05
    assert report["lateral_drift_m"] is None


def test_a_heading_is_turned_to_and_walked_along() -> None:
    report = walk(speed=0.06, heading=math.radians(60), duration=20.0)
    assert_sound(report)
    assert report["heading_change_deg"] == pytest.approx(60.0, abs=3.0)
    # It turns while it walks, so the course bends; past the turn it runs at 60 degrees.
    assert report["displacement"]["y"] > 0.8
    assert report["distance_m"] == pytest.approx(1.2, rel=0.10)


def test_the_height_is_kept_as_told() -> None:
    low, high = walk(speed=0.05, height=0.095, duration=4.0), walk(speed=0.05, height=0.125, duration=4.0)
    assert_sound(low)
    assert_sound(high)
    # The legs give under the load by up to a centimetre.
    assert 0.080 < low["min_height_m"] < 0.098
    assert high["displacement"]["z"] > low["displacement"]["z"] + 0.02


@pytest.mark.parametrize("rate_hz", [50, 150, 200])
def test_it_walks_at_other_rates(rate_hz: int) -> None:
    report = walk(speed=0.10, duration=5.0, rate_hz=rate_hz)
    assert_sound(report)
    assert report["distance_m"] == pytest.approx(0.5, rel=0.10)


def test_equal_seeds_give_equal_runs_and_others_do_not() -> None:
    first, again, other = (walk(speed=0.10, duration=2.0, seed=seed) for seed in (3, 3, 4))
    assert first["state_hash"] == again["state_hash"]
    assert first["distance_m"] == again["distance_m"]
    assert first["state_hash"] != other["state_hash"]


def test_a_speed_out_of_reach_is_scaled_as_a_whole_and_said() -> None:
    report = walk(speed=0.9, direction=math.radians(-45), duration=3.0)
    assert_sound(report)
    commanded = report["commanded"]
    assert commanded["vy"] == pytest.approx(-commanded["vx"])
    assert math.hypot(commanded["vx"], commanded["vy"]) == pytest.approx(0.25)
    assert "scaled" in [event["kind"] for event in report["events"]]
