"""Joins the stages: a command and a state in, joint angles out."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from robotwalk.alignment import Alignment
from robotwalk.barriers import Barrier, Barriers
from robotwalk.body import Body, seen_from, up_axis
from robotwalk.brace import braced, leaning_back
from robotwalk.carriage import MOST_ROOM, Bearable, Carriage
from robotwalk.estimator import Estimate, tilted
from robotwalk.gait import Gait, GaitClock
from robotwalk.gait_change import GaitChange
from robotwalk.kinematics import solver_for
from robotwalk.model import RobotModel
from robotwalk.reach import Ranges
from robotwalk.reaction import Reaction
from robotwalk.rocking import Rocking
from robotwalk.senses import BodyInOdom, Sense
from robotwalk.stance_reflex import StanceReflex
from robotwalk.statics import Bearing, LegStatics
from robotwalk.steering import Steering
from robotwalk.stepping import Footfalls, Stepping
from robotwalk.supervisor import State
from robotwalk.sway import Sway
from robotwalk.types import LEVEL, STILL, Command, Pose, Twist
from robotwalk.unfold import Unfold
from robotwalk.velocity import Propulsion, Shaped, VelocityShaper

_HEADING_GAIN = 2.0  # rad/s per rad off the heading


class Wanted(NamedTuple):
    """What the controller wants in this tick."""

    angles: Sequence[float]  # rad, in joint order
    twist: Twist  # of the body in its base frame
    scale: float  # feasible twist / commanded twist
    planted: tuple[bool, ...]
    torques: Sequence[float]  # N m that the joints bear, at rest
    legs: Sequence[LegStatics]  # at these angles; empty before the robot stands up
    pose: Pose  # of the body in odom
    reach_error: float  # m, the farthest that a leg is short of its target
    standing: bool  # at its height, all feet at rest
    seated: bool  # lowered, all feet at rest
    barriers: tuple[Barrier, ...] = ()  # where the body is
    barred: Barrier | None = None  # what bars the way that is commanded: the robot stands
    recalled: str | None = None  # the leg that steps back to rest, and why, in words


NOTHING_WANTED = Wanted((), STILL, 1.0, (), (), (), LEVEL, 0.0, standing=False, seated=False)


class Controller:
    """Walks one robot. It knows nothing of servos, and time passes only by `step`."""

    def __init__(self, model: RobotModel, gaits: Mapping[str, Gait], default_gait: str) -> None:
        self._model = model
        self._gaits = gaits
        self._default_gait = default_gait
        self._no_torques = (0.0,) * len(model.joints)
        self._solvers = tuple(solver_for(leg) for leg in model.legs)
        self._clock = GaitClock(gaits[default_gait])
        self._unfold: Unfold | None = None
        self._idle = True
        self._cramped: list[int] = []  # standing legs that are near the end of a joint's range
        self._waiting = False  # lift-offs, and the needle, for the body's shift
        self._sit_anew()

    def start(self, positions: Sequence[float]) -> None:
        """Take over a seated robot whose joints are at `positions` (rad); it will hold them until it stands."""
        self._sit_anew()
        seated, _ = self._angles(self._stepping.footfalls(), 1.0)
        self._unfold = Unfold(positions, seated)

    def _sit_anew(self) -> None:
        """Begin at the origin, seated and at rest."""
        model = self._model
        self._shaper = VelocityShaper(model.motion)
        self._propulsion = Propulsion(len(model.legs))
        self._body = Body(model.heights.sit)
        self._ranges = tuple(Ranges([(joint.lower, joint.upper) for joint in leg.joints]) for leg in model.legs)
        self._bearable = Bearable(model)
        self._bearing = Bearing(model)
        self._alignment = Alignment(model, self._body.course)
        self._stepping = Stepping(model, self._body.course)
        self._stance = self._stepping.stance
        self._reflex = StanceReflex(model, self._gaits.values()) if model.stance_reflex else None
        self._standing = False  # at rest
        self._recalled: str | None = None
        self._change = GaitChange(self._clock, self._body, self._stance)
        self._footfalls = self._stepping.footfalls()
        self._loads: Sequence[float] = ()
        self._felt = False  # the feet feel the ground
        self._fastest_foot = 0.0  # m/s over the ground, of the twist to go for
        self._barriers = Barriers()
        self._barred: Barrier | None = None
        self._sway = Sway(model)
        self._rocking = Rocking(model)
        self._reaction = Reaction(model)
        self._steering = Steering()
        self._pose = self._body.pose

    def halt(self) -> None:
        """Set off anew with the next step: the body has come to rest, whatever it was to do."""
        self._shaper.halt()

    def step(self, state: State, command: Command, estimate: Estimate, dt: float) -> Wanted:
        """Advance by `dt` s."""
        unfold = self._unfold
        if unfold is not None and not unfold.done:
            # On the way down too: it may have been found standing, and is down only when its joints have arrived.
            angles = unfold.step(0.0 if state in (State.READY, State.HELD) else dt)
            return NOTHING_WANTED._replace(
                angles=angles, planted=self._stepping.footfalls().planted, torques=self._no_torques)
        gait = self._keep_stance(state, command, estimate, self._gaits[command.gait or self._default_gait], dt)
        carriage = self._carriage(state, command, gait)
        height, posture = carriage.height, carriage.posture
        if gait.balance is None:  # else the body is where its feet need it
            posture = leaning_back(posture, self._barriers.wary, self._body.course.yaw)
        shaped, bearable = self._shape(state, command, estimate, gait, carriage, dt)
        # While a body shifts, its joints give to changing loads, and odometry sees turns that are none.
        held = (
            command.heading is not None or self._clock.gait.balance is not None or not self._model.holds_course)
        twist = self._steering.step(shaped.twist, estimate.pose.yaw, dt, held=held)
        self._keep_upright(estimate, dt)
        still = state is State.WALK and not self._idle and (
            bool(self._cramped) or not self._stance.within(carriage.room, self._alignment.foot_course))
        pose = self._body.step(twist, height, posture, dt, still=still)
        pose = self._alignment.over_feet(pose, self._body.course, self._footfalls, dt)
        pose = self._alignment.levelled(
            pose, self._pose, estimate.tilt if state in (State.STAND, State.WALK) else None, dt)
        self._turn_needle(twist, bearable, command.period, carriage.part, dt)
        self._waiting = self._balance(pose, twist) or self._change.waits(posture)
        swayed = self._sway.step(pose, dt)
        rocked = self._rocking.step(swayed, self._clock, self._body.carried, not self._idle, dt)
        self._pose = self._reaction.step(
            rocked, self._clock, self._footfalls, self._body.course, not self._idle, dt)
        footfalls = self._footfalls = self._step_feet(twist, estimate, dt)
        angles, reach_error = self._angles(footfalls, dt)
        statics = self._bearing.step(
            angles, tilted(self._pose, estimate.tilt), self._body.carried, footfalls.planted, dt)
        self._loads = statics.loads
        at_rest = self._idle and self._sway.at_rest and self._rocking.at_rest and self._reaction.at_rest
        settled = at_rest and self._body.settled(height, posture)
        self._standing = settled and state in (State.STAND, State.WALK)
        lowered = height == self._model.heights.sit and self._alignment.at_rest
        return Wanted(
            angles, twist, shaped.scale, footfalls.planted, statics.torques, statics.legs, self._pose, reach_error,
            standing=self._standing, seated=settled and lowered, barriers=self._barriers.near, barred=self._barred,
            recalled=self._recalled)

    def _keep_stance(self, state: State, command: Command, estimate: Estimate, gait: Gait, dt: float) -> Gait:
        """Have a leg that is out of its place step back; return the gait to go on in, for that or as commanded."""
        reflex, stepping = self._reflex, self._stepping
        if reflex is None:
            return gait
        if state not in (State.STAND, State.WALK) or command.twist != STILL or self._barriers.near:
            reflex.forget()
            if self._recalled is not None:
                stepping.recall(None)
        elif not self._standing or not estimate.feet:
            reflex.pause()
        else:
            recall = reflex.step(
                estimate.feet, estimate.felt if self._felt else (), self._footfalls.centres, self._pose,
                self._alignment.foot_course, gait, dt)
            if recall is not None:
                stepping.recall(recall.leg)
                self._recalled = f"{self._model.legs[recall.leg].name} steps back to rest: {recall.why}"
        if self._recalled is not None and stepping.recalled is None:
            self._recalled = None
        return gait if self._recalled is None else reflex.gait(gait)

    def _shape(
        self, state: State, command: Command, estimate: Estimate, gait: Gait, carriage: Carriage, dt: float
    ) -> tuple[Shaped, float]:
        """Return the twist to walk with, and the share of the feasible one that the standing feet can bear."""
        part = carriage.part
        asked = command.twist if state is State.WALK else STILL
        self._barred = self._barriers.step(self._body.course, asked, self._footfalls.giving_up)
        back = self._barriers.draw_back(self._body.course, asked) if gait.balance is None else None
        twist = back or (asked if self._barred is None else STILL)
        if state is State.WALK and command.heading is not None:
            turn = _HEADING_GAIN * (command.heading - estimate.pose.yaw)
            limit = self._model.motion.turn
            twist = twist._replace(wz=min(max(turn, -limit), limit))
        now, course = self._shaper.twist, self._alignment.foot_course
        aim, _, self._fastest_foot = self._shaper.feasible(twist, gait, part)
        share = bearable = self._stance.bearable(self._clock, course, aim)
        ready = self._change.step(
            gait, now, course, carriage.posture, part, planted=self._footfalls.planted, idle=self._idle)
        if ready < 1.0 and aim != STILL:  # slow down until it is
            share = min(share, ready * max(gait.foot_speeds(now)) / self._fastest_foot)
        brake = bool(self._cramped) and self._stance.fall_behind(self._cramped, course, now)
        if brake:
            share = 0.0
        elif self._footfalls.void is not None:
            brake, share = True, 1.0
            twist = braced(self._footfalls, self._loads, self._pose) if asked != STILL else STILL
        elif self._footfalls.deep:
            brake, share = True, 0.0
        pushes = self._propulsion.step(self._clock, self._footfalls.planted, self._idle)
        sideways = self._clock.gait.sideways_acceleration
        shaped = self._shaper.step(twist, gait, dt, share, pushes=pushes, part=part, brake=brake, sideways=sideways)
        return shaped, bearable

    def _carriage(self, state: State, command: Command, gait: Gait) -> Carriage:
        """Return the height and the posture to go for; down only once the feet are at rest."""
        heights = self._model.heights
        if state not in (State.STAND, State.WALK) and self._idle:
            return Carriage(heights.sit, LEVEL, MOST_ROOM)
        height = heights.stand if command.height is None else command.height
        height = min(max(height, heights.lowest), heights.highest)
        walks = not self._idle or (state is State.WALK and command.twist != STILL)
        # Until the gait has changed, the posture must do for both.
        gaits = {self._clock.gait, gait} if walks else set()
        granted = self._bearable.step(height, command.posture, gaits)
        # On the way to it the body is carried as before, in part.
        if self._body.settled(height, granted.posture):
            self._stance.room = granted.room
        else:
            self._stance.room = min(self._stance.room, granted.room)
        return Carriage(height=granted.height, posture=granted.posture, room=self._stance.room)

    def _turn_needle(self, twist: Twist, bearable: float, period: float | None, part: float, dt: float) -> None:
        """Turn it by a tick, unless lift-offs have to wait; with the body still and all feet at rest, stop it."""
        was_idle = self._idle
        # What barred the way may be where feet rest.
        anywhere = bool(self._barriers.near) or self._barriers.unsettled
        still = twist == STILL and self._fastest_foot == 0.0
        self._idle = still and self._stance.settled(self._alignment.foot_course, anywhere=anywhere)
        if was_idle and not self._idle:
            self._clock.rewind(self._stepping.recalled)
            self._change.set_off()
        elif not self._idle and not self._waiting and not self._footfalls.late:
            self._clock.advance(twist, dt, bearable, period, part)

    def _balance(self, pose: Pose, twist: Twist) -> bool:
        """Aim the body's shift, if the gait asks for it; tell whether lift-offs have to wait for that."""
        clock = self._clock
        balanced = clock.gait.balance is not None and not self._idle
        if not balanced and self._sway.at_rest:
            return False
        until_lift_off = self._stance.until_lift_off(clock)
        if not balanced:
            return self._sway.release(until_lift_off)
        over_feet = pose._replace(z=self._body.carried)
        return self._sway.plan(clock, self._footfalls, self._alignment.foot_course, over_feet, twist, until_lift_off)

    def _keep_upright(self, estimate: Estimate, dt: float) -> None:
        """Turn odom, and all that stands in it, upright under the body."""
        turn = self._alignment.plumb(self._pose, estimate, self._footfalls, dt, self._clock.period, felt=self._felt)
        if turn is not None:
            self._stepping.turn(turn)
            self._footfalls = self._stepping.footfalls()

    def _step_feet(self, twist: Twist, estimate: Estimate, dt: float) -> Footfalls:
        senses = self._senses(estimate)
        if self._idle:
            return self._stepping.footfalls()
        hold = self._waiting or self._change.landing
        return self._stepping.step(
            self._clock, self._alignment.foot_course, twist, dt, hold=hold, up=up_axis(self._pose), senses=senses,
            plane=self._alignment.ground(self._body.course), loads=self._loads, wary=self._barriers.wary)

    def _senses(self, estimate: Estimate) -> list[Sense | None] | None:
        """Return what the feet feel in odom, by where the body is told to be."""
        contact = self._model.contact
        # A foot that began to search by feeling goes on so, however fast the robot is to be: the body waits for it.
        self._felt = (
            contact is not None and bool(estimate.felt)
            and (self._fastest_foot <= contact.fastest or self._stepping.searches)
            and (contact.gaits is None or self._clock.gait.name in contact.gaits))
        if not self._felt:
            return None
        pose, falls = self._pose, self._footfalls
        body = BodyInOdom(pose, falls.stood, falls.planted, estimate.feet, estimate.felt)
        return [
            None if felt is None or foot is None else Sense(felt, foot, body)
            for felt, foot in zip(estimate.felt, estimate.feet, strict=True)]

    def _angles(self, footfalls: Footfalls, dt: float) -> tuple[list[float], float]:
        angles: list[float] = []
        miss, self._cramped = 0.0, []
        feet = seen_from(self._pose, footfalls.centres)
        legs = zip(self._solvers, self._ranges, feet, footfalls.planted, strict=True)
        for leg, (solver, ranges, foot, stands) in enumerate(legs):
            reached, short = solver.solve(*foot)
            kept = ranges.keep(reached, dt)
            angles.extend(kept)
            if kept is reached:
                miss = max(miss, short)
            else:
                miss = max(miss, math.dist(solver.foot(kept), foot))
                if stands and ranges.at_end:
                    self._cramped.append(leg)
        return angles, miss


def twist_of(speed: float, direction: float, turn: float) -> Twist:
    """Return the twist for a speed (m/s) in a direction relative to the body (rad, 0 ahead) and a turn (rad/s)."""
    return Twist(speed * math.cos(direction), speed * math.sin(direction), turn)
