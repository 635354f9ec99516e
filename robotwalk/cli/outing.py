"""One walk from chair to chair, watched: what `robotwalk walk` reports."""

import hashlib
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from robotwalk import assembly
from robotwalk.behaviours import Facing, FollowPath
from robotwalk.body import placed
from robotwalk.cli.imu_report import ImuReport
from robotwalk.command_check import check_command, check_duration
from robotwalk.config.route import Route
from robotwalk.controller import twist_of
from robotwalk.journey import Journey, Summary
from robotwalk.loop import Tick
from robotwalk.supervisor import State
from robotwalk.timing import Histogram
from robotwalk.types import BusStatistics, Command, Pose, SensorStatistics, Vec3
from robotwalk.velocity import feasible

_GRAVITY = 9.81  # m/s^2
_SITTING_AND_STANDING = 6.0  # s, roughly; only the progress bar relies on it

Progress = Callable[[str, float], None]


class Plan(NamedTuple):
    """What to do, in SI units and radians."""

    speed: float
    direction: float
    heading: float | None
    turn: float
    height: float | None
    duration: float
    gait: str | None
    route: Route | None = None  # to walk by, in place of direction and turn; until there or `duration` has passed
    period: float | None = None


def require_possible(plan: Plan, blueprint: assembly.Blueprint) -> None:
    """Check a plan before anything is opened.

    Raises:
        UsageError: it makes no sense for this robot.
    """
    twist = twist_of(plan.speed, plan.direction, plan.turn)
    command = Command(
        twist, plan.heading, plan.height, gait=plan.gait or blueprint.default_gait, period=plan.period)
    check_command(command, blueprint.model, tuple(blueprint.gaits), blueprint.refused)
    check_duration(plan.duration)


class Outing:
    """Walks a robot by a plan. Distances count from the end of standing up to the start of sitting down.

    What happens is the simulation's truth where there is one, else what odometry makes of it.
    """

    def __init__(self, session: assembly.Session, plan: Plan, *, film: bool = False, view: bool = False) -> None:
        """Prepare a plan that is possible.

        Raises:
            UsageError: the viewer is not installed.
        """
        self._robot = session.robot
        self._world = session.world if isinstance(session, assembly.Simulation) else None
        self._plan = plan
        self._gait = session.blueprint.gaits[plan.gait or session.blueprint.default_gait]
        wanted = twist_of(plan.speed, plan.direction, plan.turn)
        self._twist, self._scale = feasible(wanted, self._robot.model.motion, self._gait)
        self._measuring = False
        self._truth = self._odometry = Journey(Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), direction=0.0, nominal_height=0.0)
        self._arrived = False
        self._energy = 0.0
        self._margin = math.inf  # m, the least so far; below all numbers once too few feet stood for any
        self._imu = ImuReport()
        self._ticks = self._walking_ticks = 0
        self._wall = 0.0
        self._film = assembly.film(self._world) if film and self._world else None
        self._viewer = assembly.viewer(self._world) if view and self._world else None
        self._progress: Progress = lambda text, share: None

    def run(self, progress: Progress) -> None:
        """Stand up, walk, stop, sit.

        Raises:
            SafetyStop, KeyboardInterrupt, SystemExit: it ended early; the robot sits, or is frozen.
        """
        robot = self._robot
        self._progress = progress
        robot.observers.append(self._watch)
        if self._viewer is not None:
            self._viewer.wait_for_browser()
        began = time.perf_counter()
        try:
            with robot:
                robot.stand()
                self._note_scaling()
                self._begin()
                try:
                    self._go()
                finally:
                    self._end()
        finally:
            self._wall = time.perf_counter() - began
            self._note_cuts()
            if self._viewer is not None:
                self._viewer.close()

    def _go(self) -> None:
        robot, plan = self._robot, self._plan
        if plan.route is None:
            robot.walk(
                *self._twist, seconds=plan.duration, gait=plan.gait, heading=plan.heading, height=plan.height,
                period=plan.period)
            return
        start = robot.state.odometry
        facing: Facing = "ahead" if plan.route.ahead else start.yaw + (plan.heading or 0.0)
        waypoints = [placed(start, Vec3(x, y, 0.0)) for x, y in plan.route.waypoints]
        self._arrived = robot.follow(
            FollowPath(waypoints, speed=plan.speed, facing=facing),
            seconds=plan.duration, gait=plan.gait, height=plan.height, period=plan.period)

    def save_film(self, path: Path, progress: Callable[[float], None]) -> None:
        """Draw the film of what happened."""
        if self._film is not None:
            self._film.save(path, progress)

    def report(self) -> dict[str, Any]:
        """Return the fields of `walk --json`."""
        loop, model = self._robot.loop, self._robot.model
        truth, odometry = self._truth.summary(), self._odometry.summary()
        seconds = self._walking_ticks / loop.rate_hz
        simulated, switches = self._world is not None, self._robot.foot_switch_statistics()
        work = model.mass * _GRAVITY * abs(truth.distance)
        return {
            "robot": model.name,
            "gait": self._gait.name,
            "backend": "sim" if simulated else "bus",
            "rate_hz": loop.rate_hz,
            "duration_s": round(seconds, 3),
            "ticks": self._ticks,
            "commanded": {"vx": self._twist.vx, "vy": self._twist.vy, "wz": self._twist.wz},
            "distance_m": truth.distance,
            "displacement": {
                "x": truth.displacement.x, "y": truth.displacement.y, "z": truth.displacement.z,
                "yaw_deg": math.degrees(truth.displacement.yaw)},
            "heading_change_deg": math.degrees(truth.displacement.yaw),
            "speed_mps": truth.distance / seconds if seconds else 0.0,
            "lateral_drift_m": self._drift(truth) if self._straight else None,
            "goal": self._goal(truth.displacement),
            "max_tilt_deg": math.degrees(truth.max_tilt) if simulated or self._imu.heard else None,
            "min_height_m": truth.min_height,
            "fell": truth.fell,
            "min_stability_margin_m": self._margin if math.isfinite(self._margin) else None,
            "odometry": {
                "distance_m": odometry.distance, "heading_change_deg": math.degrees(odometry.displacement.yaw)},
            "energy_j": self._energy if simulated else None,
            "cost_of_transport": self._energy / work if simulated and work > 0.0 else None,
            "bus": {
                name: _in_ms(line) for name, line in self._robot.bus_statistics().items()
            },
            **self._imu.fields(self._robot.imu_statistics()),
            **({"foot_switches": _in_ms(switches)} if switches is not None else {}),
            "timing": {
                "missed_deadlines": loop.missed,
                "wake_us": _rounded(loop.wake), "tick_us": _rounded(loop.compute), "bus_us": _rounded(loop.exchange)},
            "wall_s": round(self._wall, 3),
            "realtime_factor": round(self._ticks / loop.rate_hz / self._wall, 2) if self._wall else 0.0,
            "events": [event._asdict() for event in self._robot.events],
            "state_hash": self._hash(),
        }

    def _begin(self) -> None:
        self._measuring = True
        plan = self._plan
        nominal = plan.height or self._robot.model.heights.stand
        along = plan.route.points if plan.route is not None else ()
        self._truth = Journey(*self._place(), direction=plan.direction, along=along, nominal_height=nominal)
        self._odometry = Journey(
            self._robot.state.odometry, direction=plan.direction, along=along, nominal_height=nominal)
        self._energy = -self._energy_so_far()

    def _end(self) -> None:
        self._measuring = False
        self._energy += self._energy_so_far()

    def _place(self) -> tuple[Pose, float]:
        """Return where the body is, and how high the ground is under it."""
        if self._world is None:
            return self._robot.state.odometry, 0.0
        truth = self._world.truth()
        return truth.base, truth.ground

    def _energy_so_far(self) -> float:
        return self._world.truth().energy if self._world is not None else 0.0

    def _watch(self, tick: Tick) -> None:
        """Follow one tick."""
        self._ticks += 1
        rate = self._robot.loop.rate_hz
        if self._measuring:
            self._walking_ticks += tick.state is State.WALK
            if not self._robot.loop.low:  # to lie down is no fall
                self._truth.add(*self._place())
                self._odometry.add(tick.estimate.pose)
            if tick.state is State.WALK:
                margin = tick.stability.margin if tick.stability is not None else None
                self._margin = -math.inf if margin is None else min(self._margin, margin)
            self._imu.add(tick.estimate.imu)
        if self._ticks % max(rate // 10, 1) == 0:
            elapsed = self._ticks / rate
            self._progress(
                f"{tick.state.value} {self._walking_ticks / rate:4.1f} s",
                min(elapsed / (self._plan.duration + _SITTING_AND_STANDING), 1.0))
        if self._film is not None and self._world is not None and self._film.due(self._ticks / rate):
            self._film.shoot(self._world.world.data, self._caption(tick))
        if self._viewer is not None:
            self._viewer.update(self._ticks / rate)

    def _caption(self, tick: Tick) -> str:
        speed = math.hypot(tick.wanted.twist.vx, tick.wanted.twist.vy)
        seconds = self._ticks / self._robot.loop.rate_hz
        return f"{self._robot.model.name}  {self._gait.name}  {speed:.2f} m/s   t {seconds:.1f} s"

    def _note_scaling(self) -> None:
        if self._scale < 1.0:
            vx, vy, wz = self._twist
            self._robot.note(
                "scaled",
                f"that is more than {self._robot.model.name} can do in {self._gait.name}: scaled by {self._scale:.2f}, "
                f"to {math.hypot(vx, vy):.3f} m/s and {math.degrees(wz):.1f} deg/s")

    def _note_cuts(self) -> None:
        cuts = self._robot.loop.cuts
        if cuts:
            what = ", ".join(f"{joint} {kind} {count}" for (joint, kind), count in cuts.most_common(4))
            more = "" if len(cuts) <= 4 else f" and {len(cuts) - 4} more"
            self._robot.note("limits", f"the limits cut {cuts.total()} goals: {what}{more}")

    @property
    def _straight(self) -> bool:
        """Whether it was to go in a straight line."""
        plan = self._plan
        if plan.route is not None:
            return len(plan.route.waypoints) == 1
        return plan.turn == 0.0 and plan.heading is None

    def _goal(self, displacement: Pose) -> dict[str, Any] | None:
        """Return what came of the way to a goal, if there was one."""
        if self._plan.route is None:
            return None
        x, y = self._plan.route.waypoints[-1]
        return {
            "x": x, "y": y, "reached": self._arrived, "miss_m": math.hypot(displacement.x - x, displacement.y - y)}

    def _drift(self, summary: Summary) -> float:
        course = self._plan.direction
        return summary.displacement.y * math.cos(course) - summary.displacement.x * math.sin(course)

    def _hash(self) -> str:
        """Hash all that was read and sent, and the true state at the end where it is known."""
        truth = self._world.truth() if self._world is not None else None
        return hashlib.sha256(f"{self._robot.loop.digest()} {truth}".encode()).hexdigest()


def _in_ms(line: BusStatistics | SensorStatistics) -> dict[str, Any]:
    """Return the fields of a line, its largest age in ms."""
    fields = line._asdict()
    return fields | {"max_age_ms": 1e3 * fields.pop("max_age")}


def _rounded(histogram: Histogram) -> dict[str, float]:
    return histogram.percentiles()._asdict()
