"""Joins the stages: a command and a state in, joint angles out."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from robotwalk.body import Body, seen_from, up_axis
from robotwalk.estimator import Estimate
from robotwalk.gait import Gait, GaitClock
from robotwalk.kinematics import solver_for
from robotwalk.levelling import Levelling
from robotwalk.model import RobotModel
from robotwalk.reaction import Reaction
from robotwalk.rocking import Rocking
from robotwalk.steering import Steering
from robotwalk.stepping import Footfalls, Stepping
from robotwalk.supervisor import State
from robotwalk.sway import Sway
from robotwalk.types import LEVEL, STILL, Command, Pose, Twist
from robotwalk.unfold import Unfold
from robotwalk.velocity import Propulsion, Shaped, VelocityShaper

_HEADING_GAIN = 2.0  # rad/s per rad off the heading
_ROUNDING = 1e-9


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
        self._clock = GaitClock(gaits[default_gait])
        self._unfold: Unfold | None = None
        self._idle = True
        self._waiting = False  # lift-offs, and the needle, for the body's shift
        self._sit_anew()

    def start(self, positions: Sequence[float]) -> None:
        """Take over a seated robot whose joints are at `positions` (rad); it will hold them until it stands."""
        self._sit_anew()
        seated, _ = self._angles(self._stepping.footfalls())
        self._unfold = Unfold(positions, seated)

    def _sit_anew(self) -> None:
        """Begin at the origin, seated and at rest."""
        model = self._model
        self._shaper = VelocityShaper(model.motion)
        self._propulsion = Propulsion(len(model.legs))
        self._body = Body(model.heights.sit)
        self._stepping = Stepping(model, self._body.course)
        self._sway = Sway(model)
        self._rocking = Rocking(model)
        self._reaction = Reaction(model)
        self._levelling = Levelling(model.levelling) if model.levelling is not None else None
        self._steering = Steering()
        self._pose = self._body.pose

    def step(self, state: State, command: Command, estimate: Estimate, dt: float) -> Wanted:
        """Advance by `dt` s."""
        unfold = self._unfold
        if unfold is not None and not unfold.done:
            # On the way down too: it may have been found standing, and is down only when its joints have arrived.
            angles = unfold.step(0.0 if state is State.READY else dt)
            return Wanted(angles, STILL, 1.0, self._stepping.footfalls().planted, 0.0, False, False)
        shaped, bearable = self._shape(state, command, estimate, dt)
        # While a body shifts, its joints give to changing loads, and odometry sees turns that are none.
        held = command.heading is not None or self._clock.gait.balance is not None
        twist = self._steering.step(shaped.twist, estimate.pose.yaw, dt, held=held)
        height, posture = self._carriage(state, command)
        pose = self._level(self._body.step(twist, height, posture, dt), state, estimate, dt)
        self._turn_needle(twist, bearable, dt)
        self._waiting = self._balance(pose, twist)
        rocked = self._rocking.step(self._sway.step(pose, dt), self._clock, not self._idle, dt)
        self._pose = self._reaction.step(
            rocked, self._clock, self._stepping.footfalls(), self._body.course, not self._idle, dt)
        footfalls = self._step_feet(twist, dt)
        angles, reach_error = self._angles(footfalls)
        at_rest = self._idle and self._sway.at_rest and self._rocking.at_rest and self._reaction.at_rest
        settled = at_rest and self._body.settled(height, posture)
        lowered = height == self._model.heights.sit and (self._levelling is None or self._levelling.at_rest)
        return Wanted(
            angles, twist, shaped.scale, footfalls.planted, reach_error,
            standing=settled and state in (State.STAND, State.WALK), seated=settled and lowered)

    def _shape(self, state: State, command: Command, estimate: Estimate, dt: float) -> tuple[Shaped, float]:
        """Return the twist to walk with, and the share of the feasible one that the standing feet can bear."""
        twist = command.twist if state is State.WALK else STILL
        if state is State.WALK and command.heading is not None:
            turn = _HEADING_GAIN * (command.heading - estimate.pose.yaw)
            limit = self._model.motion.turn
            twist = twist._replace(wz=min(max(turn, -limit), limit))
        gait, now, course = self._gaits[command.gait or self._default_gait], self._shaper.twist, self._body.course
        aim = self._shaper.feasible(twist, gait)
        share = bearable = self._stepping.bearable(self._clock, course, aim)
        # A slower gait takes over once the body is slow enough for it.
        if gait is not self._clock.gait and gait.largest_scale(now) >= 1.0 - _ROUNDING:
            ready = self._stepping.change_gait(self._clock, gait, course, now)
            if ready < 1.0 and aim != STILL:  # slow down until it is
                share = min(share, ready * max(gait.foot_speeds(now)) / max(gait.foot_speeds(aim)))
        pushes = self._propulsion.step(self._clock, self._stepping.footfalls().planted, self._idle)
        return self._shaper.step(twist, gait, dt, share, pushes=pushes), bearable

    def _carriage(self, state: State, command: Command) -> tuple[float, Pose]:
        """Return the height and the posture to go for; down only once the feet are at rest."""
        heights = self._model.heights
        if state not in (State.STAND, State.WALK) and self._idle:
            return heights.sit, LEVEL
        height = heights.stand if command.height is None else command.height
        return min(max(height, heights.lowest), heights.highest), command.posture

    def _level(self, pose: Pose, state: State, estimate: Estimate, dt: float) -> Pose:
        """Keep the body level by the IMU while it is up; seated, it lies as the ground does."""
        if self._levelling is None:
            return pose
        up = state in (State.STAND, State.WALK)
        return self._levelling.step(pose, self._pose, estimate.imu if up else None, dt)

    def _turn_needle(self, twist: Twist, bearable: float, dt: float) -> None:
        """Turn it by a tick, unless lift-offs have to wait; with the body still and all feet at rest, stop it."""
        was_idle = self._idle
        self._idle = twist == STILL and self._stepping.settled(self._body.course)
        if was_idle and not self._idle:
            self._clock.rewind()
        elif not self._idle and not self._waiting:
            self._clock.advance(twist, dt, bearable)

    def _balance(self, pose: Pose, twist: Twist) -> bool:
        """Aim the body's shift, if the gait asks for it; tell whether lift-offs have to wait for that."""
        clock, stepping = self._clock, self._stepping
        balanced = clock.gait.balance is not None and not self._idle
        if not balanced and self._sway.at_rest:
            return False
        until_lift_off = stepping.until_lift_off(clock)
        if not balanced:
            return self._sway.release(until_lift_off)
        return self._sway.plan(clock, stepping.footfalls(), self._body.course, pose, twist, until_lift_off)

    def _step_feet(self, twist: Twist, dt: float) -> Footfalls:
        if self._idle:
            return self._stepping.footfalls()
        up = up_axis(self._pose)
        return self._stepping.step(self._clock, self._body.course, twist, dt, hold=self._waiting, up=up)

    def _angles(self, footfalls: Footfalls) -> tuple[list[float], float]:
        angles: list[float] = []
        miss = 0.0
        for solver, foot in zip(self._solvers, seen_from(self._pose, footfalls.centres), strict=True):
            solution = solver.solve(*foot)
            angles.extend(solution.angles)
            miss = max(miss, solution.miss)
        return angles, miss


def twist_of(speed: float, direction: float, turn: float) -> Twist:
    """Return the twist for a speed (m/s) in a direction relative to the body (rad, 0 ahead) and a turn (rad/s)."""
    return Twist(speed * math.cos(direction), speed * math.sin(direction), turn)
