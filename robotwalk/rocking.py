"""Rocks the body from side to side, or to and fro, for gaits whose feet stand beside the centre of mass in turn.

A centre of mass at height h that is accelerated by a presses on the ground a h / g behind itself: at the zero-moment
point. Where that point lies between the standing feet, the body does not tip. Of all motions that keep it in the middle
of the feet that stand, z(t), one does not run away (the linear inverted pendulum; Kajita et al. 2001):

    c(t) = integral of z(s) (w / 2) exp(-w |t - s|) ds, with w = sqrt(g / h)

As z repeats itself with the gait's period and is constant in each support, the integral has a closed form.
"""

import math
from typing import NamedTuple

from robotwalk.body import Ramp, composed
from robotwalk.gait import Gait, GaitClock
from robotwalk.kinematics import resting_angles
from robotwalk.model import RobotModel
from robotwalk.support import centre_of_mass
from robotwalk.types import LEVEL, Pose

_GRAVITY = 9.81  # m/s^2
_ENTRY = 0.5  # s, about, until it rocks fully
_RETURN = 0.2  # m/s, largest, from one gait's shift to the next one's
_AT_REST = 5e-4  # m
_NO_SHARE = 5e-3


class _Pressure(NamedTuple):
    """The middle of the feet that stand in a support, from the mean over the circle, m."""

    start: float  # turns
    end: float
    x: float
    y: float


class Rocking:
    """The rocking of one robot's body, along its own x and y."""

    def __init__(self, model: RobotModel) -> None:
        self._legs = model.legs
        self._centre = centre_of_mass(model, resting_angles(model, model.heights.stand))
        self._rate = 0.0  # rad/s, w
        self._share = Ramp(0.0, 1.0, _ENTRY)
        self._gait: Gait | None = None
        self._active = False  # in the last tick
        self._pressures: list[_Pressure] = []
        self._shift = (0.0, 0.0)  # m
        # What is left of the shift of the gait before.
        self._rest_x = self._rest_y = Ramp(0.0, _RETURN)

    @property
    def at_rest(self) -> bool:
        """Tell whether the body is on its course."""
        return math.hypot(*self._shift) <= _AT_REST

    def step(self, pose: Pose, clock: GaitClock, height: float, active: bool, dt: float) -> Pose:
        """Advance by `dt` s, the body carried at a height, m; return its pose, rocked as far as the gait asks."""
        wanted = clock.gait.rocking if active else 0.0
        if wanted == 0.0 and self._shift == (0.0, 0.0):
            return pose
        self._rate = math.sqrt(_GRAVITY / (height + self._centre.z))
        share = self._share.step(wanted, dt)
        sets_off, self._active = active and not self._active, active
        if sets_off or clock.gait is not self._gait:  # the needle may have been turned back to where it begins
            self._gait, self._pressures = clock.gait, self._pressures_of(clock.gait)
            x, y = self._ideal(clock)
            self._rest_x = Ramp(self._shift[0] - share * x, _RETURN)
            self._rest_y = Ramp(self._shift[1] - share * y, _RETURN)
        x, y = self._ideal(clock)
        self._shift = share * x + self._rest_x.step(0.0, dt), share * y + self._rest_y.step(0.0, dt)
        if wanted == 0.0 and self.at_rest and share < _NO_SHARE:
            self._shift, self._gait = (0.0, 0.0), None
            self._share = Ramp(0.0, 1.0, _ENTRY)
        return composed(pose, LEVEL._replace(x=self._shift[0], y=self._shift[1]))

    def _ideal(self, clock: GaitClock) -> tuple[float, float]:
        """Return the shift that would keep the body from tipping at all, m."""
        weights = [self._weight(pressure, clock.phase, clock.period) for pressure in self._pressures]
        return (
            sum(weight * pressure.x for weight, pressure in zip(weights, self._pressures, strict=True)),
            sum(weight * pressure.y for weight, pressure in zip(weights, self._pressures, strict=True)))

    def _pressures_of(self, gait: Gait) -> list[_Pressure]:
        rows = []
        for support in gait.supports:
            feet = [leg.rest_foot for leg, stands in zip(self._legs, support.standing, strict=True) if stands]
            if feet:
                x, y = sum(foot.x for foot in feet) / len(feet), sum(foot.y for foot in feet) / len(feet)
                rows.append(_Pressure(support.start, support.start + support.length, x, y))
        turns = sum(row.end - row.start for row in rows)
        mean_x = sum(row.x * (row.end - row.start) for row in rows) / turns
        mean_y = sum(row.y * (row.end - row.start) for row in rows) / turns
        return [row._replace(x=row.x - mean_x, y=row.y - mean_y) for row in rows]

    def _weight(self, pressure: _Pressure, phase: float, period: float) -> float:
        """Return the integral of the kernel, repeated every period, over a support."""
        length = pressure.end - pressure.start
        since = (phase - pressure.start) % 1.0  # its begin
        if since < length:
            return self._kernel(0.0, since, period) + self._kernel(1.0 - (length - since), 1.0, period)
        return self._kernel(since - length, since, period)

    def _kernel(self, begin: float, end: float, period: float) -> float:
        half = 0.5 * self._rate * period
        return 0.5 * (math.sinh(half * (1.0 - 2.0 * begin)) - math.sinh(half * (1.0 - 2.0 * end))) / math.sinh(half)
