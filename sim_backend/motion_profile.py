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
        self.kind = np.zeros(count, np.int64)  # 0 step, 1 rectangle, 2 triangle, 3 trapezoid (moving_status)
        self.idle = True  # whether no servo has a profile
        self._profiled = np.zeros(count, bool)
        self._profiles = np.zeros((len(Profile._fields), count))
        self._begin = np.zeros(count, np.int64)  # ns

    def jump(self, index: int, position: float, speed: float = 0.0) -> None:
        """Go to a goal at once."""
        self.position[index] = position
        self.speed[index] = speed
        if self._profiled[index]:
            self._profiled[index] = self.ongoing[index] = False
            self.acceleration[index] = self.kind[index] = 0
            self.idle = not self._profiled.any()

    def follow(self, index: int, profile: Profile, now: int) -> None:
        """Begin a profile at `now` ns."""
        self._profiles[:, index] = profile
        self._begin[index] = now
        self.kind[index] = 1 if profile.ramp_s == 0.0 else 2 if profile.cruise_s == 0.0 else 3
        self._profiled[index] = self.ongoing[index] = True
        self.idle = False

    def advance(self, now: int) -> None:
        """Move all profiles to `now` ns."""
        start, start_speed, ramp_s, cruise_speed, cruise_s, brake_s = self._profiles
        time = (now - self._begin) * _SECONDS
        ramped = np.minimum(time, ramp_s)
        cruised = np.clip(time - ramp_s, 0.0, cruise_s)
        braked = np.clip(time - ramp_s - cruise_s, 0.0, brake_s)
        ramp = (cruise_speed - start_speed) / np.maximum(ramp_s, _SECONDS)
        brake = cruise_speed / np.maximum(brake_s, _SECONDS)
        position = (
            start + (start_speed + 0.5 * ramp * ramped) * ramped + cruise_speed * cruised
            + (cruise_speed - 0.5 * brake * braked) * braked)
        ongoing = time < ramp_s + cruise_s + brake_s
        speed = (start_speed + ramp * ramped - brake * braked) * ongoing
        acceleration = (ramp * (time < ramp_s) - brake * (braked > 0.0)) * ongoing
        np.copyto(self.position, position, where=self._profiled)
        np.copyto(self.speed, speed, where=self._profiled)
        np.copyto(self.acceleration, acceleration, where=self._profiled)
        np.logical_and(ongoing, self._profiled, out=self.ongoing)
