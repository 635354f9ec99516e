"""Walks over other ground than flat: what is measured there, and that it can be repeated and replayed."""

from pathlib import Path
from typing import Any

import pytest

from robotwalk.assembly.replay import replay
from robotwalk.log import Log
from robotwalk.testing import FakeRobot

from .conftest import Run

STEP_DOWN = """\
schema: 1
name: cellar
description: a low step down onto rough ground
lead_mm: 100
course:
  - {element: stairs, steps: 1, rise_mm: -20, tread_mm: 200}
  - {element: rough, length_mm: 1000, cell_mm: 100, heights_mm: [-5, 5]}
"""


def walk(robotwalk: Run, *options: str) -> dict[str, Any]:
    done = robotwalk("walk", "hexapod", "--speed", "0.2", "--duration", "4", "--json", *options)
    assert (done.code, done.err) == (0, "")
    return done.json


def test_a_walk_down_a_step_is_measured_from_the_ground_repeated_and_replayed(
    tmp_path: Path, robotwalk: Run
) -> None:
    file, log = tmp_path / "cellar.yaml", tmp_path / "walk.mcap"
    file.write_text(STEP_DOWN)
    first = walk(robotwalk, "--terrain", str(file), "--log", str(log))
    assert first["displacement"]["z"] == pytest.approx(-0.02, abs=0.01)
    assert first["distance_m"] > 0.6
    assert first["min_height_m"] > 0.085
    assert not first["fell"]
    assert walk(robotwalk, "--terrain", str(file))["state_hash"] == first["state_hash"]
    assert walk(robotwalk, "--terrain", str(file), "--seed", "1")["state_hash"] != first["state_hash"]
    file.unlink()
    assert replay(log).difference is None
    with Log(log) as recorded:
        assert recorded.files["terrain.yaml"] == STEP_DOWN
        assert recorded.about["terrain"] == "cellar"


def test_a_body_on_a_slope_far_below_its_start_has_not_fallen(tmp_path: Path) -> None:
    file = tmp_path / "slope.yaml"
    file.write_text(
        "schema: 1\nname: slope\ndescription: down\nlead_mm: 0\n"
        "course: [{element: ramp, length_mm: 3000, slope_deg: -10}]\n")
    with FakeRobot("hexapod", terrain=file) as fake:
        fake.robot.stand()
        fake.robot.walk(vx=0.2, seconds=3.5)
        assert sum(fake.contacts.values()) >= 3
        assert fake.base.z < 0.5 * fake.robot.model.heights.stand
        assert fake.min_height_m > 0.08
        assert not fake.fell
        assert 8.0 < fake.max_tilt_deg < 15.0


@pytest.mark.parametrize(("command", "complaint"), [
    (["walk", "hexapod", "--terrain", "stares"], "no terrain is named 'stares'; did you mean 'stairs_40'?"),
    (["walk", "hexapod", "--terrain", "flat", "--port", "legs=/dev/null"], "--terrain is for a simulation"),
    (["bench", "course", "hexapod", "--seeds", "0"], "--seeds and --jobs should be at least 1"),
])
def test_a_terrain_that_cannot_be_is_wrong_usage(
    command: list[str], complaint: str, run: Run
) -> None:
    done = run(*command)
    assert done.code == 2
    assert complaint in done.err


def test_the_bench_of_courses_tells_median_and_worst(run: Run) -> None:
    told = run(
        "bench", "course", "hexapod", "--terrain", "ramp_8", "--speed", "0.15", "--seconds", "4", "--seeds", "2",
        "--blind", "--json").json
    row, blind = told["courses"]
    assert (row["blind"], blind["blind"]) == (False, True)
    assert blind["max_tilt_deg"] != row["max_tilt_deg"]
    assert told["schema"] == 1
    assert (row["terrain"], row["gait"], row["falls"], row["safety_stops"]) == ("ramp_8", "tripod", 0, 0)
    assert 0.8 < row["distance_share"]["min"] <= row["distance_share"]["median"] < 1.2
    assert 0.0 < row["max_tilt_deg"]["median"] <= row["max_tilt_deg"]["max"] < 12.0
