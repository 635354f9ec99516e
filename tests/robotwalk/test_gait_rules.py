"""What the library's gaits are: which feet are in the air, when, and by which formula."""

import itertools
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotwalk import assembly
from robotwalk.config import library
from robotwalk.config.document import Document
from robotwalk.errors import ConfigError
from robotwalk.gait import Gait
from robotwalk.gait_rules import by_offsets, in_pairs, read_gait, wave
from robotwalk.model import Leg
from robotwalk.oscillator import lift, skewed, swing_share
from robotwalk.types import Vec3

from .conftest import load_model

# The order of lift-offs round the circle, feet that lift off together in one string; and the share of the circle that
# a foot stands.
LIBRARY = {
    ("hexapod", "tripod"): ("lf lr rm, lm rf rr", 1 / 2),
    ("hexapod", "tetrapod"): ("lf rm, lr rf, lm rr", 2 / 3),
    ("hexapod", "ripple"): ("lr, rf, lm, rr, lf, rm", 2 / 3),
    ("hexapod", "stroll"): ("lf lr rm, lm rf rr", 0.5624),
    ("hexapod", "free"): ("lf lr rm, lm rf rr", 0.6494),
    ("hexapod", "wave"): ("lr, lm, lf, rr, rm, rf", 5 / 6),
    ("hexapod", "limp"): ("lr, lm, lf, rr, rm, rf", 5 / 6),
    ("octopod", "tetrapod"): ("lf lmr rmf rr, lmf lr rf rmr", 1 / 2),
    ("octopod", "ripple"): ("lf rmr, lr rmf, lmr rf, lmf rr", 3 / 4),
    ("octopod", "wave"): ("lr, lmr, lmf, lf, rr, rmr, rmf, rf", 7 / 8),
    ("octopod", "limp"): ("lr, lmr, lmf, lf, rr, rmr, rmf, rf", 7 / 8),
    ("pentapod", "wave"): ("lr, lf, f, rr, rf", 4 / 5),
    ("pentapod", "limp"): ("lr, lf, f, rr, rf", 4 / 5),
    ("quadruped", "wave"): ("lr, lf, rr, rf", 0.84),
    ("quadruped", "crawl"): ("lr, lf, rr, rf", 0.84),
    ("quadruped", "pace"): ("lf lr, rf rr", 0.64),
    ("quadruped", "bound"): ("lf rf, lr rr", 0.4),
    ("quadruped", "gallop"): ("lf, rf, lr, rr", 0.35),
    ("quadruped", "rotary_gallop"): ("lf, rf, rr, lr", 0.35),
    ("quadruped", "pronk"): ("lf lr rf rr", 0.4),
    ("quadruped", "amble"): ("lf, rr, rf, lr", 3 / 4),
    ("quadruped", "free"): ("lf rr, lr rf", 0.6897),
    ("quadruped", "trot"): ("lf rr, lr rf", 0.58),
}


@pytest.fixture(scope="module")
def fitting() -> Mapping[str, Mapping[str, Gait]]:
    """The gaits of each robot that the table names."""
    return {robot: assembly.load(robot).gaits for robot in {robot for robot, _ in LIBRARY}}


@pytest.mark.parametrize(("robot", "name"), LIBRARY)
def test_a_gait_of_the_library(fitting: Mapping[str, Mapping[str, Gait]], robot: str, name: str) -> None:
    order, duty = LIBRARY[robot, name]
    legs, gait = [leg.name for leg in assembly.load(robot).model.legs], fitting[robot][name]
    lifts: dict[float, set[str]] = {}
    for leg, sectors in zip(legs, gait.feet, strict=True):
        assert sum(sector.stance for sector in sectors) == pytest.approx(duty, abs=1e-4)
        for sector in sectors:
            lifts.setdefault(round(sector.start, 6) % 1.0, set()).add(leg)
    turns = [" ".join(sorted(lifts[start])) for start in sorted(lifts)]
    wanted = [" ".join(sorted(feet.split())) for feet in order.split(", ")]
    first = turns.index(wanted[0])
    assert turns[first:] + turns[:first] == wanted


def test_each_robot_has_all_gaits_of_its_kind(fitting: Mapping[str, Mapping[str, Gait]]) -> None:
    for robot, gaits in fitting.items():
        assert set(gaits) == {name for owner, name in LIBRARY if owner == robot}


LEG = load_model("hexapod").legs[0]


def ring(count: int) -> list[Leg]:
    """Return legs around a body, the first straight ahead."""
    leg = LEG
    angles = [math.tau * index / count for index in range(count)]
    return [
        replace(leg, name=f"leg{index}", rest_foot=Vec3(math.cos(angle), math.sin(angle), 0.0))
        for index, angle in enumerate(angles)]


@given(st.integers(3, 24), st.floats(0.0, 0.4))
def test_a_wave_of_any_number_of_feet_lifts_one_at_a_time_each_for_as_long(count: int, pause: float) -> None:
    sectors = sorted(sector for (sector,) in wave(ring(count), pause).values())
    assert len(sectors) == count
    for (_, end), (start, _) in zip(sectors, [*sectors[1:], (1.0, 0.0)], strict=True):
        assert end <= start + 1e-9
    assert [end - start for start, end in sectors] == pytest.approx([(1.0 - 2.0 * pause) / count] * count, abs=1e-9)


@given(st.integers(2, 6), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_the_two_offsets_add_up(rows: int, front_back: float, left_right: float) -> None:
    pairs = in_pairs([leg for leg in ring(2 * rows + 2) if abs(leg.rest_foot.y) > 0.01])
    assert pairs is not None
    swing = by_offsets(pairs, front_back, left_right, 0.3)

    def later(leg: Leg, than: Leg) -> float:
        return swing[leg.name][0][0] - swing[than.name][0][0]

    def same(turns: float, others: float) -> bool:
        return abs(math.remainder(turns - others, 1.0)) < 1e-6

    for (left, right), (left_behind, right_behind) in itertools.pairwise(pairs):
        assert same(later(right, left), left_right)
        assert same(later(left_behind, left), front_back)
        assert same(later(right_behind, left), front_back + left_right)


def test_feet_that_are_not_in_pairs_have_no_gait_by_offsets() -> None:
    assert in_pairs(ring(5)) is None
    assert in_pairs(ring(6)) is None  # one straight ahead, one behind
    assert in_pairs(ring(6)[:3]) is None


@given(st.floats(-4.0, 4.0))
def test_a_foot_is_in_the_air_for_as_long_as_its_wave_is_positive(bias: float) -> None:
    samples = [lift(math.tau * (index + 0.5) / 5000, bias) > 0.0 for index in range(5000)]
    assert sum(samples) / 5000 == pytest.approx(swing_share(bias), abs=1e-3)


@pytest.mark.parametrize(("text", "complaint"), [
    ("kind: waves\n", "own.yaml:1:7: kind: expected one of sectors, wave, offsets, oscillator, stepping (got 'waves')"),
    ("kind: wave\npaus: 0.1\n", "own.yaml:2:1: unknown key 'paus': did you mean 'pause'?"),
    ("kind: offsets\nlegs: 5\n", "own.yaml:2:7: legs: expected a multiple of 2 (got 5)"),
    ("kind: wave\nlegs: [6, 5]\n", "own.yaml:2:7: legs: should be [fewest, most] (got [6, 5])"),
])
def test_a_gait_that_is_not_what_its_kind_asks_for(text: str, complaint: str) -> None:
    with pytest.raises(ConfigError) as error:
        read_gait(Document.parse(text, "own.yaml"))
    assert complaint in str(error.value)


@given(st.floats(-3.0, 3.0), st.floats(0.01, 0.99))
def test_a_foot_swings_by_both_waves_and_their_derivatives_are_true(bias: float, progress: float) -> None:
    before, here, after = (skewed(progress + step, bias) for step in (-1e-4, 0.0, 1e-4))
    for axis in ("way", "height"):
        low, now, high = (getattr(point, axis) for point in (before, here, after))
        assert now.velocity == pytest.approx((high.position - low.position) / 2e-4, rel=1e-3, abs=1e-3)
        assert now.acceleration == pytest.approx((high.velocity - low.velocity) / 2e-4, rel=1e-3, abs=1e-2)
    assert skewed(0.0, bias).way.position == pytest.approx(0.0)
    assert skewed(1.0, bias).way.position == pytest.approx(1.0)
    assert skewed(0.5, bias).height.position == pytest.approx(1.0)


def test_a_robot_of_ones_own_has_the_gaits_beside_it(tmp_path: Path) -> None:
    (tmp_path / "gaits").mkdir()
    (tmp_path / "own.yaml").write_text(library.open_document("robots", "quadruped").text)
    (tmp_path / "gaits" / "limp.yaml").write_text(
        "schema: 1\nname: limp\ndescription: x\nslowest_period_s: 2\n"
        "swing: {lf: [[0, 0.1], [0.5, 0.6]], rf: [[0.2, 0.3]], lr: [[0.7, 0.8]], rr: [[0.3, 0.4]]}\n")
    gaits = assembly.load(str(tmp_path / "own.yaml")).gaits
    assert {"limp", "trot"} <= set(gaits)
    assert len(gaits["limp"].feet[0]) == 2
