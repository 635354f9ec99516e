"""The log of a run, read back with MCAP's own reader."""

import json
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from robotwalk.errors import UsageError
from robotwalk.recorder import Event, Recorder, Row
from robotwalk.stability import Stability
from robotwalk.supervisor import State
from robotwalk.types import Command, JointState, Pose, Twist, Vec3

JOINTS = ("lf_coxa", "lf_femur", "lf_tibia")


def row(tick: int) -> Row:
    joints = JointState(
        position=(0.1, 0.2, 0.001 * tick), velocity=(0.0, 0.0, 0.5), effort=(0.0, -0.25, 1.0),
        valid=(True, True, False), age=(0.0, 0.0, 0.01))
    return Row(
        time=10_000_000 * tick, state=State.WALK,
        command=Command(Twist(0.1, 0.0, 0.2), heading=None, height=0.11, gait="wave"),
        twist=Twist(0.05, 0.0, 0.1), goals=(0.11, 0.21, 0.31), joints=joints,
        odometry=Pose(1.0, 2.0, 0.1, 0.0, 0.0, 3.0),
        stability=Stability(Vec3(0.01, 0.0, 0.02), (Vec3(0.2, 0.1, 0.0),) * 2, None),
        wake=12_000, bus=3_400_000, tick=250_500)


def read(path: Path) -> dict[str, list[tuple[int, dict[str, Any]]]]:
    """Return every topic's messages, in the order of the file's times."""
    topics: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            topics.setdefault(channel.topic, []).append((message.log_time, json.loads(message.data)))
    return topics


def test_every_row_is_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    recorder = Recorder(path, JOINTS, {"robot": "hexapod"})
    for tick in range(2_000):
        recorder.put(row(tick))
    recorder.close()
    topics = read(path)
    assert sum(len(message["steps"]) for _, message in topics.pop("/tape")) == 2_000
    assert set(topics) == {"/command", "/joint_states", "/joint_goals", "/odom", "/stability", "/timing"}
    for messages in topics.values():
        assert [time for time, _ in messages] == [10_000_000 * tick for tick in range(2_000)]
    assert [m["position"][2] for _, m in topics["/joint_states"]] == [0.001 * tick for tick in range(2_000)]


def test_what_a_row_says(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    recorder = Recorder(path, JOINTS, {})
    recorder.put(row(5))
    recorder.close()
    said = {topic: messages[0][1] for topic, messages in read(path).items()}
    assert said["/joint_states"] == {
        "name": ["lf_coxa", "lf_femur", "lf_tibia"], "position": [0.1, 0.2, 0.005], "velocity": [0.0, 0.0, 0.5],
        "effort": [0.0, -0.25, 1.0], "valid": [True, True, False], "age": [0.0, 0.0, 0.01]}
    assert said["/joint_goals"] == {"name": ["lf_coxa", "lf_femur", "lf_tibia"], "position": [0.11, 0.21, 0.31]}
    assert said["/odom"] == {"x": 1.0, "y": 2.0, "z": 0.1, "roll": 0.0, "pitch": 0.0, "yaw": 3.0}
    assert said["/stability"] == {
        "margin_m": None, "standing_feet": 2, "centre_of_mass": {"x": 0.01, "y": 0.0, "z": 0.02}}
    assert said["/timing"] == {"wake_us": 12.0, "bus_us": 3400.0, "tick_us": 250.5}
    assert said["/command"]["state"] == "walk"
    assert said["/command"]["twist"] == {"vx": 0.1, "vy": 0.0, "wz": 0.2}
    assert said["/command"]["twist_in_force"] == {"vx": 0.05, "vy": 0.0, "wz": 0.1}
    assert (said["/command"]["gait"], said["/command"]["height"], said["/command"]["heading"]) == ("wave", 0.11, None)


def test_events_and_what_the_run_was_of(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    recorder = Recorder(path, JOINTS, {"robot": "hexapod", "seed": "3"})
    recorder.put(row(1))
    recorder.event(15_000_000, Event(0.015, "state", "walk"))
    recorder.put(row(2))
    recorder.close()
    assert read(path)["/events"] == [(15_000_000, {"t": 0.015, "kind": "state", "text": "walk"})]
    with path.open("rb") as file:
        (metadata,) = make_reader(file).iter_metadata()
    assert (metadata.name, metadata.metadata) == ("robotwalk", {"robot": "hexapod", "seed": "3"})


def test_a_log_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"cannot write the log .*nowhere/run.mcap: No such file or directory"):
        Recorder(tmp_path / "nowhere" / "run.mcap", JOINTS, {})


@pytest.mark.parametrize("events", [1, 5000])
def test_a_full_disk_is_told_and_stops_nothing(events: int) -> None:
    recorder = Recorder(Path("/dev/full"), ("a",), {})
    for index in range(events):
        recorder.event(index, Event(0.0, "kind", "text" * 100))
    failure = recorder.close()
    assert failure is not None
    assert "No space left on device" in failure
