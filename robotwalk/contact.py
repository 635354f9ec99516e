"""What the feet feel: the force of the ground on each, from what the servos say of their own effort.

A motor's torque, less what its friction, back-EMF and inertia take, moves the leg; what the leg's weight does not
account for, the ground exerts: column_j . F = weight_j - torque_j for every joint j (the transposed Jacobian, by least
squares). An acceleration is the difference of two measured speeds and holds half way between them, so efforts are
averaged over the same two samples: the force is that of half a tick ago.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.model import RobotModel
from robotwalk.statics import GRAVITY, LegStatics
from robotwalk.types import DriveResponse, JointState, Vec3

_CREEP = 0.1  # rad/s, below which a joint's friction is known in part only
_DAMPING = 0.02  # m; a foot's force along a way that it can hardly move is not told


_LEAST = 0.05  # of the weight, that a foot must bear to be taken for standing; and beyond what friction may hide
_LET_GO = 0.7  # of that; a foot that bears less stands no more
_LEVER = 0.5  # of its largest, at which friction in a joint is reckoned at the foot
_SPREAD = 4e-4  # m^2
_INERTIA_UNKNOWN = 0.5  # of a joint's, that may be otherwise
_AGREEING = 2  # measurements in a row that are believed; gears with backlash jolt


class Felt(NamedTuple):
    """What one foot feels."""

    force: Vec3  # N, of the ground on it, in the base frame
    load: float  # N of it, upwards
    touching: bool  # bears a load worth a step
    sure: bool  # more of it than a fast leg's inertia may feign


class Sense(NamedTuple):
    """What one foot feels, and where, in odom."""

    place: Vec3  # of its centre, m, as its joints tell
    push: Vec3  # N, of the ground on it
    touching: bool
    sure: bool  # of that, however fast its leg is


class _Sample(NamedTuple):
    """Of one leg's joints."""

    speeds: Sequence[float]  # rad/s
    torques: Sequence[float]  # N m; what its inertia takes is not yet taken off


class FootSense:
    """Feels the ground with the feet of one robot."""

    def __init__(self, model: RobotModel, drives: Sequence[DriveResponse]) -> None:
        self._legs = tuple((leg.span, tuple(drives[leg.span])) for leg in model.legs)
        self._last: list[_Sample | None] = [None] * len(model.legs)
        self._touching = [False] * len(model.legs)
        self._doubts = [0] * len(model.legs)  # measurements in a row that speak against that
        self._weight = model.mass * GRAVITY

    def step(self, state: JointState, statics: Sequence[LegStatics], up: Vec3, dt: float) -> tuple[Felt | None, ...]:
        """Return what each foot feels; None where a joint of its leg did not answer twice in turn.

        Args:
            state: the joints.
            statics: of the legs, about where they are now.
            up: the unit vector against gravity, in the base frame.
            dt: s since the last measurement.
        """
        felt: list[Felt | None] = []
        for index, ((span, drives), leg) in enumerate(zip(self._legs, statics, strict=True)):
            last, now = self._last[index], None
            if all(state.valid[span]):
                now = _sample(drives, state.effort[span], state.velocity[span])
            self._last[index] = now
            if last is None or now is None:
                felt.append(None)
                continue
            force = _force(leg, drives, last, now, dt)
            load = force.x * up.x + force.y * up.y + force.z * up.z
            touching = self._judge(index, load, leg, drives)
            sure = touching and load > _LEAST * self._weight + _feigned(leg, drives, last, now, dt)
            felt.append(Felt(force, load, touching, sure))
        return tuple(felt)

    def _judge(self, index: int, load: float, leg: LegStatics, drives: Sequence[DriveResponse]) -> bool:
        """Tell whether a foot touches, once measurements agree."""
        least, touching = _LEAST * self._weight, self._touching[index]
        if not touching and load <= least:  # whatever friction hides
            self._doubts[index] = 0
            return False
        least += _hidden(leg, drives)
        against = load < _LET_GO * least if touching else load > least
        self._doubts[index] = self._doubts[index] + 1 if against else 0
        if self._doubts[index] >= _AGREEING:
            self._touching[index] = touching = not touching
            self._doubts[index] = 0
        return touching


def _hidden(leg: LegStatics, drives: Sequence[DriveResponse]) -> float:
    """Return the largest force at a foot, N, that the friction of its joints may hide or feign."""
    return max(
        drive.stiffness * drive.friction / (_LEVER * math.hypot(*column) + _DAMPING)
        for drive, column in zip(drives, leg.columns, strict=True))


def _feigned(leg: LegStatics, drives: Sequence[DriveResponse], last: _Sample, now: _Sample, dt: float) -> float:
    """Return the force at a foot, N, that may be inertia not known well enough."""
    return _INERTIA_UNKNOWN * max(
        drive.stiffness * drive.inertia * abs(speed - before) / dt / (_LEVER * math.hypot(*column) + _DAMPING)
        for drive, column, speed, before in zip(drives, leg.columns, now.speeds, last.speeds, strict=True))


def _sample(drives: Sequence[DriveResponse], efforts: Sequence[float], speeds: Sequence[float]) -> _Sample:
    return _Sample(speeds, [
        drive.effort_torque * effort - drive.effort_damping * speed
        - drive.stiffness * drive.friction * min(max(speed / _CREEP, -1.0), 1.0)
        for drive, effort, speed in zip(drives, efforts, speeds, strict=True)])


def _force(leg: LegStatics, drives: Sequence[DriveResponse], last: _Sample, now: _Sample, dt: float) -> Vec3:
    """Return the force at a foot that explains best what its joints did between two samples."""
    xx = yy = zz = _DAMPING * _DAMPING
    xy = xz = yz = bx = by = bz = 0.0
    for (cx, cy, cz), weight, drive, speed, before, torque, torque_before in zip(
        leg.columns, leg.weights, drives, now.speeds, last.speeds, now.torques, last.torques, strict=True,
    ):
        accelerating = drive.stiffness * drive.inertia * (speed - before) / dt
        excess = weight - 0.5 * (torque + torque_before) + accelerating
        xx, yy, zz, xy, xz, yz = xx + cx * cx, yy + cy * cy, zz + cz * cz, xy + cx * cy, xz + cx * cz, yz + cy * cz
        bx, by, bz = bx + cx * excess, by + cy * excess, bz + cz * excess
    # Cramer's rule for the symmetric normal equations.
    ax, ay, az = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    inverse = 1.0 / (xx * ax + xy * ay + xz * az)
    gy, gz, hz = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    return Vec3(
        (ax * bx + ay * by + az * bz) * inverse, (ay * bx + gy * by + gz * bz) * inverse,
        (az * bx + gz * by + hz * bz) * inverse)


class Sag(NamedTuple):
    """By how much the feet are higher in the base frame than they are told to be, as legs give: a plane."""

    middle: float  # m, at the base's origin
    ahead: float  # m per m ahead
    left: float

    def at(self, place: Vec3) -> float:
        """Return it at a place in the base frame, m."""
        return self.middle + self.ahead * place.x + self.left * place.y


def sag(told: Sequence[Vec3], measured: Sequence[Vec3 | None], standing: Sequence[bool]) -> Sag:
    """Return how the body hangs lower than told on the feet that stand; places in the base frame, m."""
    count = 0
    mx = my = mz = xx = xy = yy = xz = yz = 0.0
    for want, got, stands in zip(told, measured, standing, strict=True):
        if got is None or not stands:
            continue
        x, y, z = got.x, got.y, got.z - want.z
        count += 1
        mx, my, mz = mx + x, my + y, mz + z
        xx, xy, yy, xz, yz = xx + x * x, xy + x * y, yy + y * y, xz + x * z, yz + y * z
    if count == 0:
        return Sag(0.0, 0.0, 0.0)
    mx, my, mz = mx / count, my / count, mz / count
    # Slopes from feet that are nearly in a line are left out by and by.
    xx, yy = xx - count * mx * mx + _SPREAD, yy - count * my * my + _SPREAD
    xy, xz, yz = xy - count * mx * my, xz - count * mx * mz, yz - count * my * mz
    inverse = 1.0 / (xx * yy - xy * xy)
    ahead, left = (xz * yy - yz * xy) * inverse, (yz * xx - xz * xy) * inverse
    return Sag(mz - ahead * mx - left * my, ahead, left)
