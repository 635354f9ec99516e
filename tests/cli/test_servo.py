"""`robotwalk servo` as a user runs it, on the buses of simulated robots that `robotwalk sim` serves."""

import json
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from .conftest import COMMAND, Run

pytestmark = pytest.mark.xdist_group("servo")

MISSING = "/dev/ttyNONE"


def serve(robot: str, folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen([*COMMAND, "sim", robot, "--pty", str(folder)], stdout=subprocess.PIPE, text=True)


@pytest.fixture(scope="module")
def buses(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """One bus of Dynamixel servos, ids 1 to 18, and one of Feetech's, ids 1 to 12."""
    folder = tmp_path_factory.mktemp("buses")
    robots = {"dynamixel": "hexapod", "feetech": "quadruped"}
    devices = {brand: serve(robot, folder / brand) for brand, robot in robots.items()}
    try:
        yield {brand: json.loads(device.stdout.readline())["buses"]["legs"] for brand, device in devices.items()}
    finally:
        for device in devices.values():
            device.terminate()
            device.wait(10)


@pytest.fixture(params=["dynamixel", "feetech"])
def brand(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture
def servo(run: Run, buses: dict[str, str], brand: str) -> Run:
    """Run `robotwalk servo` on a bus."""
    return lambda *words: run("servo", *words, "--port", buses[brand])


MODEL = {"dynamixel": "xl430-w250", "feetech": "sts3215"}
COUNT = {"dynamixel": 18, "feetech": 12}


def test_scan_finds_everybody_at_one_baud_rate(servo: Run, brand: str) -> None:
    result = servo("scan", "--baud", "1000000", "--json")
    assert result.code == 0
    assert [one["id"] for one in result.json["servos"]] == list(range(1, COUNT[brand] + 1))
    assert result.json["servos"][0] == {
        "dynamixel": {
            "id": 1, "protocol": "dynamixel-2.0", "baud": 1_000_000, "alert": False, "model_number": 1060,
            "model": "xl430-w250", "firmware": "45", "voltage_v": 11.1, "temperature_c": 30.0},
        "feetech": {
            "id": 1, "protocol": "feetech-sts", "baud": 1_000_000, "alert": False, "model_number": 777,
            "model": "sts3215", "firmware": "3.7", "voltage_v": 7.4, "temperature_c": 30.0},
    }[brand]
    assert result.json["clashes"] == []
    assert result.json["complete"] is True


def test_scan_as_a_table(servo: Run, brand: str) -> None:
    out = servo("scan", "--baud", "1000000").out
    assert f"{COUNT[brand]} servos" in out
    assert out.count(MODEL[brand]) == COUNT[brand]


def test_scan_at_the_wrong_baud_rate_finds_nobody(run: Run, buses: dict[str, str]) -> None:
    result = run("servo", "scan", "--baud", "57600", "--json", "--port", buses["dynamixel"])
    assert result.code == 4
    assert result.json["servos"] == []
    assert "no servo answers. Is it powered" in result.err


def await_open(process: subprocess.Popen[str], port: str) -> None:
    """Wait until a process has opened a port."""
    deadline, device = time.monotonic() + 60.0, os.path.realpath(port)
    while not any(os.path.realpath(link) == device for link in Path(f"/proc/{process.pid}/fd").iterdir()):
        assert time.monotonic() < deadline
        assert process.poll() is None
        time.sleep(0.05)


def test_ctrl_c_keeps_what_a_scan_has_found(buses: dict[str, str], brand: str) -> None:
    process = subprocess.Popen(
        [*COMMAND, "servo", "scan", "--json", "--port", buses[brand]], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True)
    await_open(process, buses[brand])
    time.sleep(4.0)  # the first of many baud rates takes 2.1 s
    os.kill(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    found = json.loads(out)
    assert len(found["servos"]) == COUNT[brand]
    assert found["complete"] is False
    assert "interrupted: not every baud rate was looked at" in err


def test_ping_says_who_it_is(servo: Run, brand: str) -> None:
    fields = servo("ping", "2", "--json").json
    assert (fields["id"], fields["model"]) == (2, MODEL[brand])
    assert 0.0 < fields["round_trip_ms"] < 100.0
    assert f"id 2: {MODEL[brand]}, firmware" in servo("ping", "2").out


def test_info_shows_every_register(servo: Run, brand: str) -> None:
    fields = servo("info", "2", "--json").json
    assert fields["hardware_errors"] == []
    assert fields["registers"]["id"] == {"raw": 2, "value": 2.0, "unit": "", "memory": "eeprom"}
    assert fields["registers"]["torque_enable"]["memory"] == "ram"
    assert len(fields["registers"]) == {"dynamixel": 163, "feetech": 57}[brand]
    out = servo("info", "2").out
    assert "hardware errors: none" in out
    assert out.index("EEPROM, kept without power") < out.index("max_voltage_limit") < out.index("RAM, back")
    assert max(map(len, out.splitlines())) <= 100


def test_read_and_write_in_units(servo: Run, buses: dict[str, str], brand: str) -> None:
    before = servo("read", "3", "max_voltage_limit", "--json").json["registers"]["max_voltage_limit"]
    result = servo("write", "3", "max_voltage_limit=7.5V")
    assert result.code == 0
    assert result.out == (
        f"max_voltage_limit = 7.5 V, was {before['value']:g} V\n"
        f"to undo: robotwalk servo write 3 max_voltage_limit={before['raw']} --raw --port {buses[brand]}\n")
    assert servo("write", "3", "max_voltage_limit=7.5").out == "max_voltage_limit = 7.5 V already; not written\n"
    assert servo("read", "3", "max_voltage_limit", "id").out == "max_voltage_limit = 7.5 V\nid = 3\n"
    assert servo("read", "3", "max_voltage_limit", "--raw").out == "max_voltage_limit = 75\n"
    change = servo("write", "3", f"max_voltage_limit={before['raw']}", "--raw", "--json").json["changes"]
    assert change == [{
        "register": "max_voltage_limit", "before": {"raw": 75, "value": 7.5, "unit": "V"}, "after": before,
        "asked": before["raw"]}]


@pytest.mark.parametrize(("words", "code", "sentence"), [
    (["ping", "77"], 4, "no servo answers as id 77 at 1000000 baud; `robotwalk servo scan` tries all baud rates"),
    (["ping", "1", "--baud", "57600"], 4, "no servo answers as id 1 at 57600 baud"),
    (["ping", "1", "--baud", "1234"], 2, "no servo that we know has 1234 baud; there are 9600,"),
    (["ping", "one"], 2, "one"),
    (["ping", "300"], 2, "an id is 0 to 252, not 300"),
    (["torque-off", "300"], 2, "an id is 0 to 252, not 300"),
    (["read", "1"], 2, "say which registers"),
    (["read", "1", "present_positon"], 2, "has no register 'present_positon'; did you mean 'present_position'?"),
    (["write", "1"], 2, "say what to write: REGISTER=VALUE"),
    (["write", "1", "id"], 2, "say REGISTER=VALUE, such as return_delay_time=0, not 'id'"),
    (["write", "1", "max_voltage_limit=99"], 2, "max_voltage_limit should be"),
    (["write", "1", "present_position=5"], 2, "present_position is read-only"),
    (["write", "1", "id=2"], 1, "id 2 is taken: another servo on this line answers to it"),
    (["set-id", "1", "2"], 1, "id 2 is taken: another servo on this line answers to it"),
    (["set-id", "1", "253"], 2, "an id is 0 to 252, not 253"),
    (["set-id", "77", "78"], 4, "no servo answers as id 77 at 1000000 baud"),
    (["set-baud", "1", "1234"], 2, "xl430-w250 does not have 1234 baud; it has 9600, 57600,"),
    (["wiggle", "1", "--by", "nan"], 2, "--by should be 1 to 15, not nan"),
    (["wiggle", "1", "--torque", "0"], 2, "--torque should be 5 to 100, not 0"),
    (["wiggle", "lf_coxa"], 2, "say which servo: an id and --port, or a joint's name and --robot"),
    (["wiggle", "lf_cox", "--robot", "hexapod"], 2, "hexapod has no joint 'lf_cox'; did you mean 'lf_coxa'?"),
    (["wiggle", "lf_hip", "--robot", "quadruped"], 4, "no servo answers as id 1 at 1000000 baud"),
    (["wiggle", "77"], 4, "no servo answers as id 77 at 1000000 baud"),
    (["adopt", "hexapod", "lf_cox"], 2, "hexapod has no joint 'lf_cox'; did you mean 'lf_coxa'?"),
    (["adopt", "hexapod", "lf_coxa", "--backup", "missing.yaml"], 3, "missing.yaml: cannot be read"),
    (["restore", "1", "missing.yaml"], 3, "missing.yaml: cannot be read: No such file or directory"),
    (["backup", "1", "no/such/folder/b.yaml"], 2, "no/such/folder/b.yaml cannot be written"),
    (["factory-reset", "1"], 2, "save it with `robotwalk servo backup`, then say --yes"),
    (["monitor", "--rate", "0"], 2, "--rate should be 1 to 200 times a second, not 0"),
    (["monitor", "--seconds", "nan"], 2, "--seconds should be above 0, not nan"),
])
def test_a_wrong_command_line(
    run: Run, buses: dict[str, str], words: list[str], code: int, sentence: str
) -> None:
    result = run("servo", *words, "--port", buses["dynamixel"])
    assert (result.code, result.out) == (code, "")
    assert sentence in result.err
    assert result.err.count("\n") == 1, "one sentence"


def test_all_values_are_checked_before_any_is_written(servo: Run) -> None:
    assert servo("write", "4", "return_delay_time=20", "max_voltage_limit=99").code == 2
    assert servo("read", "4", "return_delay_time", "--raw").out == "return_delay_time = 0\n"


@pytest.mark.parametrize("words", [
    ["write", "1", "led=1"], ["set-id", "1", "99"], ["set-baud", "1", "57600"], ["wiggle", "1"], ["torque-off"],
    ["adopt", "hexapod", "lf_coxa"], ["reboot", "1"],
    ["factory-reset", "1", "--yes"]])
def test_what_changes_a_physical_servo_needs_real(run: Run, words: list[str]) -> None:
    result = run("servo", *words, "--port", "socket://192.0.2.1:4000")
    assert result.code == 2
    assert "may be a physical robot, and this changes or moves a servo: say --real to do it" in result.err


def test_a_port_that_is_not_there(run: Run) -> None:
    result = run("servo", "ping", "1", "--port", MISSING)
    assert result.code == 4
    assert f"cannot open {MISSING}: there is no such port; is the adapter plugged in?" in result.err


def test_a_servo_moves_to_another_id_and_back_as_the_undo_says(servo: Run, buses: dict[str, str], brand: str) -> None:
    assert servo("set-id", "10", "99").out == (
        f"{MODEL[brand]}: id 99 at 1000000 baud, was id 10 at 1000000 baud; read back there\n"
        f"to undo: robotwalk servo set-id 99 10 --port {buses[brand]}\n")
    assert servo("ping", "10").code == 4
    assert servo("set-id", "99", "10", "--json").json == {
        "schema": 1, "baud": 1_000_000, "id": 10, "model": MODEL[brand], "before": {"baud": 1_000_000, "id": 99},
        "changed": True, "undo": f"robotwalk servo set-id 10 99 --port {buses[brand]}"}
    assert "it is id 10 at 1000000 baud already; nothing was written" in servo("set-id", "10", "10").out


def test_a_servo_moves_to_another_baud_rate_and_back_as_the_undo_says(
    servo: Run, buses: dict[str, str], brand: str
) -> None:
    result = servo("set-baud", "11", "57600")
    assert result.out.splitlines()[1] == (
        f"to undo: robotwalk servo set-baud 11 1000000 --port {buses[brand]} --baud 57600")
    assert servo("ping", "11").code == 4
    fields = servo("set-baud", "11", "1000000", "--baud", "57600", "--json").json
    assert (fields["baud"], fields["before"]["baud"], fields["changed"]) == (1_000_000, 57_600, True)
    assert servo("ping", "11").code == 0


def test_a_servo_with_a_strange_id_is_adopted(servo: Run, buses: dict[str, str], brand: str) -> None:
    robot, joint = {"dynamixel": ("hexapod", "rr_tibia"), "feetech": ("quadruped", "rr_calf")}[brand]
    servo("set-id", str(COUNT[brand]), "99")
    result = servo("adopt", robot, joint, "--baud", "1000000")
    assert result.code == 0
    assert result.out == (
        f"id = {COUNT[brand]}, was 99\n"
        f"{joint}: the {MODEL[brand]} that was id 99 at 1000000 baud is id {COUNT[brand]} at 1000000 baud; "
        "all was read back\n"
        f"its zero is not the old one's. Next: robotwalk calibrate {robot} {joint} "
        f"--port legs={buses[brand]}\n"
        "to undo, with it alone on the line, which makes it as it was when new: "
        f"robotwalk servo factory-reset {COUNT[brand]} --yes --port {buses[brand]}\n")
    again = servo("adopt", robot, joint, "--baud", "1000000", "--id", str(COUNT[brand]), "--json").json
    assert (again["changes"], again["id"]) == ([], COUNT[brand])
    assert servo("adopt", robot, joint, "--baud", "1000000").code == 4


JOINT = {"dynamixel": ("hexapod", "rm_coxa", 13), "feetech": ("quadruped", "lf_hip", 1)}


def test_wiggle_a_joint_by_its_name(servo: Run, brand: str) -> None:
    robot, joint, servo_id = JOINT[brand]
    fields = servo("wiggle", joint, "--robot", robot, "--json").json
    assert (fields["joint"], fields["id"], fields["moved"], fields["torque"]) == (joint, servo_id, True, False)
    assert [round(turn["asked_deg"]) for turn in fields["turns"]] == [4, -4]
    assert servo("read", str(servo_id), "torque_enable").out == "torque_enable = 0\n"


def test_wiggle_by_id_knows_no_direction(servo: Run, brand: str) -> None:
    result = servo("wiggle", str(JOINT[brand][2]), "--by", "3")
    assert result.code == 0
    assert f"id {JOINT[brand][2]} ({MODEL[brand]}): turned +" in result.out
    assert "plus is the way in which its counts grow" in result.out


def test_torque_goes_off_where_told_and_everywhere(servo: Run, brand: str) -> None:
    assert servo("write", "2", "torque_enable=1").code == 0
    assert servo("torque-off", "2").out == "torque is off: id 2\n"
    assert servo("read", "2", "torque_enable").out == "torque_enable = 0\n"
    assert servo("write", "2", "torque_enable=1").code == 0
    fields = servo("torque-off", "--json").json
    assert fields == {"schema": 1, "servos": list(range(1, COUNT[brand] + 1)), "torque": False}
    assert servo("read", "2", "torque_enable").out == "torque_enable = 0\n"


def test_reboot(servo: Run, brand: str) -> None:
    result = servo("reboot", "5", "--json")
    if brand == "dynamixel":
        assert result.code == 0
        assert 0.2 < result.json["seconds"] < 1.0
    else:
        assert result.code == 1
        assert "seems not to know the instruction. Switch its power off and on" in result.err


def test_monitor_as_lines(servo: Run, brand: str) -> None:
    result = servo("monitor", "2", "3", "--rate", "10", "--seconds", "0.5", "--json")
    assert result.code == 0
    lines: list[dict[str, Any]] = [json.loads(line) for line in result.out.splitlines()]
    assert 2 <= len(lines) <= 5, "fewer where the computer is busy"
    assert [one["id"] for one in lines[0]["servos"]] == [2, 3]
    assert set(lines[0]["servos"][0]) == {
        "id", "answered", "position_deg", "velocity_deg_s", "load_percent", "voltage_v", "temperature_c", "errors"}
    assert all(-180.0 < one["position_deg"] < 180.0 for one in lines[0]["servos"])
    plain = servo("monitor", "2", "--rate", "10", "--seconds", "0.2").out
    assert f"id 2  {MODEL[brand]}" in plain


def test_backup_and_restore(servo: Run, tmp_path: Path, brand: str) -> None:
    file = {"dynamixel": "b.yaml", "feetech": "b.json"}[brand]
    saved = servo("backup", "6", file, "--json").json
    assert (saved["id"], saved["file"]) == (6, file)
    assert (tmp_path / file).exists()
    again = servo("backup", "6", file)
    assert (again.code, f"{file} exists already; --force overwrites it" in again.err) == (2, True)
    assert servo("backup", "6", file, "--force").code == 0
    servo("write", "6", "max_voltage_limit=7.5")
    result = servo("restore", "6", file)
    assert result.code == 0
    assert "max_voltage_limit = " in result.out
    assert "1 register changed" in result.out
    [undo] = [line for line in result.out.splitlines() if line.startswith("to undo: robotwalk servo ")]
    assert servo(*undo.removeprefix("to undo: robotwalk servo ").partition(" --port")[0].split()).code == 0
    assert servo("read", "6", "max_voltage_limit").out == "max_voltage_limit = 7.5 V\n"
    assert "1 register changed" in servo("restore", "6", file).out
    assert servo("restore", "6", file, "--json").json["changes"] == []
    other = servo("restore", "7", file)
    assert other.code == 0
    assert "left as they are: id (--with-id brings them back)" in other.out


def test_a_broken_backup_names_the_place(servo: Run, tmp_path: Path) -> None:
    servo("backup", "6", "b.yaml")
    text = (tmp_path / "b.yaml").read_text()
    (tmp_path / "b.yaml").write_text(text.replace("  max_voltage_limit: ", "  max_voltage_limit: 9"))
    result = servo("restore", "6", "b.yaml")
    assert result.code == 3
    assert "b.yaml:" in result.err
    assert ": registers.max_voltage_limit: max_voltage_limit should be" in result.err


def test_factory_reset(servo: Run, brand: str) -> None:
    result = servo("factory-reset", "8", "--yes", "--keep", "id-and-baud", "--json")
    if brand == "dynamixel":
        assert result.code == 0
        assert result.json == {"schema": 1, "id": 8, "baud": 1_000_000, "model": "xl430-w250", "changed": 1}
    else:
        assert result.code == 2
        assert "cannot be told to keep its id and baud" in result.err
