"""A walk over a lossy wire, as a user tries it: the robot's file, a servo's file of one's own beside it, a script."""

from pathlib import Path
from typing import Any

import pytest

from robotwalk.config import library

from .conftest import Run

LOSSY_WIRE = Path(__file__).resolve().parents[2] / "docs" / "lossy-wire.yaml"


def own_robot(folder: Path, **switches: str) -> Path:
    """Write a copy of the hexapod's file, and of its servo's with other firmware, as a user would."""
    robot, servo = folder / "my_robot.yaml", folder / "servos" / "xl430-w250.yaml"
    servo.parent.mkdir()
    robot.write_text(library.open_document("robots", "hexapod").text)
    lines = library.open_document("servos", "xl430-w250").text.splitlines()
    for name, value in switches.items():
        [at] = [index for index, line in enumerate(lines) if line.startswith(f"  {name}: ")]
        lines[at] = f"  {name}: {value}"
    servo.write_text("\n".join(lines) + "\n")
    return robot


def walked(robotwalk: Run, *words: str) -> dict[str, Any]:
    done = robotwalk("walk", *words, "--faults", str(LOSSY_WIRE), "--json")
    assert done.code == 0, done.err
    report = done.json
    assert report["distance_m"] == pytest.approx(1.0, rel=0.15)
    assert not report["fell"]
    assert report["max_tilt_deg"] < 5.0
    assert "safety_stop" not in [event["kind"] for event in report["events"]]
    return report


@pytest.mark.parametrize(("later_ids_answer", "least"), [("true", 0.05), ("false", 0.2)])
def test_it_walks_its_metre_whether_or_not_later_ids_answer(
    robotwalk: Run, tmp_path: Path, later_ids_answer: str, least: float
) -> None:
    """Without fast reads, where each servo answers in its turn. Where later ids keep silent, far more is lost."""
    robot = own_robot(tmp_path, version="44", later_ids_answer=later_ids_answer)
    bus = walked(robotwalk, str(robot), "--seed", "3")["bus"]["legs"]
    lost = bus["lost_replies"] / (18 * bus["transactions"])
    assert least < lost < least + 0.3
    assert bus["bad_frames"] > 100


def test_a_recorded_faulty_walk_replays_to_the_same_bytes(robotwalk: Run, tmp_path: Path) -> None:
    log = tmp_path / "walk.mcap"
    walked(robotwalk, "hexapod", "--seed", "2", "--log", str(log))
    done = robotwalk("replay", str(log), "--json")
    assert done.code == 0, done.err
    assert done.json["identical"]
