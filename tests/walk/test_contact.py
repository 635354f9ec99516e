"""The hexapod feels the ground and walks over it, judged by what its body really does."""

from functools import partial
from pathlib import Path

import pytest

from robotwalk import assembly
from robotwalk.testing import FakeRobot

from . import contact_rig, rig

walk = partial(rig.walk, "hexapod")


@pytest.mark.parametrize("supply_v", [None, 8.0])  # None: the servos' rated 11.1 V
def test_touchdowns_are_felt_soon_and_hardly_any_that_are_none(supply_v: float | None) -> None:
    figures = contact_rig.measure("hexapod", "rough_30", speed=0.06, seconds=8.0, supply_v=supply_v)
    assert figures.touchdowns >= 20
    assert figures.delay_ms <= 40.0
    assert figures.missed <= 0.2 * figures.touchdowns
    assert figures.false <= 0.1 * figures.touchdowns


def test_up_a_ramp_the_body_takes_on_its_share_of_the_slope() -> None:
    report = walk(terrain="ramp_15", speed=0.06, duration=15.0)
    assert not report["fell"]
    assert report["distance_m"] > 0.85 * 0.9
    assert 0.6 * 15.0 - 3.0 < report["max_tilt_deg"] < 0.6 * 15.0 + 3.0


def test_it_climbs_stairs_that_a_blind_tripod_does_not() -> None:
    report = walk(terrain="stairs_40", speed=0.06, duration=16.0)
    assert not report["fell"]
    assert report["distance_m"] > 0.85 * 0.96
    assert report["max_tilt_deg"] < 15.0
    assert abs(report["heading_change_deg"]) < 15.0


@pytest.mark.parametrize("lead_mm", [159, 162, 187])  # a foot comes down on the corner, beyond it, or creeps off it
def test_it_stops_at_a_precipice_and_stands(lead_mm: int, tmp_path: Path) -> None:
    edge = (lead_mm + 120) * 1e-3  # the body's front is 0.12 m ahead of its middle
    path = tmp_path / "edge.yaml"
    path.write_text(
        f"schema: 1\nname: edge\ndescription: 0.5 m\nlead_mm: {lead_mm}\ncourse:\n"
        "  - {element: drop, depth_mm: 500}\n  - {element: level, length_mm: 1000}\n")
    simulation = assembly.simulate("hexapod", terrain=str(path))
    with simulation.robot as robot:
        robot.stand()
        robot.walk(vx=0.06, seconds=19.0)
        assert [event.kind for event in robot.events].count("edge") == 1
        truth = simulation.world.truth()
        assert max(abs(truth.base.roll), abs(truth.base.pitch)) < 0.06
        assert truth.base.x < edge - 0.1
        assert truth.base.z > 0.09
        robot.walk(vx=-0.06, seconds=2.0)  # there is ground that way
        assert simulation.world.truth().base.x < truth.base.x - 0.05


def test_it_goes_down_an_edge_of_five_centimetres() -> None:
    report = walk(terrain="drop_50", speed=0.06, duration=14.0)
    assert not report["fell"]
    assert not any(event["kind"] == "edge" for event in report["events"])
    assert report["displacement"]["z"] == pytest.approx(-0.05, abs=0.02)


def test_far_below_where_it_began_its_body_does_not_sag(tmp_path: Path) -> None:
    path = tmp_path / "down.yaml"
    edge = "  - {element: drop, depth_mm: 35}\n  - {element: level, length_mm: 150}\n"
    path.write_text(f"schema: 1\nname: down\ndescription: three edges of 35 mm\ncourse:\n{3 * edge}")
    with FakeRobot("hexapod", terrain=str(path)) as fake:
        fake.robot.stand()
        fake.robot.walk(vx=0.06, seconds=16.0)
        fake.robot.walk(seconds=1.0)
        assert fake.base.z == pytest.approx(fake.robot.model.heights.stand - 3 * 0.035, abs=1.5e-3)
        assert not fake.fell


def test_it_walks_fast_without_waiting_for_what_it_feels() -> None:
    report = walk(speed=0.20, duration=5.0)
    assert report["distance_m"] == pytest.approx(1.0, rel=0.12)
    assert report["max_tilt_deg"] < 4.0


@pytest.mark.parametrize(("gait", "speed"), [("tripod", 0.10), ("wave", 0.04)])
def test_servos_unlike_their_file_do_not_feign_ground(gait: str, speed: float) -> None:
    for seed in (0, 1):
        report = rig.walk(rig.varied("hexapod", seed, 0.30), seed=seed, gait=gait, speed=speed, duration=5.0)
        assert report["distance_m"] == pytest.approx(5.0 * speed, rel=0.12)
        assert report["max_tilt_deg"] < 2.5
