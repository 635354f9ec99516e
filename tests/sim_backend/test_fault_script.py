"""Scripts of faults: what they may hold, and where one is told that something is wrong."""

from pathlib import Path
from typing import Any

import pytest

from robotwalk.errors import ConfigError
from sim_backend.faults.replies import DropReply
from sim_backend.faults.script import FAULTS, explain_faults, read_script

WIRING = {"lf_hip": "front", "lf_knee": "front", "lr_hip": "rear"}


def test_a_file_is_read_in_its_order(tmp_path: Path) -> None:
    path = tmp_path / "faults.yaml"
    path.write_text(
        "- {at: 2, for: 0.5, fault: drop_reply, rate: 0.05, bus: rear}\n"
        "- {at: 1.5, fault: unplug, bus: front}\n")
    drop, unplug = read_script(path, WIRING)
    assert drop == DropReply(**{"at": 2, "for": 0.5, "fault": "drop_reply", "rate": 0.05, "bus": "rear"})
    assert (unplug.kind(), unplug.at, unplug.lasts) == ("unplug", 1.5, None)


def test_a_list_from_python_is_the_same() -> None:
    [push] = read_script([{"at": 1, "fault": "push", "force_n": 5}], WIRING)
    assert (push.kind(), push.lasts) == ("push", 0.1)


@pytest.mark.parametrize(("text", "complaint"), [
    ("fault: noise", "1:1: expected a list of faults (got a mapping)"),
    ("", "1:1: expected a list of faults (got nothing)"),
    ("- noise", "1:3: 0: missing key 'fault'"),
    ("- {at: 0}", "1:3: 0: missing key 'fault'"),
    ("- {at: 0, fault: drop_replies}", "1:18: 0.fault: no such fault; did you mean 'drop_reply'? (got 'drop_replies')"),
    ("- {fault: noise}", "1:3: 0: missing key 'at'"),
    ("- {at: -1, fault: noise}", "1:8: 0.at: expected a number greater than or equal to 0 (got -1)"),
    ("- {at: 0, fault: noise}\n- {at: 0, fault: drop_reply, rat: 1}",
     "2:30: 1: unknown key 'rat': did you mean 'rate'?"),
    ("- {at: 0, fault: drop_reply, rate: 5}", "1:36: 0.rate: expected a number less than or equal to 1 (got 5)"),
    ("- {at: 0, fault: noise, for: 0}", "1:30: 0.for: expected a number greater than 0 (got 0)"),
    ("- {at: 0, fault: push}", "1:3: 0: missing key 'force_n'"),
    ("- {at: 0, fault: dead_servo, joint: knee}",
     "1:37: 0.joint: this robot has no such joint; it has lf_hip, lf_knee, lr_hip (got 'knee')"),
    ("- {at: 0, fault: unplug, bus: legs}", "1:31: 0.bus: this robot has no such bus; it has front, rear (got 'legs')"),
    ("- {at: 0, fault: brown_out, joint: lr_hip, bus: front}", "1:49: 0.bus: joint lr_hip is not on it (got 'front')"),
    ("- {at: 0, fault: duplicate_id, joint: lr_hip, id_of: lr_hip}",
     "1:54: 0.id_of: that is its own id (got 'lr_hip')"),
    ("- {at: 0, fault: duplicate_id, joint: lr_hip, id_of: lf_hip}",
     "1:54: 0.id_of: not on the same bus as lr_hip (got 'lf_hip')"),
    ("- {at: 0, fault: duplicate_id, joint: lr_hip, id_of: hip}",
     "1:54: 0.id_of: this robot has no such joint; it has lf_hip, lf_knee, lr_hip (got 'hip')"),
    ("- {at: .nan, fault: noise}", "1:8: 0.at: expected a finite number (got nan)"),
    ("- {at: 2000000, fault: noise}", "1:8: 0.at: expected a number less than or equal to 1000000 (got 2000000)"),
    ("- {at: 0, fault: noise, every_ms: 0}",
     "1:35: 0.every_ms: expected a number greater than or equal to 0.1 (got 0)"),
    ("- {at: 0, fault: [push]}", "1:18: 0.fault: no such fault; did you mean 'push'? (got ['push'])"),
])
def test_a_mistake_is_told_with_its_place(text: str, complaint: str, tmp_path: Path) -> None:
    path = tmp_path / "faults.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError) as raised:
        read_script(path, WIRING)
    assert str(raised.value) == f"{path}:{complaint}"


def test_a_mistake_in_a_list_is_told_with_its_path() -> None:
    script: list[dict[str, Any]] = [{"at": 0, "fault": "noise"}, {"at": 0, "fault": "noise", "bus": "legs"}]
    with pytest.raises(ConfigError, match=r"^faults:1:1: 1\.bus: this robot has no such bus"):
        read_script(script, WIRING)


def test_all_faults_are_explained_key_by_key() -> None:
    explained = {row["name"]: row for row in explain_faults()}
    assert set(explained) == set(FAULTS) == {
        "drop_reply", "corrupt_frame", "delay_reply", "duplicate_id", "noise", "unplug", "brown_out", "overload",
        "overheat", "dead_servo", "stuck_joint", "voltage_drop", "wrong_firmware", "push", "press_stop"}
    for row in explained.values():
        assert row["description"]
        assert all(facts["description"] for facts in row["keys"].values()), row
    assert explained["push"]["keys"]["force_n"] == {"description": "N", "required": True}
    assert explained["push"]["keys"]["for"]["default"] == 0.1
    assert "fault" not in explained["push"]["keys"]
