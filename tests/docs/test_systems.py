"""The page of all systems: every key is in its table, with its default, and a robot's file may turn each one off."""

import re
from pathlib import Path
from typing import Any

import pytest

from robotwalk import assembly
from robotwalk.config import library
from robotwalk.config.gait_schema import TimingConfig
from robotwalk.config.schema import (
    ContactConfig,
    FeedForwardConfig,
    LocomotionConfig,
    OrientationConfig,
    ReactionConfig,
)

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "systems.md").read_text()
ROWS = dict(re.findall(r"^\| `([\w.]+)` \| ([^|]+?) \|", PAGE, re.MULTILINE))
NO_SYSTEMS = {  # of `locomotion`: what the robot is, not what it does about anything
    "height_mm", "max_speed_mps", "max_turn_deg_s", "acceleration_mps2", "turn_acceleration_deg_s2", "min_swing_s",
    "swing_path", "solver", "feet"}

NO_BOUNDS = {"contact.up_to_mps": "always", "contact.gaits": "all"}  # what a limit is called that is not set


def _defaults() -> dict[str, Any]:
    systems = {key: field.default for key, field in LocomotionConfig.model_fields.items() if key not in NO_SYSTEMS}
    parts = {"contact": ContactConfig, "feed_forward": FeedForwardConfig}
    for section, model in parts.items():
        systems |= {f"{section}.{key}": field.default for key, field in model.model_fields.items()}
    systems["orientation.plumb"] = OrientationConfig.model_fields["plumb"].default
    for key in ("height", "bob", "turn"):
        systems[f"reaction.{key}"] = ReactionConfig.model_fields[key].default
    for key in ("balance", "rocking"):
        systems[f"gait.{key}"] = TimingConfig.model_fields[key].default
    return {key: value for key, value in systems.items() if key not in ("feed_forward", "reaction")}


def test_every_system_is_in_the_table_with_its_default() -> None:
    words = {True: "on", False: "off", None: "off"}  # 0.0, too
    assert set(ROWS) == set(_defaults())
    for key, default in _defaults().items():
        if key in NO_BOUNDS:
            assert (ROWS[key], default) == (NO_BOUNDS[key], None)
        else:
            assert ROWS[key] == words.get(default, f"{default:g}" if isinstance(default, float) else default), key


@pytest.mark.parametrize("line", [
    "feed_forward: {lag: false, load: false}", "hold_course: false", "stability: false",
    "contact: {caution_mm: 0, early_touchdown: false, step_over: false, reach_down_mm: 0, "
    "search: false, slip: false}"])
def test_a_robots_file_may_turn_it_off(line: str, tmp_path: Path) -> None:
    text = library.open_document("robots", "hexapod").text
    if line.startswith("contact"):
        text = re.sub(r"^  contact: .*\n", "", text, flags=re.MULTILINE)
    path = tmp_path / "plain.yaml"
    path.write_text(text.replace("locomotion:\n", f"locomotion:\n  {line}\n"))
    plain, usual = assembly.load(str(path)).model, assembly.load("hexapod").model
    assert plain != usual
    assert plain.leads == ((False, False) if "feed_forward" in line else (True, True))
    assert plain.holds_course is ("hold_course" not in line)
    assert plain.tells_stability is ("stability" not in line)
    assert plain.contact is not None
    assert (plain.contact.caution == 0.0) is ("contact" in line)
