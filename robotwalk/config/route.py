"""The schema of a path to walk: `robotwalk walk --path FILE`."""

import math
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from robotwalk.config.document import Document
from robotwalk.config.schema import Section

_SAME = 1e-3  # m


class RouteConfig(Section):
    """Waypoints in the frame of the robot as it stands at the start: x ahead, y to the left."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    description: str = ""
    facing: Literal["kept", "ahead"] = "kept"  # the heading of the start, or the way that it goes
    waypoints_m: Annotated[list[tuple[float, float]], Field(min_length=1)]


class Route(NamedTuple):
    """Where to go, from the origin of the start's frame."""

    waypoints: tuple[tuple[float, float], ...]  # m
    ahead: bool = False  # face the way that it goes

    @property
    def points(self) -> list[tuple[float, float]]:
        """The waypoints behind the start."""
        return [(0.0, 0.0), *self.waypoints]


def read_route(path: Path) -> Route:
    """Read a file.

    Raises:
        ConfigError: it cannot be read, is wrong, or a waypoint is where the one before it is.
    """
    document = Document.read(path)
    config = document.validate(RouteConfig)
    before = (0.0, 0.0)
    for index, point in enumerate(config.waypoints_m):
        if math.dist(before, point) < _SAME:
            what = f"waypoint {index - 1}" if index else "the start"
            raise document.error(("waypoints_m", index), f"should be somewhere else than {what}", list(point))
        before = point
    return Route(tuple(config.waypoints_m), config.facing == "ahead")
