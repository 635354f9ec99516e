"""A robot's calibration: found beside its file, taken instead of its zeros, and doubted where it is wrong."""

import math
from pathlib import Path

import pytest

from robotwalk import assembly
from robotwalk.config import library
from robotwalk.errors import ConfigError

HEAD = "schema: 1\nrobot: quadruped\njoints:\n"
HIP = "  lf_hip: {servo: sts3215, direction: -1, zero_deg: 3.5, range_deg: [-30, 38], time: now}\n"
BUNDLED = library.root() / "robots" / "quadruped.yaml"


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    path = tmp_path / "quadruped.yaml"
    path.write_text(BUNDLED.read_text())
    return path


def calibrate(robot: Path, text: str) -> Path:
    file = robot.with_name("quadruped.calibration.yaml")
    file.write_text(text)
    return file


def test_it_overrides_zero_and_direction_and_narrows_limits(robot: Path) -> None:
    calibrate(robot, HEAD + HIP)
    plain, exact = assembly.load(str(robot)), assembly.load(str(robot), calibrated=True)
    assert exact.calibration is not None
    before, after = (blueprint.hardware.joints["lf_hip"] for blueprint in (plain, exact))
    assert (before.direction, before.zero_deg) == (1, 0.0)
    assert (after.direction, after.zero_deg) == (-1, 3.5)
    assert exact.wiring["legs"][0].calibration.angle(2048) == pytest.approx(math.radians(3.5))
    hip = exact.model.joints[0]
    assert (math.degrees(hip.lower), math.degrees(hip.upper)) == pytest.approx((-30.0, 38.0))
    assert exact.wiring["legs"][0].lower == hip.lower
    assert exact.wiring["legs"][1:] == plain.wiring["legs"][1:]


def test_limits_are_never_widened(robot: Path) -> None:
    calibrate(robot, HEAD + HIP.replace("[-30, 38]", "[-90, 90]"))
    hip = assembly.load(str(robot), calibrated=True).model.joints[0]
    assert (math.degrees(hip.lower), math.degrees(hip.upper)) == pytest.approx((-40.0, 40.0))


def test_a_simulation_is_not_calibrated(robot: Path) -> None:
    calibrate(robot, HEAD + HIP)
    assert assembly.simulate(str(robot)).blueprint.calibration is None


def test_the_bundled_robots_calibration_is_in_the_users_configuration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert library.calibration_path("quadruped") == tmp_path / "robotwalk" / "quadruped.calibration.yaml"
    (tmp_path / "robotwalk").mkdir()
    (tmp_path / "robotwalk" / "quadruped.calibration.yaml").write_text(HEAD + HIP)
    assert assembly.load("quadruped", calibrated=True).hardware.joints["lf_hip"].direction == -1
    monkeypatch.setenv("XDG_CONFIG_HOME", "relative, so to be ignored")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert library.calibration_path("quadruped") == tmp_path / ".config/robotwalk/quadruped.calibration.yaml"


def test_a_log_carries_it(robot: Path) -> None:
    calibrate(robot, HEAD + HIP)
    texts = assembly.load(str(robot), calibrated=True).files.texts()
    assert texts["calibration.yaml"] == HEAD + HIP
    assert "calibration.yaml" not in assembly.load(str(robot)).files.texts()


@pytest.mark.parametrize(("text", "place", "what"), [
    ("schema: 1\nrobot: hexapod\njoints: {}\n", "2:8: robot", "this is no calibration of quadruped (got 'hexapod')"),
    (HEAD + HIP.replace("lf_hip", "lf_hop"), "4:11: joints.lf_hop", "quadruped has no such joint; it has lf_hip,"),
    (HEAD + HIP.replace("sts3215", "xl430-w250"), "4:19: joints.lf_hip.servo",
     "lf_hip has an sts3215 by the robot's file: calibrate it anew (got 'xl430-w250')"),
    (HEAD + HIP.replace("[-30, 38]", "[38, -30]"), "4:69: joints.lf_hip.range_deg", "the lower end before the upper"),
    (HEAD + HIP.replace("[-30, 38]", "[50, 60]"), "4:69: joints.lf_hip.range_deg", "leaves nothing of the joint's"),
    (HEAD + HIP.replace("3.5", "160"), "4:53: joints.lf_hip.zero_deg", "leave the servo's range of -180 to 180 deg"),
    (HEAD + HIP.replace("[-30, 38]", "[20, 38]"), "4:3: joints", "with these ranges the robot cannot stand or sit"),
    (HEAD + HIP.replace("-1", "2"), "4:39: joints.lf_hip.direction", "1 or -1"),
    (HEAD + HIP.replace("3.5", ".nan"), "4:53: joints.lf_hip.zero_deg", "finite number"),
    (HEAD + HIP.replace("zero_deg", "zero"), "4:43: joints.lf_hip", "unknown key 'zero'"),
    ("[", "1:2: ", "not valid YAML"),
])
def test_what_is_wrong_is_said_with_its_place(robot: Path, text: str, place: str, what: str) -> None:
    file = calibrate(robot, text)
    with pytest.raises(ConfigError) as error:
        assembly.load(str(robot), calibrated=True)
    assert str(error.value).startswith(f"{file}:{place}")
    assert what in str(error.value)
