"""The shapes of swings, and what is wrong with a file's."""

import itertools
import math

import pytest

from robotwalk.config import library
from robotwalk.config.document import Document
from robotwalk.config.schema import BezierConfig, RobotConfig
from robotwalk.errors import ConfigError
from robotwalk.swing_paths import SwingPath, swing_path, upper_half

ARCH = "[[0, 0], [0, 1], [1, 1], [1, 0]]"
SPLICED = "[[0, 0], [0, 0.4], [0.1, 0.8], [0.4, 0.8]], [[0.4, 0.8], [1, 0.8], [1.1, 0.4], [1, 0]]"


def read(pieces: str, more: str = "") -> BezierConfig:
    return Document.parse(f"bezier: [{pieces}]\n{more}", "own.yaml").validate(BezierConfig)


def points(path: SwingPath, first: int, last: int) -> list[tuple[float, float]]:
    """Return (way, height) at each hundredth of the progress."""
    found = [path.at(index / 100) for index in range(first, last + 1)]
    return [(point.way.position, point.height.position) for point in found]


def test_the_ellipse_of_arth_figure_3() -> None:
    path = swing_path("ellipse")
    # A swing is 0 to 50 % of it; percentages of the whole path, twice a hundredth of the progress each.
    trace = points(path, 0, 200)
    assert max(range(201), key=lambda i: trace[i][1]) == 50  # highest at 25 %
    assert max(range(201), key=lambda i: trace[i][0]) == 100  # farthest at 50 %
    assert min(range(201), key=lambda i: trace[i][1]) == 150
    assert [trace[i] for i in (0, 50, 100, 150, 200)] == [
        pytest.approx(point, abs=1e-12) for point in ((0, 0), (0.5, 1), (1, 0), (0.5, -1), (0, 0))]


def test_the_first_half_is_the_half_ellipse_its_ends_rounded() -> None:
    assert points(swing_path("half_ellipse"), 0, 100) == points(swing_path("ellipse"), 0, 100)
    assert points(swing_path("half_ellipse"), 150, 150) == [(1.0, 0.0)]
    # An upright start would be 2 sqrt(w (1 - w)): 0.6 at a tenth of the way.
    assert upper_half(0.1).height.position == pytest.approx(0.5440, abs=1e-4)
    assert upper_half(0.25).height.position == pytest.approx(0.8464, abs=1e-4)


def test_the_parabola_of_pps() -> None:
    for way, height in points(swing_path("parabola"), 0, 100):
        assert height == pytest.approx(4.0 * way * (1.0 - way))


def test_a_bezier_path_is_as_high_as_the_lift_and_goes_where_its_points_say() -> None:
    path = swing_path(read(ARCH))
    trace = points(path, 0, 100)
    assert max(height for _, height in trace) == pytest.approx(1.0, abs=1e-6)
    assert trace[50] == pytest.approx((0.5, 1.0))
    assert trace[0] == (0.0, 0.0)
    assert trace[100] == (1.0, 0.0)
    # De Casteljau at a quarter: way 3 (1/4)^2 (3/4) + (1/4)^3; height 3 (1/4) (3/4) of 3/4 at the apex.
    assert path.at(0.3594).way.position == pytest.approx(0.15625, abs=1e-3)
    assert path.at(0.3594).height.position == pytest.approx(0.75, abs=1e-3)


@pytest.mark.parametrize("path", [
    swing_path("parabola"), swing_path("half_ellipse"), swing_path("ellipse"), swing_path(read(ARCH)),
    swing_path(read(SPLICED, "retraction: [[[1, 0], [1, -0.5], [0, -0.5], [0, 0]]]"))])
def test_slopes_and_curvatures_are_those_of_the_path(path: SwingPath) -> None:
    step = 1e-6
    for index in range(1, 200):
        progress = index / 100 + 0.003
        before, now, after = (path.at(progress + change) for change in (-step, 0.0, step))
        for axis in (0, 1):
            slope = (after[axis].position - before[axis].position) / (2.0 * step)
            assert now[axis].velocity == pytest.approx(slope, abs=1e-4)
            bend = (after[axis].velocity - before[axis].velocity) / (2.0 * step)
            assert now[axis].acceleration == pytest.approx(bend, abs=1e-2)


def test_where_pieces_meet_the_velocity_is_one() -> None:
    path = swing_path(read(SPLICED))
    slopes = [path.at(index / 10000) for index in range(10001)]
    turns = [
        math.dist((a.way.velocity, a.height.velocity), (b.way.velocity, b.height.velocity))
        for a, b in itertools.pairwise(slopes)]
    assert max(turns) < 0.01


@pytest.mark.parametrize(("written", "complaint"), [
    ("elipse", "locomotion.swing_path: expected 'parabola', 'half_ellipse' or 'ellipse' (got 'elipse')"),
    ("{bezir: 1}", "locomotion.swing_path: unknown key 'bezir': did you mean 'bezier'?"),
])
def test_a_mistake_in_a_robots_file_has_one_sentence(written: str, complaint: str) -> None:
    text = (library.root() / "robots" / "hexapod.yaml").read_text()
    with pytest.raises(ConfigError) as error:
        Document.parse(text.replace("swing_path: ellipse", f"swing_path: {written}"), "own.yaml").validate(RobotConfig)
    line = text[: text.index("swing_path: ")].count("\n") + 1
    assert str(error.value).startswith(f"own.yaml:{line}:")
    assert str(error.value).endswith(complaint)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(("pieces", "what"), [
    ("[[0, 0], [0, 1], [1, 1], [0.9, 0]]", "bezier: should lead from [0.0, 0.0] to [1.0, 0.0]"),
    ("[[0, 0], [0, 1], [0.4, 1], [0.5, 1]], [[0.6, 1], [0.7, 1], [1, 1], [1, 0]]",
     "bezier: piece 2 should begin at [0.5, 1.0], where piece 1 ends"),
    ("[[0, 0], [0, 1], [0.4, 1], [0.5, 1]], [[0.5, 1], [0.7, 1.2], [1, 1], [1, 0]]",
     "bezier: piece 2 should go on in the direction in which piece 1 ends"),
    ("[[0, 0], [0, 1], [0.4, 1], [0.5, 1]], [[0.5, 1], [0.5, 1], [1, 1], [1, 0]]",
     "bezier: piece 2 should go on in the direction in which piece 1 ends"),
    ("[[0, 0], [0, 0], [1, 0], [1, 0]]", "should rise above the ground"),
])
def test_unsound_pieces(pieces: str, what: str) -> None:
    with pytest.raises(ConfigError) as error:
        read(pieces)
    assert str(error.value).startswith("own.yaml:1:")
    assert what in str(error.value)
