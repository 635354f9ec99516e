"""Keeps odom upright by what the standing feet feel.

A body tilts otherwise than it is told to: each tread that a foot did not expect turns it a little, and in odom, where
feet stand as they were told to, nothing shows that; after ten steps up, odom was found to be off by 10 to 30 degrees.
But what the ground exerts on all feet together bears the weight, so its part along the base's axes is the weight's: an
inclinometer of as many motors as stand. It leans as the body speeds up: what it is told to speed up by is taken off.
Friction in the gears, steps and jolts make it one that is to be averaged, and not to be taken at its word for the last
degrees. An IMU needs neither.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.contact import Felt
from robotwalk.statics import GRAVITY
from robotwalk.types import ImuState, Pose, Vec3

_AVERAGED = 1.0  # s, or a turn of the gait's needle, if that is more: steps, and shifts of the body, are over then
_DOUBT = math.radians(2.0)  # by which friction turns what is felt on flat ground, and some more
_BORNE = 0.6  # of the weight, that must be felt to tell anything
_STEEPEST = 0.7  # sine of a tilt that is believed
_FASTEST = 0.1  # rad/s


class Turn(NamedTuple):
    """A small turn of odom about a body, from how the body was thought to lie to how it does."""

    pivot: Vec3  # m
    x: float  # rad about odom's axes
    y: float
    roll: float  # rad about the body's heading and across it
    pitch: float

    def of(self, point: Vec3) -> Vec3:
        """Return a point of odom after it."""
        x, y, z = point
        rx, ry, rz = x - self.pivot.x, y - self.pivot.y, z - self.pivot.z
        return Vec3(x + self.y * rz, y - self.x * rz, z + self.x * ry - self.y * rx)


class Plumb:
    """Finds how far one robot's odom is out of plumb."""

    def __init__(self, mass: float) -> None:
        self._weight = mass * GRAVITY
        self._roll = self._pitch = 0.0  # rad that is felt beyond what was told, averaged
        self._load = self._weight  # N, averaged
        self._last: tuple[float, float] | None = None  # m, where the body was told to be
        self._speed: tuple[float, float] | None = None  # m/s

    def pause(self) -> None:
        """Feel nothing for a while, in which the body may go anywhere."""
        self._last = self._speed = None

    def step(
        self, told: Pose, felt: Sequence[Felt | None], planted: Sequence[bool], imu: ImuState | None, dt: float,
        period: float = 0.0,
    ) -> Turn | None:
        """Advance by `dt` s; return by how much to turn odom, if at all.

        Args:
            told: the body's pose in odom.
            felt: by each foot; empty where nothing can be felt.
            planted: which feet stand.
            imu: what it tells; valid, it is believed at once.
            dt: s.
            period: of the gait, s.
        """
        doubt = _DOUBT
        acceleration = self._acceleration(told, dt)
        if imu is not None and imu.valid:
            self._roll, self._pitch, doubt = imu.roll - told.roll, imu.pitch - told.pitch, 0.0
        elif not self._feel(told, felt, planted, acceleration, min(dt / max(period, _AVERAGED), 1.0)):
            return None
        roll, pitch = (_beyond(angle, doubt, _FASTEST * dt) for angle in (self._roll, self._pitch))
        if roll == pitch == 0.0:
            return None
        self._roll, self._pitch = self._roll - roll, self._pitch - pitch
        c, s = math.cos(told.yaw), math.sin(told.yaw)
        return Turn(Vec3(told.x, told.y, told.z), c * roll - s * pitch, s * roll + c * pitch, roll, pitch)

    def _acceleration(self, told: Pose, dt: float) -> tuple[float, float]:
        """Return the body's acceleration as it is told, ahead and to the left, m/s^2."""
        last, before = self._last, self._speed
        self._last = told.x, told.y
        self._speed = None if last is None else ((told.x - last[0]) / dt, (told.y - last[1]) / dt)
        if before is None or self._speed is None:
            return 0.0, 0.0
        ax, ay = (self._speed[0] - before[0]) / dt, (self._speed[1] - before[1]) / dt
        c, s = math.cos(told.yaw), math.sin(told.yaw)
        return c * ax + s * ay, c * ay - s * ax

    def _feel(
        self, told: Pose, felt: Sequence[Felt | None], planted: Sequence[bool], acceleration: tuple[float, float],
        share: float,
    ) -> bool:
        """Average what the feet feel; tell whether that is enough to go by."""
        x = y = z = 0.0
        for foot, stands in zip(felt, planted, strict=False):
            if foot is None:
                if stands:
                    return False
            elif stands or foot.touching:  # what a foot is struck by, the others bear up against
                fx, fy, fz = foot.force
                x, y, z = x + fx, y + fy, z + fz
        ahead, left = acceleration
        self._load += share * (z - self._load)
        self._roll += share * (_angle(y / self._weight - left / GRAVITY) - told.roll - self._roll)
        self._pitch += share * (_angle(ahead / GRAVITY - x / self._weight) - told.pitch - self._pitch)
        return self._load >= _BORNE * self._weight


def _angle(sine: float) -> float:
    return math.asin(min(max(sine, -_STEEPEST), _STEEPEST))


def _beyond(angle: float, doubt: float, most: float) -> float:
    """Return what an angle has beyond doubt, at most so much."""
    return min(max(angle - min(max(angle, -doubt), doubt), -most), most)
