"""What is found wrong with a robot before it moves."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from robotwalk import assembly, checks
from robotwalk.config import library
from robotwalk.config.document import Document
from robotwalk.config.gait_schema import GaitConfig
from robotwalk.errors import ConfigError
from robotwalk.gait import Gait
from robotwalk.kinematics import resting_angles
from robotwalk.model import RobotModel
from robotwalk.types import Vec3

SQUARE = [Vec3(1.0, 1.0, 0.0), Vec3(-1.0, -1.0, 0.0), Vec3(1.0, -1.0, 0.0), Vec3(-1.0, 1.0, 0.0)]


class Broken:
    """The bundled hexapod's file with one change."""

    def __init__(self, folder: Path, old: str, new: str) -> None:
        text = (library.root() / "robots" / "hexapod.yaml").read_text()
        assert text.count(old) == 1, f"{old!r} is in the file {text.count(old)} times"
        self.text = text.replace(old, new)
        self.path = folder / "broken.yaml"
        self.path.write_text(self.text)

    def place(self, value: str) -> str:
        """Return file:line:column of a piece of text that is there once."""
        assert self.text.count(value) == 1
        before = self.text[: self.text.index(value)]
        return f"{self.path}:{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"

    def complaint(self) -> str:
        with pytest.raises(ConfigError) as error:
            assembly.load(str(self.path))
        return str(error.value)


def test_the_bundled_robot_is_sound() -> None:
    blueprint = assembly.load("hexapod")
    assert blueprint.default_gait == "tripod"
    assert {"tripod", "ripple", "wave"} <= set(blueprint.gaits)


def test_a_foot_is_missing(tmp_path: Path) -> None:
    broken = Broken(tmp_path, "    rr: *foot\n", "")
    assert broken.complaint() == f"{broken.place('lf: &foot')}: locomotion.feet: leg 'rr' is missing"


def test_a_foot_too_many(tmp_path: Path) -> None:
    tail = "    tail: {rest_mm: [1, 0], max_stride_mm: 1, lift_mm: 1}\n"
    broken = Broken(tmp_path, "    rr: *foot\n", "    rr: *foot\n" + tail)
    where = broken.place("{rest_mm: [1,")
    assert broken.complaint() == f"{where}: locomotion.feet.tail: no such leg; there are lf, lm, lr, rf, rm, rr"


def test_a_stance_out_of_reach(tmp_path: Path) -> None:
    broken = Broken(tmp_path, "rest_mm: [135, 0]", "rest_mm: [400, 0]")
    # From the femur's joint it is hypot(348, 100) = 362 mm to the foot; femur and tibia are 199 mm.
    assert broken.complaint() == (
        f"{broken.place('[400')}: locomotion.feet.lf.rest_mm: unreachable stance: at the stand height of 109 mm leg lf "
        "misses the foot's rest position by 163 mm (got [400, 0])")


def test_a_stance_beyond_a_joints_limits(tmp_path: Path) -> None:
    broken = Broken(tmp_path, "limits_deg: [-95, 60]", "limits_deg: [-95, 10]")
    complaint = broken.complaint()
    where = broken.place("[135, 0]")
    assert complaint.startswith(f"{where}: locomotion.feet.lf.rest_mm: unreachable stance: at the sit height of 30 mm")
    assert "joint lf_tibia would be " in complaint
    assert "outside its limits of 12.1 to 117.1 deg (got [135, 0])" in complaint


@pytest.mark.parametrize("stand", ["150", "60", "20"])
def test_heights_out_of_order(tmp_path: Path, stand: str) -> None:
    broken = Broken(tmp_path, "stand: 109", f"stand: {stand}")
    complaint = broken.complaint()
    assert complaint.startswith(
        f"{broken.place('{sit: 30')}: locomotion.height_mm: expected sit < lowest <= stand <= highest")


def test_a_seat_in_the_ground(tmp_path: Path) -> None:
    broken = Broken(tmp_path, "sit: 30", "sit: 24")
    where = broken.place("24, ")
    assert broken.complaint() == f"{where}: locomotion.height_mm.sit: the body would be in the ground (got 24.0)"


def test_one_id_for_two_servos(tmp_path: Path) -> None:
    broken = Broken(tmp_path, "id: 11,", "id: 5,  ")
    text = broken.text
    line = text[: text.index("rf_femur: {")].count("\n") + 1
    complaint = broken.complaint()
    assert complaint.startswith(f"{broken.path}:{line}:")
    assert complaint.endswith("hardware.joints.rf_femur.id: already the id of lm_femur on bus 'legs' (got 5)")


def test_no_closed_form_for_a_leg_whose_file_asks_for_one(tmp_path: Path) -> None:
    broken = Broken(tmp_path, "link_mm: [66, 0, 0]", "link_mm: [66, 1, 0]")
    assembly.load(str(broken.path))  # by coordinate descent
    broken.text = broken.text.replace("locomotion:\n", "locomotion:\n  solver: closed_form\n")
    broken.path.write_text(broken.text)
    where = broken.place("closed_form")
    assert broken.complaint().startswith(
        f"{where}: locomotion.solver: leg lf has no closed form for the chain (yaw, pitch, pitch)")


GAIT = "schema: 1\nname: own\ndescription: x\nslowest_period_s: 1\nswing:\n"


def gait_complaint(sectors: str) -> str:
    document = Document.parse(GAIT + f"  a: {sectors}\n  b: [[0, 0.5]]\n  c: [[0, 0.5]]\n", "own.yaml")
    with pytest.raises(ConfigError) as error:
        checks.require_sound_gait(document, document.validate(GaitConfig))
    return str(error.value)


@pytest.mark.parametrize("sectors", [
    "[[0.5, 0.5]]",  # empty
    "[[0.5, 0.4]]",  # backwards
    "[[0.0, 1.0]]",  # no stance
    "[[0.7, 1.8]]",  # round into itself
    "[[0.0, 0.3], [0.2, 0.5]]",  # overlapping
    "[[0.0, 0.3], [0.3, 0.5]]",  # without stance between
    "[[0.2, 0.3], [0.9, 1.25]]",  # the second round into the first
])
def test_unsound_circles(sectors: str) -> None:
    assert gait_complaint(sectors).startswith("own.yaml:6:6: swing.a: each sector should be [start, end] in turns")


def test_a_sound_circle() -> None:
    swing = "".join(f"  {foot}: [[0.9, 1.1], [0.2, 0.3]]\n" for foot in "abc")
    document = Document.parse(GAIT + swing, "own.yaml")
    checks.require_sound_gait(document, document.validate(GaitConfig))


@pytest.mark.parametrize(("x", "y", "margin"), [
    (0.0, 0.0, 1.0), (0.9, 0.0, 0.1), (0.0, -0.75, 0.25), (0.5, 0.9, 0.1), (1.0, 0.3, 0.0), (1.5, 0.0, -0.5)])
def test_support_margin_of_a_square(x: float, y: float, margin: float) -> None:
    for feet in (SQUARE, SQUARE[::-1], [*SQUARE, Vec3(0.2, 0.1, 0.0), *SQUARE], [*SQUARE, Vec3(0.0, 1.0, 0.0)]):
        assert checks.support_margin(feet, Vec3(x, y, 7.0)) == pytest.approx(margin, abs=1e-12)


def test_support_margin_of_a_triangle() -> None:
    feet = [Vec3(0.0, 0.0, 0.0), Vec3(4.0, 0.0, 0.0), Vec3(0.0, 3.0, 0.0)]
    assert checks.support_margin(feet, Vec3(1.0, 1.0, 0.0)) == pytest.approx(1.0)  # its inscribed circle
    assert checks.support_margin(feet, Vec3(4.0, 3.0, 0.0)) == pytest.approx(-2.4)


@pytest.mark.parametrize("feet", [[], SQUARE[:1], SQUARE[:2], [Vec3(float(i), float(i), 0.0) for i in range(5)]])
def test_feet_in_a_line_support_nothing(feet: list[Vec3]) -> None:
    assert checks.support_margin(feet, Vec3(0.0, 0.0, 0.0)) == -math.inf


def test_centre_of_mass(hexapod: RobotModel) -> None:
    flat = [0.0, 0.0, 0.0] * 6
    assert checks.centre_of_mass(hexapod, flat) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    # Shins straight down: 87 g hang 66.5 mm low and 3 g 133 mm, six times, in 2350 g.
    hanging = checks.centre_of_mass(hexapod, [0.0, 0.0, math.pi / 2.0] * 6)
    assert hanging == pytest.approx((0.0, 0.0, -0.0157902), abs=1e-7)
    # The left front leg turned by 90 deg to the left: its 80, 30, 87 and 3 g lie 26, 85, 184.5 and 251 mm out.
    turned = checks.centre_of_mass(hexapod, [math.pi / 2.0, *flat[1:]])
    assert turned == pytest.approx((-0.0128992, 0.0, 0.0), abs=1e-6)


def test_the_standing_robot_balances_over_its_middle(hexapod: RobotModel) -> None:
    centre = checks.centre_of_mass(hexapod, resting_angles(hexapod, hexapod.heights.stand))
    assert centre[:2] == pytest.approx((0.0, 0.0), abs=1e-9)


def test_balance_of_the_bundled_gaits(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    # Tripod: 107 mm from the middle to the edge between two feet; half a stride brings it 44 mm nearer.
    assert checks.balance(hexapod, gaits["tripod"]).margin == pytest.approx(0.0635, abs=1.5e-3)
    assert checks.balance(hexapod, gaits["ripple"]).margin > 0.09
    assert checks.balance(hexapod, gaits["wave"]).margin > 0.11


def test_a_gait_that_falls_over_is_found(hexapod: RobotModel) -> None:
    sides = {leg.name: [[0.0, 0.4]] if leg.name.startswith("l") else [[0.5, 0.9]] for leg in hexapod.legs}
    config = GaitConfig.model_validate(
        {"schema": 1, "name": "sides", "description": "", "slowest_period_s": 1.0, "swing": sides})
    # Only the right feet stand, 165 mm from the middle.
    assert checks.balance(hexapod, Gait(config, hexapod)).margin < -0.15


def test_a_foot_falls_behind_its_stride_before_it_is_carried_forward(
    hexapod: RobotModel, gaits: dict[str, Gait]
) -> None:
    """In tripod by more than 10 mm; lifted beside a low body, its tibia would fold beyond its limit."""
    low = replace(hexapod, heights=hexapod.heights._replace(lowest=0.085))
    assert checks.gait_reach(low, gaits["tripod"]).tightest.margin < 0.0
    assert checks.gait_reach(low, gaits["wave"]).tightest.margin > 0.0


def test_reach_of_the_bundled_gaits(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    for gait, top_speed in (("tripod", 0.25), ("ripple", 0.16667), ("wave", 0.06667)):
        reach = checks.gait_reach(hexapod, gaits[gait])
        assert reach.miss == 0.0
        assert reach.tightest.margin > 0.0
        assert 0.9 * top_speed < reach.top_speed <= top_speed + 1e-6
