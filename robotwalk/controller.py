"""Joins the stages: a command and a state in, joint angles out."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from robotwalk.body import Body, seen_from
from robotwalk.estimator import Estimate
from robotwalk.gait import Gait, GaitClock
from robotwalk.kinematics import solver_for
from robotwalk.model import RobotModel
from robotwalk.stepping import Footfalls, Stepping
from robotwalk.supervisor import State
from robotwalk.types import LEVEL, STILL, Command, Pose, Twist
from robotwalk.unfold import Unfold
from robotwalk.velocity import Shaped, VelocityShaper

_HEADING_GAIN = 2.0  # rad/s per rad off the heading


class Wanted(NamedTuple):
    """What the controller wants in this tick."""

    angles: Sequence[float]  # rad, in joint order
    twist: Twist  # of the body in its base frame
    scale: float  # feasible twist / commanded twist
    planted: tuple[bool, ...]
    reach_error: float  # m, the farthest that a leg is short of its target
    standing: bool  # at its height, all feet at rest
    seated: bool  # lowered, all feet at rest


class Controller:
    """Walks one robot. It knows nothing of servos, and time passes only by `step`."""

    def __init__(self, model: RobotModel, gaits: Mapping[str, Gait], default_gait: str) -> None:
        self._model = model
        self._gaits = gaits
        self._default_gait = default_gait
        self._solvers = tuple(solver_for(leg) for leg in model.legs)
        self._shaper = VelocityShaper(model.motion)
        self._clock = GaitClock(gaits[default_gait])
        self._body = Body(model.heights.sit)
        self._stepping = Stepping(model, self._body.course)
        self._unfold: Unfold | None = None
        self._idle = True

    def start(self, positions: Sequence[float]) -> None:
        """Take over a seated robot whose joints are at `positions` (rad); it will hold them until it stands."""
        model = self._model
        self._shaper = VelocityShaper(model.motion)
        self._body = Body(model.heights.sit)
        self._stepping = Stepping(model, self._body.course)
        seated, _ = self._angles(self._stepping.footfalls())
        self._unfold = Unfold(positions, seated)

    def step(self, state: State, command: Command, estimate: Estimate, dt: float) -> Wanted:
        """Advance by `dt` s."""
        unfold = self._unfold
        if unfold is not None and not unfold.done:
            angles = unfold.step(dt if state is State.STAND else 0.0)
            seated = state in (State.SIT, State.FAULT)
            return Wanted(angles, STILL, 1.0, self._stepping.footfalls().planted, 0.0, False, seated)
        bearable = self._stepping.bearable(self._clock, self._body.course, self._shaper.twist)
        shaped = self._shape(state, command, estimate, bearable, dt)
        height, posture = self._carriage(state, command)
        self._body.step(shaped.twist, height, posture, dt)
        footfalls = self._step_feet(shaped.twist, bearable, dt)
        angles, reach_error = self._angles(footfalls)
        settled = self._idle and self._body.settled(height, posture)
        lowered = height == self._model.heights.sit
        return Wanted(
            angles, shaped.twist, shaped.scale, footfalls.planted, reach_error,
            standing=settled and not lowered, seated=settled and lowered)

    def _shape(
        self, state: State, command: Command, estimate: Estimate, bearable: float, dt: float
    ) -> Shaped:
        twist = command.twist if state is State.WALK else STILL
        if state is State.WALK and command.heading is not None:
            turn = _HEADING_GAIN * (command.heading - estimate.pose.yaw)
            limit = self._model.motion.turn
            twist = twist._replace(wz=min(max(turn, -limit), limit))
        gait, now = self._gaits[command.gait or self._default_gait], self._shaper.twist
        # A slower gait takes over once the body is slow enough for it.
        if gait is not self._clock.gait and gait.largest_scale(now) >= 1.0:
            self._stepping.change_gait(self._clock, gait, self._body.course, now)
        return self._shaper.step(twist, gait, dt, bearable)

    def _carriage(self, state: State, command: Command) -> tuple[float, Pose]:
        """Return the height and the posture to go for; down only once the feet are at rest."""
        heights = self._model.heights
        if state not in (State.STAND, State.WALK) and self._idle:
            return heights.sit, LEVEL
        height = heights.stand if command.height is None else command.height
        return min(max(height, heights.lowest), heights.highest), command.posture

    def _step_feet(self, twist: Twist, bearable: float, dt: float) -> Footfalls:
        """Turn the needle and move the feet; with the body still and all feet at rest, do neither."""
        course = self._body.course
        if twist == STILL and self._stepping.settled(course):
            self._idle = True
            return self._stepping.footfalls()
        if self._idle:
            self._idle = False
            self._clock.rewind()
        else:
            self._clock.advance(twist, dt, bearable)
        return self._stepping.step(self._clock, course, twist, dt)

    def _angles(self, footfalls: Footfalls) -> tuple[list[float], float]:
        angles: list[float] = []
        miss = 0.0
        for solver, foot in zip(self._solvers, seen_from(self._body.pose, footfalls.centres), strict=True):
            solution = solver.solve(*foot)
            angles.extend(solution.angles)
            miss = max(miss, solution.miss)
        return angles, miss


def twist_of(speed: float, direction: float, turn: float) -> Twist:
    """Return the twist for a speed (m/s) in a direction relative to the body (rad, 0 ahead) and a turn (rad/s)."""
    return Twist(speed * math.cos(direction), speed * math.sin(direction), turn)
