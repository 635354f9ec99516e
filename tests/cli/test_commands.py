"""What each command says and returns."""

import math
from pathlib import Path

import pytest
from PIL import Image

from robotwalk import assembly
from robotwalk.config import library

from .conftest import Run

HEXAPODS = [name for name in library.names("robots") if name.startswith("hexapod")]


def test_help_names_the_commands_and_the_exit_codes(run: Run) -> None:
    result = run("--help")
    assert result.code == 0
    for word in ("walk", "check", "list", "bench", "Exit codes", "safety stop"):
        assert word in result.out


def test_walk_help_explains_every_option(run: Run) -> None:
    out = run("walk", "--help").out
    for option in ("--gait", "--speed", "--direction", "--heading", "--turn", "--goto", "--path", "--height",
                   "--duration", "--rate", "--seed", "--faults", "--log", "--gif", "--view", "--json"):
        assert option in out


def test_walk_json_has_every_field_of_the_contract(robotwalk: Run) -> None:
    result = robotwalk("walk", "hexapod", "--speed", "0.08", "--duration", "1", "--json")
    assert result.code == 0
    assert result.err == ""
    report = result.json
    assert report["schema"] == 1
    assert report["robot"] == "hexapod"
    assert report["gait"] == "tripod"
    assert report["backend"] == "sim"
    assert report["rate_hz"] == 100
    assert report["duration_s"] == 1.0
    assert report["commanded"] == {"vx": 0.08, "vy": 0.0, "wz": 0.0}
    assert set(report["displacement"]) == {"x", "y", "z", "yaw_deg"}
    assert set(report["odometry"]) == {"distance_m", "heading_change_deg"}
    assert set(report["bus"]["legs"]) == {
        "tx_bytes", "rx_bytes", "transactions", "lost_replies", "bad_frames", "max_age_ms", "watchdog_trips"}
    assert set(report["timing"]) == {"missed_deadlines", "wake_us", "tick_us", "bus_us"}
    for histogram in ("wake_us", "tick_us", "bus_us"):
        assert set(report["timing"][histogram]) == {"p50", "p99", "p999", "max"}
    for field in ("distance_m", "speed_mps", "heading_change_deg", "lateral_drift_m", "max_tilt_deg", "min_height_m",
                  "min_stability_margin_m",
                  "energy_j", "cost_of_transport", "wall_s", "realtime_factor"):
        assert math.isfinite(report[field]), field
    assert report["goal"] is None
    assert report["fell"] is False
    assert report["energy_j"] > 0.0
    assert {"t", "kind", "text"} == set(report["events"][0])
    assert len(report["state_hash"]) == 64
    # An exchange of 18 servos at 1 Mbaud is 396 bytes; the simulated wire takes its time for them.
    assert report["timing"]["bus_us"]["p50"] == pytest.approx(3960, rel=0.03)


def test_walk_says_it_in_words_to_a_person(robotwalk: Run) -> None:
    result = robotwalk("walk", "hexapod", "--duration", "1")
    assert result.code == 0
    assert "hexapod, tripod: 0." in result.out
    assert "no fall" in result.out


def test_a_walk_leaves_a_film_and_a_log(robotwalk: Run, tmp_path: Path) -> None:
    result = robotwalk("walk", "hexapod", "--duration", "0.5", "--gif", "walk.gif", "--log", "walk.mcap")
    assert result.code == 0
    with Image.open(tmp_path / "walk.gif") as film:
        assert film.n_frames > 60
    assert (tmp_path / "walk.mcap").read_bytes()[:8] == b"\x89MCAP0\r\n"


def test_a_goal_too_far_for_the_time_is_told(run: Run) -> None:
    result = run("walk", "hexapod", "--goto", "-0.3,0.4", "--duration", "1", "--json")
    assert result.code == 1
    assert "the goal was not reached within 1.0 s, 0.4" in result.err
    goal = result.json["goal"]
    assert (goal["x"], goal["y"], goal["reached"]) == (-0.3, 0.4, False)
    assert goal["miss_m"] + result.json["distance_m"] == pytest.approx(0.5, abs=0.01)


def test_a_negative_speed_walks_backwards(run: Run) -> None:
    report = run("walk", "hexapod", "--speed", "-0.05", "--duration", "2", "--json").json
    assert report["displacement"]["x"] == pytest.approx(-0.1, rel=0.15)
    assert report["distance_m"] == pytest.approx(0.1, rel=0.15)
    assert report["commanded"]["vx"] == pytest.approx(-0.05)


@pytest.mark.parametrize("kind", ["robots", "servos", "gaits"])
def test_list_names_everything_that_is_bundled(run: Run, kind: library.Kind) -> None:
    listed = run("list", kind, "--json").json
    names = [library.open_document(kind, file).value(("name",)) for file in library.names(kind)]
    assert [row["name"] for row in listed[kind]] == names
    table = run("list", kind).out
    assert all(name in table for name in names)


def test_list_faults_explains_what_a_script_may_hold(run: Run) -> None:
    rows = {row["name"]: row for row in run("list", "faults", "--json").json["faults"]}
    assert rows["drop_reply"]["keys"]["rate"] == {
        "description": "share of each servo's replies", "required": False, "default": 1.0}
    shown = run("list", "faults").out
    for name, row in rows.items():
        assert f"{name}\n" in shown
        assert all(f"  {key}" in shown for key in row["keys"])


def test_a_script_of_faults_befalls_a_walk(run: Run, tmp_path: Path) -> None:
    (tmp_path / "faults.yaml").write_text("- {at: 3, for: 0.3, fault: drop_reply, joint: rr_tibia}\n")
    report = run("walk", "hexapod", "--duration", "2", "--faults", "faults.yaml", "--json").json
    assert 5 <= report["bus"]["legs"]["lost_replies"] <= 8, "asked in vain in ever fewer of 30 ticks"
    assert not report["fell"]


def test_list_gaits_tells_which_robots_each_fits(run: Run) -> None:
    rows = [(row["name"], row["robots"]) for row in run("list", "gaits", "--json").json["gaits"]]
    assert len(rows) == len(library.names("gaits"))
    for row in [
        ("crawl", ["quadruped"]), ("free", HEXAPODS), ("free", ["quadruped"]), ("ripple", HEXAPODS),
        ("tetrapod", ["octopod"]), ("tripod", HEXAPODS), ("wave", [*HEXAPODS, "octopod", "pentapod"]),
    ]:
        assert row in rows


@pytest.mark.parametrize("robot", [name for name in library.names("robots") if name != "hexapod"])
def test_check_passes_every_bundled_robot(run: Run, robot: str) -> None:
    result = run("check", robot, "--json")
    assert (result.code, result.json["problems"]) == (0, [])


def test_check_tells_all_of_the_hexapod(run: Run) -> None:
    result = run("check", "hexapod", "--json")
    assert result.code == 0
    report = result.json
    assert report["ok"] is True
    assert report["problems"] == []
    assert report["mass_kg"] == pytest.approx(2.35)
    assert report["buses"]["legs"]["wire_ms"] == pytest.approx(3.96)
    raised = {row["what"]: row["largest_rate_hz"] for row in report["buses"]["legs"]["raised_by"]}
    lowered = {row["what"]: row["largest_rate_hz"] for row in report["buses"]["legs"]["lowered_by"]}
    best = report["buses"]["legs"]["largest_rate_hz"]
    assert raised["4000000 baud"] == 4 * best
    assert raised["two buses of half as many servos"] > 1.5 * best
    assert lowered["an adapter that holds replies back for 16 ms"] < 50
    assert all(rate < best for rate in lowered.values())
    # 18 x 1.3 A, by the data sheet.
    assert report["supply"] == {
        "stall_a": 23.4, "stated_a": None, "supply_v": 11.1, "sag_at_stall_v": 1.17, "servos_without_sheet": 0}
    gaits = {gait["gait"]: gait for gait in report["gaits"]}
    assert set(gaits) == {"free", "limp", "ripple", "stroll", "tetrapod", "tripod", "wave"}
    assert all(gait["reach_error_mm"] == 0.0 for gait in gaits.values())
    assert gaits["wave"]["balance_margin_mm"] > gaits["tripod"]["balance_margin_mm"] > 0.0


def test_check_shows_the_calibration_and_says_where_it_is_wrong(run: Run, tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text((library.root() / "robots" / "quadruped.yaml").read_text())
    calibration = tmp_path / "mine.calibration.yaml"
    row = "lf_hip: {servo: sts3215, direction: 1, zero_deg: 2.5, verified: true, time: now}"
    calibration.write_text(f"schema: 1\nrobot: quadruped\njoints:\n  {row}\n")
    result = run("check", "mine.yaml", "--json")
    assert result.json["calibration"]["joints"] == {"lf_hip": {
        "servo": "sts3215", "direction": 1, "zero_deg": 2.5, "range_deg": None, "verified": True, "time": "now"}}
    calibration.write_text(f"schema: 1\nrobot: quadruped\njoints:\n  {row.replace('2.5', '200')}\n")
    result = run("check", "mine.yaml")
    assert result.code == 3
    assert result.err.startswith("mine.calibration.yaml:4:52: joints.lf_hip.zero_deg: the joint's limits")


def test_check_fails_a_rate_that_the_bus_cannot_carry(run: Run) -> None:
    result = run("check", "hexapod", "--rate", "250")
    assert result.code == 1
    assert "bus legs needs 3.96 ms a tick, 99 % of it; the largest rate is 202 Hz" in result.out


def test_bench_reports_the_fields_of_the_contract(run: Run) -> None:
    tick = run("bench", "tick", "--seconds", "1", "--json").json
    assert set(tick) == {"schema", "robot", "joints", "tick_us"}
    assert tick["joints"] == 18
    assert 0.0 < tick["tick_us"]["p50"] <= tick["tick_us"]["p99"]
    sim = run("bench", "sim", "--rate", "100", "--seconds", "1", "--json").json
    assert set(sim) == {"schema", "robot", "rate_hz", "realtime_factor", "bare_mj_step_factor", "ratio"}
    assert 0.0 < sim["ratio"] < 1.0


def test_bench_bus_measures_bytes_on_a_wire_beside_the_vendors_sdk(robotwalk: Run) -> None:
    found = robotwalk("bench", "bus", "quadruped", "--rate", "50", "--seconds", "0.5", "--json").json
    assert set(found) == {
        "schema", "robot", "baud", "servos", "buses", "rate_hz", "exchange_ms", "wire_ms", "ratio", "cpu_us",
        "real_time", "silent_servo_extra_ms", "back_to_back_hz", "reference"}
    assert set(found["real_time"]) == {"fifo", "awake"}
    assert (found["baud"], found["servos"], found["buses"]) == (1_000_000, 12, 1)
    assert found["exchange_ms"]["p50"] >= found["wire_ms"] > 1.0, "no exchange is quicker than its bytes"
    assert found["exchange_ms"]["p50"] / found["wire_ms"] == pytest.approx(found["ratio"], abs=0.01)
    assert found["cpu_us"] > 0.0
    assert set(found["reference"]) == {"scservo-sdk"}
    assert found["reference"]["scservo-sdk"]["exchange_ms"] >= 0.9 * found["wire_ms"]


def test_bench_bus_at_a_baud_that_the_servos_do_not_have(run: Run) -> None:
    result = run("bench", "bus", "quadruped", "--baud", "4000000")
    assert result.code == 2
    assert "sts3215 does not have 4000000 baud; it has 1000000, 500000" in result.err


def test_a_supply_that_cannot_feed_all_servos_at_stall_is_a_problem(run: Run, tmp_path: Path) -> None:
    text = library.open_document("robots", "hexapod").text
    (tmp_path / "mine.yaml").write_text(text.replace("hardware:\n", "hardware:\n  power: {max_current_a: 10}\n"))
    result = run("check", "mine.yaml")
    assert result.code == 1
    assert "problem: all servos stalled would draw 23.4 A; the supply is stated to give 10 A" in result.out


@pytest.mark.parametrize("robot", ["hexapod", "octopod", "hexapod_xl330"])
def test_the_plan_is_within_a_twentieth_of_what_the_simulated_wire_takes(run: Run, robot: str) -> None:
    planned = max(bus.wire_s for bus in assembly.bus_loads(assembly.load(robot), assembly.RATE_HZ))
    report = run("walk", robot, "--duration", "0.5", "--speed", "0.04", "--json").json
    measured = report["timing"]["bus_us"]["p50"]
    assert measured == pytest.approx(1e6 * planned, rel=0.05)
