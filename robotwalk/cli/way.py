"""Where `robotwalk walk` goes, and how, as people type it."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from robotwalk.cli.outing import Plan
from robotwalk.config.route import Route, read_route
from robotwalk.errors import UsageError
from robotwalk.track import Track

_DURATION = 10.0  # s
_LONGER = 2.0  # times what a way takes at the commanded speed, and _DURATION more, before it is given up


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Way:
    """One way to walk, in metres, seconds and degrees.

    Attributes:
        gait: A name from `robotwalk list gaits`. Default: the first that it has of tripod, tetrapod, trot and wave.
        speed: Metres per second.
        direction: Of travel relative to the body, degrees: 0 ahead, 90 to the left.
        heading: Where the body shall face, degrees to the left of its start. It turns there and holds it.
        turn: A turning rate instead, degrees per second to the left.
        goto: X,Y: walk straight to there, metres ahead and to the left of the start, and end. The heading is kept, or
            is that of --heading. Where it is the robot knows from its legs alone.
        path: Walk along the waypoints of this YAML file instead, and end at the last.
        height: Of the body above the ground, metres.
        period: Of the gait, seconds, as far as strides and servos allow. Default: as slow as the speed allows.
        duration: Seconds of walking; standing up and sitting down come on top. Default: 10; with --goto or --path,
            where it is the most that the way may take, 10 more than twice what it takes at that speed.
    """

    gait: str | None = None
    speed: float = 0.1
    direction: float = 0.0
    heading: float | None = None
    turn: float | None = None
    goto: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    path: Path | None = None
    height: float | None = None
    period: float | None = None
    duration: float | None = None

    def plan(self) -> Plan:
        """Return it in SI units and radians.

        Raises:
            UsageError: an option makes no sense, or two exclude each other.
            ConfigError: the file of --path is wrong.
        """
        route = self._route()
        self._require_one_way(route)
        self._require_finite()
        plan = Plan(
            speed=abs(self.speed), direction=math.radians(self.direction + (180.0 if self.speed < 0.0 else 0.0)),
            heading=None if self.heading is None else math.radians(self.heading),
            turn=math.radians(self.turn or 0.0), height=self.height,
            duration=_DURATION if self.duration is None else self.duration, gait=self.gait, period=self.period)
        return plan if route is None else self._along(route, plan)

    def _route(self) -> Route | None:
        """Return where to go, if that is told."""
        if self.goto is not None and self.path is not None:
            raise UsageError("--goto and --path exclude each other")
        if self.path is not None:
            return read_route(self.path)
        if self.goto is None:
            return None
        try:
            x, y = (float(number) for number in self.goto.split(","))
        except ValueError as error:
            raise UsageError(f"--goto should be X,Y in metres, such as 1.5,-0.3, not {self.goto!r}") from error
        if not (math.isfinite(x) and math.isfinite(y)) or x == y == 0.0:
            raise UsageError(f"--goto should be finite and somewhere else than the start, not {self.goto!r}")
        return Route(((x, y),))

    def _require_one_way(self, route: Route | None) -> None:
        """Raise UsageError if two options tell where to go, or to face."""
        if self.turn is not None and self.heading is not None:
            raise UsageError("--turn and --heading exclude each other: one is a rate, the other an angle to hold")
        if route is not None and (self.turn is not None or self.direction != 0.0):
            raise UsageError("--goto and --path tell where to go: leave out --direction and --turn")
        if route is not None and route.ahead and self.heading is not None:
            raise UsageError("--heading and the `facing: ahead` of --path exclude each other")

    def _require_finite(self) -> None:
        for option in ("speed", "direction", "heading", "turn", "height", "period", "duration"):
            value = getattr(self, option)
            if value is not None and not math.isfinite(value):
                raise UsageError(f"--{option} should be a finite number, not {value}")

    def _along(self, route: Route, plan: Plan) -> Plan:
        """Return a plan that goes along a route, in the time that it may take."""
        if self.speed <= 0.0:
            raise UsageError(f"--speed should be above 0 with --goto and --path, not {self.speed}")
        x, y = route.waypoints[0]
        longest = _LONGER * Track(route.points).length / self.speed + _DURATION
        return plan._replace(
            route=route, direction=math.atan2(y, x), duration=longest if self.duration is None else self.duration)
