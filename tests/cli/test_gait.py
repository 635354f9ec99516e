"""`robotwalk gait show`: the gait in numbers and drawn; `walk` refuses what the servos cannot give."""

from pathlib import Path
from xml.etree import ElementTree

import pytest
from PIL import Image

from robotwalk.gait_figure import _NEEDLE, _SWING

from .conftest import Run

OWN = """schema: 1
name: limp
description: one foot swings twice a turn, the others once
slowest_period_s: 2.0
swing:
  lf: [[0.0, 0.15], [0.5, 0.65]]
  rf: [[0.2, 0.35]]
  lr: [[0.7, 0.85]]
  rr: [[0.35, 0.5]]
"""


def test_a_gait_in_numbers_and_drawn(run: Run, tmp_path: Path) -> None:
    result = run("gait", "show", "tripod", "--svg", "t.svg", "--png", "t.png", "--phase", "0.25", "--json")
    assert (result.code, result.err) == (0, "")
    shown = result.json
    assert (shown["schema"], shown["gait"], shown["robot"], shown["refused"]) == (1, "tripod", "hexapod", None)
    assert shown["feet"]["lf"] == {"swing": [[0.0, 0.5]], "duty": 0.5}
    assert [support["standing"] for support in shown["supports"]] == [["lm", "rf", "rr"], ["lf", "lr", "rm"]]
    assert 0.8 < shown["load"] < 1.0
    assert shown["drawn"] == ["t.svg", "t.png"]
    svg = ElementTree.parse(tmp_path / "t.svg").getroot()
    words = [element.text for element in svg.iter("{http://www.w3.org/2000/svg}text")]
    assert words.count("lf") == 2  # below its circle, beside its row
    fills = [element.get("fill") for element in svg.iter()]
    assert fills.count(_SWING) == 12  # a sector and a bar for each foot
    with Image.open(tmp_path / "t.png") as image:
        assert image.width == 1720
        colours = {colour for _, colour in image.convert("RGB").getcolors(1 << 24) or []}
    assert {tuple(bytes.fromhex(colour[1:])) for colour in (_SWING, _NEEDLE)} <= colours


def test_the_figures_of_pseudo_physics_are_drawn(run: Run, tmp_path: Path) -> None:
    result = run("gait", "pseudo-physics", "--period", "0.6", "--svg", "p.svg", "--json")
    assert (result.code, result.json["drawn"]) == (0, ["p.svg"])
    svg = ElementTree.parse(tmp_path / "p.svg").getroot()
    bars = [float(box.get("points", "").split()[1].split(",")[0]) - float(box.get("points", "").split(",")[0])
            for box in svg.iter("{http://www.w3.org/2000/svg}polygon") if box.get("fill") == _SWING]
    assert bars[1:5] == pytest.approx([187.5, 187.5, 250.0, 250.0])  # of a turn of 375: 1/2 and 2/3, twice
    heights = [element.text for element in svg.iter("{http://www.w3.org/2000/svg}text") if "mm" in (element.text or "")]
    assert heights[:3] == ["+110 mm", "-110 mm", "+196 mm"]  # g (T/2)^2 / 8; and g (2T/3)^2 / 8
    assert run("gait", "pseudo-physics").code == 2


def test_ones_own_gait(run: Run, tmp_path: Path) -> None:
    (tmp_path / "limp.yaml").write_text(OWN)
    shown = run("gait", "show", "./limp.yaml", "--json").json
    assert (shown["gait"], shown["robot"]) == ("limp", "quadruped")
    assert shown["feet"]["lf"] == {"swing": [[0.0, 0.15], [0.5, 0.65]], "duty": 0.7}
    (tmp_path / "limp.yaml").write_text(OWN.replace("0.15]", "0.55]"))
    broken = run("gait", "show", "./limp.yaml")
    assert broken.code == 3
    assert broken.err.startswith("limp.yaml:6:7: swing.lf: each sector")


@pytest.mark.parametrize(("words", "complaint"), [
    (["trott"], "no gait 'trott' fits any bundled robot"),
    (["trot", "--robot", "hexapod"], "hexapod has no gait 'trot'; it has"),
    (["trot", "--svg", "a.png"], "a.png should end in .svg"),
    (["trot", "--png", "nowhere/a.png"], "nowhere/a.png cannot be written: No such file"),
    (["trot", "--phase", "2"], "--phase is 0 to 1 turn, not 2"),
])
def test_what_cannot_be_shown(run: Run, words: list[str], complaint: str) -> None:
    result = run("gait", "show", *words)
    assert result.code == 2
    assert complaint in result.err


def test_a_gait_beyond_the_servos_is_refused_with_the_number(run: Run) -> None:
    shown = run("gait", "show", "pronk", "--json").json
    assert shown["load"] > 3.0
    walked = run("walk", "quadruped", "--gait", "pronk")
    assert walked.code == 2
    assert f"quadruped cannot pronk: it asks for {shown['load']:.2f} times what the servos can give" in walked.err
    assert shown["refused"] in walked.err
