"""Motion profiles of the servos' firmware: from goal to goal along ramp, cruise and braking.

Source: e-Manual, X series, Profile Acceleration and Profile Velocity.
"""

import math
from typing import NamedTuple

import numpy as np

_SECONDS = 1e-9  # per ns


class Profile(NamedTuple):
    """Constant acceleration to a cruising speed, cruise, and constant braking to rest. Ticks, seconds."""

    start: float
    start_speed: float
    ramp_s: float
    cruise_speed: float
    cruise_s: float
    brake_s: float


def profile_by_speed(start: float, speed: float, goal: float, limit: float, acceleration: float) -> Profile:
    """Return the fastest profile to `goal` within a speed and an acceleration (0: unlimited)."""
    distance = goal - start
    if acceleration == 0.0:
        cruise = math.copysign(limit, distance)
        return Profile(start, cruise, 0.0, cruise, abs(distance) / limit, 0.0)
    way = math.copysign(1.0, distance - speed * abs(speed) / (2.0 * acceleration))
    peak = math.sqrt(max(0.0, acceleration * way * distance + 0.5 * speed**2))  # without a cruise
    cruise = way * min(limit, peak)
    ramp_s, brake_s = abs(cruise - speed) / acceleration, abs(cruise) / acceleration
    left = distance - 0.5 * (speed + cruise) * ramp_s - 0.5 * cruise * brake_s
    return Profile(start, speed, ramp_s, cruise, left / cruise if peak > limit else 0.0, brake_s)


def profile_by_time(start: float, speed: float, goal: float, span_s: float, ramp_s: float) -> Profile:
    """Return the profile that reaches `goal` in `span_s`; its ramp and its braking each take `ramp_s`."""
    ramp_s = min(ramp_s, 0.5 * span_s)
    cruise = (goal - start - 0.5 * speed * ramp_s) / (span_s - ramp_s)
    return Profile(start, speed if ramp_s else cruise, ramp_s, cruise, span_s - 2.0 * ramp_s, ramp_s)


class Trajectories:
    """Where the profiles of all servos have got to."""

    def __init__(self, count: int) -> None:
        self.position, self.speed, self.acceleration = np.zeros((3, count))  # ticks, s
        self.ongoing = np.zeros(count, bool)
        self.kind = np.zeros(count, np.int64)  # of the last profile: 0 none, 1 rectangle, 2 triangle, 3 trapezoid
        self.idle = True  # whether every servo is at its goal
        self._profiled = np.zeros(count, bool)
        self._profiles = np.zeros((len(Profile._fields), count))
        self._ramp, self._brake = np.zeros((2, count))  # accelerations
        self._begin = np.zeros(count, np.int64)  # ns

    def jump(self, index: int, position: float, speed: float = 0.0) -> None:
        """Go to a goal at once."""
        self.position[index] = position
        self.speed[index] = speed
        if self._profiled[index]:
            self._profiled[index] = self.ongoing[index] = False
            self.acceleration[index] = self.kind[index] = 0
            self.idle = not self.ongoing.any()

    def follow(self, index: int, profile: Profile, now: int) -> None:
        """Begin a profile at `now` ns."""
        self._profiles[:, index] = profile
        _, start_speed, ramp_s, cruise_speed, cruise_s, brake_s = profile
        self._ramp[index] = (cruise_speed - start_speed) / ramp_s if ramp_s else 0.0
        self._brake[index] = cruise_speed / brake_s if brake_s else 0.0
        self._begin[index] = now
        self.kind[index] = 1 if ramp_s == 0.0 else 2 if cruise_s == 0.0 else 3
        self._profiled[index] = self.ongoing[index] = True
        self.idle = False

    def advance(self, now: int) -> None:
        """Move all profiles to `now` ns."""
        start, start_speed, ramp_s, cruise_speed, cruise_s, brake_s = self._profiles
        ramp, brake, profiled = self._ramp, self._brake, self._profiled
        time = (now - self._begin) * _SECONDS
        braking_from = ramp_s + cruise_s
        ramped = np.minimum(time, ramp_s)
        cruised = np.minimum(np.maximum(time - ramp_s, 0.0), cruise_s)
        braked = np.minimum(np.maximum(time - braking_from, 0.0), brake_s)
        position = (
            start + (start_speed + 0.5 * ramp * ramped) * ramped + cruise_speed * cruised
            + (cruise_speed - 0.5 * brake * braked) * braked)
        ongoing = time < braking_from + brake_s
        speed = (start_speed + ramp * ramped - brake * braked) * ongoing
        acceleration = (ramp * (time < ramp_s) - brake * (braked > 0.0)) * ongoing
        np.copyto(self.position, position, where=profiled)
        np.copyto(self.speed, speed, where=profiled)
        np.copyto(self.acceleration, acceleration, where=profiled)
        np.logical_and(ongoing, profiled, out=self.ongoing)
        self.idle = not self.ongoing.any()
