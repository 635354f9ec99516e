"""The last minute before a safety stop is kept, and nothing more."""

import json
from pathlib import Path

import pytest
from mcap.reader import make_reader

from robotwalk import assembly
from robotwalk.assembly.replay import replay
from robotwalk.black_box import BlackBox
from robotwalk.errors import SafetyStop, UsageError
from robotwalk.log import Log


def stopped(folder: Path, seconds: float) -> assembly.Simulation:
    """Return a quadruped after a walk that a dead servo ended, with a black box for that folder."""
    dead = {"at": seconds, "fault": "dead_servo", "joint": "lf_calf"}
    simulation = assembly.simulate("quadruped", faults=[dead])
    assembly.add_black_box(simulation, folder)
    with simulation.robot as robot:
        robot.stand()
        with pytest.raises(SafetyStop):
            robot.walk(vx=0.10, seconds=seconds + 20.0)
    return simulation


def test_a_safety_stop_leaves_what_came_before_it_in_a_log_that_people_can_open(tmp_path: Path) -> None:
    simulation = stopped(tmp_path / "new" / "folder", 5.0)
    (path,) = (tmp_path / "new" / "folder").iterdir()
    (said,) = [event.text for event in simulation.robot.events if event.kind == "black_box"]
    assert said == f"the black box, with what happened before: {path}"
    with Log(path) as log:
        assert log.about["black_box"].startswith("joint lf_calf has not answered")
        assert log.files["robot.yaml"] == simulation.blueprint.document.text
    with path.open("rb") as file:
        messages = [(channel.topic, message.log_time, json.loads(message.data))
                    for _, channel, message in make_reader(file).iter_messages()]
    states = [fields["state"] for topic, _, fields in messages if topic == "/command"]
    assert list(dict.fromkeys(states)) == ["stand", "walk", "mend", "fault", "stop"]
    told = [fields for topic, _, fields in messages if topic == "/joint_states"]
    assert len(told) == len(states)
    slot = told[0]["name"].index("lf_calf")
    assert told[0]["valid"][slot]
    assert not told[-1]["valid"][slot]
    assert told[-1]["age"][slot] > 3.0
    assert "timing" not in {topic for topic, _, _ in messages}, "what was not measured is not told"
    assert [fields["kind"] for topic, _, fields in messages if topic == "/events"][-1] == "safety_stop"
    with pytest.raises(UsageError, match="is a black box"):
        replay(path)


def test_it_keeps_a_minute_and_a_few_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("quadruped-2", "quadruped-1", "hexapod-1"):
        (tmp_path / f"{name}.mcap").touch()
    monkeypatch.setattr("robotwalk.black_box._KEPT", 2)
    monkeypatch.setattr("robotwalk.black_box.SECONDS", 4)
    stopped(tmp_path, 5.0)
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names[0] == "hexapod-1.mcap"
    assert len(names) == 3
    (path,) = [tmp_path / name for name in names if name.startswith("quadruped-20")]
    with path.open("rb") as file:
        times = [message.log_time for _, _, message in make_reader(file).iter_messages(topics=["/odom"])]
    assert len(times) == 400
    assert (times[-1] - times[0]) * 1e-9 == pytest.approx(3.99)


def test_where_it_cannot_be_saved_that_is_told_and_nothing_raised(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    box = BlackBox(tmp_path / "file", {}, {}, ("lf_coxa",), 100)
    assert box.save("told to stop", []).startswith("the black box could not be saved: ")
