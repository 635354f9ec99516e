"""A hexapod that stands and is shoved: it stands well again, and no servo is overloaded by how its feet stayed."""

import math
from typing import Any

from robotwalk import assembly
from robotwalk.body import seen_from
from robotwalk.types import Vec3


def test_feet_that_a_shove_has_dragged_step_back_to_rest() -> None:
    simulation = assembly.simulate("hexapod")
    world, model = simulation.world.world, simulation.blueprint.model
    geoms = [world.model.geom(f"{leg.name}_foot").id for leg in model.legs]

    def off() -> float:
        """Return how far the farthest foot really is from rest, m."""
        feet = seen_from(simulation.world.truth().base, [Vec3(*world.data.geom_xpos[geom].tolist()) for geom in geoms])
        return max(math.dist(foot[:2], leg.rest_foot[:2]) for foot, leg in zip(feet, model.legs, strict=True))

    margins: list[float] = []

    def watch(tick: Any) -> None:
        if not all(tick.wanted.planted):
            margins.append(tick.stability.margin)

    with simulation.robot as robot:
        robot.stand()
        robot.observers.append(watch)
        world.push(Vec3(0.0, 20.0, 0.0))
        robot.walk(seconds=0.5)
        world.push(Vec3(0.0, -20.0, 0.0))
        robot.walk(seconds=0.1)
        assert off() > 0.04
        robot.walk(seconds=3.5)
        assert off() < 0.015
        kinds = [event.kind for event in robot.events]
        assert kinds.count("stance") in (1, 2, 3)
        assert "mend" not in kinds  # without the reflex a coxa is overloaded 2 s later, and lets go
        assert min(margins) > 0.06
        assert abs(simulation.world.truth().base.roll) < math.radians(2.5)
