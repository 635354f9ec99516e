"""The last minute before a safety stop is kept, and nothing more."""

import json
import tracemalloc
from pathlib import Path

import pytest
from mcap.reader import make_reader

import robotwalk
from robotwalk import assembly
from robotwalk.assembly.replay import replay
from robotwalk.black_box import BlackBox
from robotwalk.errors import SafetyStop, UsageError
from robotwalk.log import Log
from robotwalk.loop import Tick
from robotwalk.robot import Robot
from robotwalk.types import Command


@pytest.fixture(autouse=True)
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return where black boxes are saved."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    return tmp_path / "robotwalk"


def stopped(seconds: float) -> Robot:
    """Return a quadruped after a walk that a dead servo ended."""
    dead = {"at": seconds, "fault": "dead_servo", "joint": "lf_calf"}
    with robotwalk.open("quadruped", faults=[dead]) as robot:
        robot.stand()
        with pytest.raises(SafetyStop):
            robot.walk(vx=0.10, seconds=seconds + 20.0)
    return robot


def test_a_safety_stop_leaves_what_came_before_it_in_a_log_that_people_can_open(state: Path) -> None:
    robot = stopped(5.0)
    (path,) = state.iterdir()
    (said,) = [event.text for event in robot.events if event.kind == "black_box"]
    assert said == f"the black box, with what happened before: {path}"
    with Log(path) as log:
        assert log.about["black_box"].startswith("joint lf_calf has not answered")
        assert log.files["robot.yaml"] == assembly.load("quadruped").document.text
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


def test_it_keeps_a_minute_and_a_few_files(state: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    state.mkdir()
    for name in ("quadruped-2", "quadruped-1", "hexapod-1"):
        (state / f"{name}.mcap").touch()
    monkeypatch.setattr("robotwalk.black_box._KEPT", 2)
    monkeypatch.setattr("robotwalk.black_box.SECONDS", 4)
    stopped(5.0)
    names = sorted(path.name for path in state.iterdir())
    assert names[0] == "hexapod-1.mcap"
    assert len(names) == 3
    (path,) = [state / name for name in names if name.startswith("quadruped-20")]
    with path.open("rb") as file:
        times = [message.log_time for _, _, message in make_reader(file).iter_messages(topics=["/odom"])]
    assert len(times) == 400
    assert (times[-1] - times[0]) * 1e-9 == pytest.approx(3.99)


def test_an_hour_takes_no_more_memory_than_a_minute(tmp_path: Path) -> None:
    ticks: list[Tick] = []
    with assembly.simulate("hexapod").robot as robot:
        robot.observers.append(ticks.append)
        robot.stand()
    box = BlackBox(tmp_path, {}, {}, robot.model.joint_names, 20)
    tracemalloc.start()
    try:
        sizes = []
        for _ in range(3):
            for _ in range(60 * 20):
                box.add(ticks[-1], Command())
            sizes.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    assert sizes[0] < 60 * 20 * 2300, "two kilobytes a tick, and what they cost"
    assert sizes[2] < sizes[0] + 10_000


def test_where_it_cannot_be_saved_that_is_told_and_nothing_raised(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    box = BlackBox(tmp_path / "file", {}, {}, ("lf_coxa",), 100)
    assert box.save("told to stop", []).startswith("the black box could not be saved: ")
