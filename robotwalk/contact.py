"""What the feet feel: the force of the ground on each, from what the servos say of their own effort.

A foot switch wins: while it is heard, its foot touches while it is closed, whatever the load seems to be. A foot
without one, or whose switch is unknown, goes by its load.

A motor's torque, less what its friction, back-EMF and inertia take, moves the leg; what the leg's weight does not
account for, the ground exerts: column_j . F = weight_j - torque_j for every joint j (the transposed Jacobian, by least
squares). An acceleration is the difference of two measured speeds, so torques are averaged over the time between the
two: the force is that of half a tick ago. A motor's effort is no straight line from sample to sample: it jumps when a
goal comes, soon after the joints are read, and falls off as the joint follows. With the goal G held for most of the
time, the mean of k (G - q) follows from both efforts and from how far the joint has gone.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.model import RobotModel
from robotwalk.settings import ContactSettings
from robotwalk.statics import GRAVITY, LegStatics
from robotwalk.types import DriveResponse, FootSwitch, JointState, Triple, Vec3

_DAMPING = 0.02  # m; a foot's force along a way that it can hardly move is not told


_LEAST = 0.05  # of the weight, that a foot must bear to be taken for standing; and beyond what friction may hide
_LET_GO = 0.7  # of that; a foot that bears less stands no more
_LEVER = 0.5  # of its largest, at which friction in a joint is reckoned at the foot
_SPREAD = 4e-4  # m^2
_INERTIA_UNKNOWN = 0.5  # of a joint's, that may be otherwise
_AGREEING = 2  # measurements in a row that are believed; gears with backlash jolt


class Felt(NamedTuple):
    """What one foot feels."""

    force: Triple  # N, of the ground on it, in the base frame
    load: float  # N of it, upwards
    touching: bool  # bears a load worth a step
    sure: bool  # more of it than a fast leg's inertia may feign


_NOTHING = Felt((0.0, 0.0, 0.0), 0.0, touching=False, sure=False)


class _Motor(NamedTuple):
    """What a joint's effort tells; see `DriveResponse`. Halves: each of two samples has its part in a mean."""

    torque: float  # N m at effort 1
    damping: float  # N m s, half of it
    friction: float  # N m, half of it
    inertia: float  # N m s: what it takes to come to 1 rad/s in a tick


# A joint's part in the mean torque since the sample before, and until the next one; and what it would take to come to
# its speed in a tick. N m.
_Sample = tuple[float, float, float]


class FootSense:
    """Feels the ground with the feet of one robot."""

    def __init__(self, model: RobotModel, drives: Sequence[DriveResponse], dt: float, *, by_load: bool) -> None:
        """Feel by load and by switches, or by switches alone, every `dt` s."""
        contact = model.contact
        assert contact is not None  # else nobody wants to feel
        self._feet = tuple(
            (leg.span, _Foot(drives[leg.span], model.mass * GRAVITY, contact, dt)) for leg in model.legs)
        self._by_load = by_load

    def step(
        self, state: JointState, statics: Sequence[LegStatics], up: Triple, switches: Sequence[FootSwitch] = (),
    ) -> tuple[Felt | None, ...]:
        """Return what each foot feels; None where it has no switch and a joint of its leg did not answer twice in turn.

        Args:
            state: the joints.
            statics: of the legs, about where they are now.
            up: the unit vector against gravity, in the base frame.
            switches: of each foot; empty: there are none.
        """
        felt: list[Felt | None] = []
        efforts, speeds, valid = state.effort, state.velocity, state.valid
        all_heard = all(valid)
        for index, ((span, foot), leg) in enumerate(zip(self._feet, statics, strict=True)):
            by_load = None
            if self._by_load and (all_heard or all(valid[span])):
                by_load = foot.step(efforts[span], speeds[span], leg, up)
            else:
                foot.skip()
            closed = switches[index].closed if switches else None
            felt.append(by_load if closed is None else (by_load or _NOTHING)._replace(touching=closed, sure=closed))
        return tuple(felt)


class _Foot:
    """Feels with one foot."""

    def __init__(self, drives: Sequence[DriveResponse], weight: float, contact: ContactSettings, dt: float) -> None:
        self._early, self._creep = contact.goals_after, contact.creep
        self._late = 1.0 - self._early
        held = (0.5 - self._early) * dt
        self._motors = tuple(
            _Motor(drive.effort_torque, 0.5 * (drive.effort_damping - held * drive.stiffness),
                   0.5 * drive.stiffness * drive.friction, drive.stiffness * drive.inertia / dt) for drive in drives)
        self._frictions = tuple(drive.stiffness * drive.friction for drive in drives)
        self._least = _LEAST * weight
        self._unheard: tuple[_Sample, ...] = ((0.0, 0.0, 0.0),) * len(self._motors)
        self._last: Sequence[_Sample] = self._unheard
        self._touching = False
        self._doubts = 0  # measurements in a row that speak against that

    def skip(self) -> None:
        """Do without a sample, for a joint did not answer."""
        self._last = self._unheard

    def step(self, efforts: Sequence[float], speeds: Sequence[float], leg: LegStatics, up: Triple) -> Felt | None:
        """Take a sample and return what is felt, if there was one before it, too."""
        last, self._last = self._last, self._sample(efforts, speeds)
        if last is self._unheard:
            return None
        force = _force(leg, last, self._last)
        (fx, fy, fz), (ux, uy, uz) = force, up
        load = fx * ux + fy * uy + fz * uz
        if not self._touching and load <= self._least:  # whatever friction hides
            self._doubts = 0
            return Felt(force, load, touching=False, sure=False)
        hidden = feigned = 0.0
        for friction, (_, _, before), (_, _, now), (cx, cy, cz) in zip(
            self._frictions, last, self._last, leg.columns, strict=True,
        ):
            arm = _LEVER * math.hypot(cx, cy, cz) + _DAMPING
            hides, feigns = friction / arm, abs(now - before) / arm
            hidden = hides if hides > hidden else hidden
            feigned = feigns if feigns > feigned else feigned
        touching = self._judge(load, self._least + hidden)
        sure = touching and load > self._least + _INERTIA_UNKNOWN * feigned
        return Felt(force, load, touching, sure)

    def _sample(self, efforts: Sequence[float], speeds: Sequence[float]) -> list[_Sample]:
        sample: list[_Sample] = []
        early, late, creep = self._early, self._late, self._creep
        for (torque, damping, friction, inertia), effort, speed in zip(self._motors, efforts, speeds, strict=True):
            direction = speed / creep if -creep < speed < creep else 1.0 if speed > 0.0 else -1.0
            drive, taken = torque * effort, inertia * speed
            resistance = damping * speed + friction * direction
            sample.append((late * drive - resistance - taken, early * drive - resistance + taken, taken))
        return sample

    def _judge(self, load: float, least: float) -> bool:
        """Tell whether the foot touches, once measurements agree."""
        against = load < _LET_GO * least if self._touching else load > least
        self._doubts = self._doubts + 1 if against else 0
        if self._doubts >= _AGREEING:
            self._touching = not self._touching
            self._doubts = 0
        return self._touching


def _force(leg: LegStatics, last: Sequence[_Sample], now: Sequence[_Sample]) -> Triple:
    """Return the force at a foot that explains best what its joints did between two samples."""
    xx = yy = zz = _DAMPING * _DAMPING
    xy = xz = yz = bx = by = bz = 0.0
    for (cx, cy, cz), weight, (_, before, _), (after, _, _) in zip(leg.columns, leg.weights, last, now, strict=True):
        excess = weight - before - after
        xx, yy, zz, xy, xz, yz = xx + cx * cx, yy + cy * cy, zz + cz * cz, xy + cx * cy, xz + cx * cz, yz + cy * cz
        bx, by, bz = bx + cx * excess, by + cy * excess, bz + cz * excess
    # Cramer's rule for the symmetric normal equations.
    ax, ay, az = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    inverse = 1.0 / (xx * ax + xy * ay + xz * az)
    gy, gz, hz = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    return (
        (ax * bx + ay * by + az * bz) * inverse, (ay * bx + gy * by + gz * bz) * inverse,
        (az * bx + gz * by + hz * bz) * inverse)


class Plane(NamedTuple):
    """A value z over a plane, z = middle + ahead x + left y."""

    middle: float
    ahead: float
    left: float

    def at(self, place: Vec3) -> float:
        """Return it at a place, whatever that one's own z."""
        return self.middle + self.ahead * place.x + self.left * place.y


def plane_of(points: Sequence[Vec3]) -> Plane:
    """Return the plane through points, by least squares; nothing where there are none."""
    count = len(points)
    if count == 0:
        return Plane(0.0, 0.0, 0.0)
    mx = my = mz = xx = xy = yy = xz = yz = 0.0
    for x, y, z in points:
        mx, my, mz = mx + x, my + y, mz + z
        xx, xy, yy, xz, yz = xx + x * x, xy + x * y, yy + y * y, xz + x * z, yz + y * z
    mx, my, mz = mx / count, my / count, mz / count
    # Slopes from points that are nearly in a line are left out by and by.
    xx, yy = xx - count * mx * mx + _SPREAD, yy - count * my * my + _SPREAD
    xy, xz, yz = xy - count * mx * my, xz - count * mx * mz, yz - count * my * mz
    inverse = 1.0 / (xx * yy - xy * xy)
    ahead, left = (xz * yy - yz * xy) * inverse, (yz * xx - xz * xy) * inverse
    return Plane(mz - ahead * mx - left * my, ahead, left)
