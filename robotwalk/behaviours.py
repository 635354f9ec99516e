"""Steering behaviours: where the robot is in, a command out (ARTH section 6; Reynolds, GDC 1999).

Each returns the command of one tick, the same type that a person's input becomes. Positions are in odom, m: what leg
odometry makes of the walk so far. Feet that slip are not seen, so a goal is met as well as odometry is right. The legs
go any way, so where the body faces is told apart from where it goes: as it did at the first step, or to a heading in
odom (rad), or ahead, the way that it goes.
"""

import math
import random
from collections.abc import Sequence
from typing import Literal, Protocol

from robotwalk.estimator import Estimate
from robotwalk.track import Track
from robotwalk.types import Command, Pose, Twist

Facing = float | Literal["kept", "ahead"]

_THERE = 0.01  # m
_NEAR = 0.15  # m; from there on it is seen whether a goal is passed
_SLOWING = 1.0  # s; nearer to a goal than this takes at full speed, the speed falls in proportion
_LOOK_AHEAD = 0.06  # m along a path
_TOO_NEAR = 0.02  # m; what is nearer has no direction to face
_MOOD = 2.0  # s that a wanderer's turn lasts, about


class Behaviour(Protocol):
    """Steers a robot, tick by tick."""

    @property
    def done(self) -> bool:
        """Whether there is nothing left to do; some are never done."""
        ...

    def step(self, estimate: Estimate, dt: float) -> Command:
        """Return what to do in the tick of `dt` s that begins with this estimate."""
        ...


class _Course:
    """Commands a speed towards a point, the body facing as it is to."""

    def __init__(self, facing: Facing) -> None:
        self._facing = facing
        self._heading: float | None = None if isinstance(facing, str) else facing

    def command(self, pose: Pose, x: float, y: float, speed: float) -> Command:
        dx, dy = x - pose.x, y - pose.y
        way, direction = math.hypot(dx, dy), math.atan2(dy, dx)
        if self._heading is None:
            self._heading = pose.yaw
        if self._facing == "ahead" and way > _TOO_NEAR:
            self._heading = pose.yaw + math.remainder(direction - pose.yaw, math.tau)
        course = direction - pose.yaw
        return Command(Twist(speed * math.cos(course), speed * math.sin(course), 0.0), self._heading)


class Seek:
    """Goes to a point at full speed; done once it is within 1 cm, or has passed it."""

    def __init__(self, x: float, y: float, *, speed: float, facing: Facing = "kept") -> None:
        """Head for (x, y) in odom, m, at a speed in m/s."""
        self.done = False
        self._goal = x, y
        self._speed = speed
        self._course = _Course(facing)
        self._from: tuple[float, float] | None = None  # where it came near, m

    def step(self, estimate: Estimate, dt: float) -> Command:
        """Return the command of this tick."""
        pose, (x, y) = estimate.pose, self._goal
        way = math.hypot(x - pose.x, y - pose.y)
        if self._from is None and way < _NEAR:
            self._from = pose.x, pose.y
        passed = self._from is not None and (
            (x - pose.x) * (x - self._from[0]) + (y - pose.y) * (y - self._from[1]) <= 0.0)
        self.done = self.done or passed or way <= _THERE
        return self._course.command(pose, x, y, self._speed)


class FollowPath:
    """Goes along a line through waypoints, from where it is at the first step, and comes to rest at the last.

    It aims at a point of the line a little ahead of the nearest one, so it comes back onto it when pushed off, and
    cuts corners by a few centimetres.
    """

    def __init__(self, waypoints: Sequence[tuple[float, float]], *, speed: float, facing: Facing = "kept") -> None:
        """Follow at least one waypoint (x, y) in odom, m, at a speed in m/s."""
        self.done = False
        self._waypoints = waypoints
        self._speed = speed
        self._course = _Course(facing)
        self._track: Track | None = None

    def step(self, estimate: Estimate, dt: float) -> Command:
        """Return the command of this tick."""
        pose = estimate.pose
        if self._track is None:
            self._track = Track([(pose.x, pose.y), *self._waypoints])
        track = self._track
        progress = track.advance(pose.x, pose.y)
        x, y = track.at(progress + _LOOK_AHEAD)
        left = max(track.length - progress, 0.0)
        if left <= _LOOK_AHEAD:
            left = math.hypot(x - pose.x, y - pose.y)
            self.done = self.done or left <= _THERE
        return self._course.command(pose, x, y, min(self._speed, left / _SLOWING))


class Arrive(FollowPath):
    """Goes straight to a point and comes to rest there, to 1 cm."""

    def __init__(self, x: float, y: float, *, speed: float, facing: Facing = "kept") -> None:
        """Head for (x, y) in odom, m, at a speed in m/s."""
        super().__init__([(x, y)], speed=speed, facing=facing)


class KeepHeading:
    """Goes on in one direction of odom, whatever turns the body; never done."""

    done = False

    def __init__(self, direction: float, *, speed: float, facing: Facing = "ahead") -> None:
        """Go in a direction (rad in odom) at a speed in m/s."""
        self._way = math.cos(direction), math.sin(direction)
        self._speed = speed
        self._course = _Course(facing)

    def step(self, estimate: Estimate, dt: float) -> Command:
        """Return the command of this tick."""
        pose, (x, y) = estimate.pose, self._way
        return self._course.command(pose, pose.x + x, pose.y + y, self._speed)


class Wander:
    """Goes ahead and turns as chance has it, smoothly, near where it began; never done. Equal seeds wander equally."""

    done = False

    def __init__(self, *, speed: float, turn: float, within: float, seed: int) -> None:
        """Wander.

        Args:
            speed: m/s.
            turn: the largest turning rate, rad/s.
            within: m from where it began; farther away it turns back.
            seed: of chance.
        """
        self._speed = speed
        self._turn = turn
        self._within = within
        self._chance = random.Random(seed)
        self._mood = 0.0  # -1 to 1, of the largest turning rate
        self._home: Pose | None = None

    def step(self, estimate: Estimate, dt: float) -> Command:
        """Return the command of this tick."""
        pose = estimate.pose
        if self._home is None:
            self._home = pose
        # A walk by chance that forgets (Ornstein and Uhlenbeck): the same at every tick rate.
        step = -self._mood * dt / _MOOD + self._chance.gauss(0.0, 0.5) * math.sqrt(2.0 * dt / _MOOD)
        self._mood = min(max(self._mood + step, -1.0), 1.0)
        turn = self._turn * self._mood
        dx, dy = self._home.x - pose.x, self._home.y - pose.y
        if math.hypot(dx, dy) > self._within:
            turn = min(max(math.remainder(math.atan2(dy, dx) - pose.yaw, math.tau), -self._turn), self._turn)
        return Command(Twist(self._speed, 0.0, turn))
