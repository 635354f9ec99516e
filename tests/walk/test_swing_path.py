"""A swing path of one's own, and one foot that is lifted higher, in MuJoCo."""

from pathlib import Path

import pytest

from robotwalk import assembly
from robotwalk.loop import Tick

from ..robots import hexapod_that_does_not_feel

PIECES = "[[0, 0], [-0.1, 0.2], [-0.1, 0.9], [0.3, 1.2]], [[0.3, 1.2], [0.6, 1.425], [1.1, 0.6], [1, 0]]"


def test_a_spliced_path_and_a_lift_of_its_own_are_walked(tmp_path: Path) -> None:
    text = hexapod_that_does_not_feel().replace("swing_path: ellipse", f"swing_path: {{bezier: [{PIECES}]}}")
    own = "lm: {rest_mm: [135, 0], max_stride_mm: 100, lift_mm: 45, swing_path: parabola}"
    path = tmp_path / "own.yaml"
    path.write_text(text.replace("    lm: *foot\n", f"    {own}\n"))
    simulation = assembly.simulate(str(path))
    world, highest = simulation.world.world, {"lf": 0.0, "lm": 0.0}

    def watch(tick: Tick) -> None:
        for name in highest:
            highest[name] = max(highest[name], world.data.geom(f"{name}_foot").xpos[2] - 0.009)

    with simulation.robot as robot:
        robot.stand()
        start = simulation.world.truth().base.x
        robot.observers.append(watch)
        robot.walk(vx=0.1, seconds=4.0)
        robot.observers.clear()
        assert simulation.world.truth().base.x - start == pytest.approx(0.4, abs=0.06)
    assert highest["lf"] == pytest.approx(0.030, abs=0.004)
    assert highest["lm"] == pytest.approx(0.045, abs=0.005)
