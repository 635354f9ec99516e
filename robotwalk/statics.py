"""What a standing robot's joints bear: its weight shared among the feet, and the legs' own.

    sum N_i = m g, the moments of the N_i about the centre of mass vanish, and the N_i are the least that do so,
    each measured by the share w_i with which its foot stands: N = W A' (A W A')^-1 b. Springs that are alike,
    which stiff legs are, share a load in this way.

A joint's torque then balances the force at its foot and the weight of the links behind it.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.model import Axis, Leg, RobotModel
from robotwalk.types import Pose, Triple

GRAVITY = 9.81  # m/s^2
_PITCH, _YAW = Axis.PITCH, Axis.YAW
_TAKE_OVER = 0.06  # s in which a foot takes its load, or gives it up
_SEATING = 0.02  # m of height over which the feet take over from the belly
_LEAN = 0.2  # of a foot's load that it may push outwards, and friction holds it: an arch spares its bearers
_SPREAD = 0.2  # of feet across their line, 0 in a line to 1 all around; with less a robot is falling, not standing
_LEVER = 0.02  # m; feet whose spread in some direction is less than about this are in a line


class LegStatics(NamedTuple):
    """One leg at one moment, in the base frame."""

    foot: Triple  # m
    columns: Sequence[Triple]  # of its Jacobian: the foot's velocity per rad/s of each joint, m
    lifts: Sequence[float]  # m: each column's part along the way up
    weights: Sequence[float]  # N m: the torque of each joint that holds up the links behind it


class Statics(NamedTuple):
    """The whole robot at one moment."""

    legs: tuple[LegStatics, ...]
    loads: tuple[float, ...]  # N on each foot, along the way up
    torques: tuple[float, ...]  # N m, in joint order


# What is behind a joint, seen from it in the frame of the link before: the joint's axis, its angle's cosine and sine,
# the foot (m), and the first moment of all masses (kg m).
_Behind = tuple[Axis, float, float, float, float, float, float, float, float]


class LegMasses:
    """A leg as a chain of masses: a link's is at its middle, the foot's at its centre.

    All is seen from the joints. A joint's axis is one of its frame's own, so its cross products are mere swaps.
    """

    def __init__(self, leg: Leg, foot_mass: float) -> None:
        """Prepare a leg whose foot weighs `foot_mass` kg."""
        mass, links = foot_mass, []
        for joint in reversed(leg.joints):
            lever = mass + 0.5 * joint.mass  # what the link moves, as if it were all at its end
            mass += joint.mass
            x, y, z = joint.link
            links.append((joint.axis, x, y, z, lever * x, lever * y, lever * z))
        self._links = tuple(links)  # from the foot to the body
        self._mount, self._mass = (*leg.mount,), mass
        self._cos, self._sin = math.cos(leg.yaw), math.sin(leg.yaw)

    def foot_and_moment(self, angles: Sequence[float]) -> tuple[Triple, Triple]:
        """Return the foot's centre, m, and the leg's mass times the place of its centre of mass, kg m, for angles."""
        return self._in_base(self._behind(angles)[-1])

    def statics(self, angles: Sequence[float], up: Triple) -> tuple[LegStatics, Triple]:
        """Return the leg's statics for joint angles (rad), and its mass times the place of its centre of mass, kg m.

        `up` is the unit vector against gravity, in the base frame.
        """
        behind = self._behind(angles)
        foot, moment = self._in_base(behind[-1])
        # The axes of the joint's frame in the base frame, and the way up in the joint's frame.
        xx, xy, xz = self._cos, self._sin, 0.0
        yx, yy, yz = -xy, xx, 0.0
        zx, zy, zz = 0.0, 0.0, 1.0
        ux, uy, uz = up
        ux, uy = xx * ux + xy * uy, xx * uy - xy * ux
        columns: list[Triple] = []
        lifts: list[float] = []
        weights: list[float] = []
        for axis, c, s, fx, fy, fz, mx, my, mz in reversed(behind):
            if axis is _PITCH:
                columns.append((fz * xx - fx * zx, fz * xy - fx * zy, fz * xz - fx * zz))
                lifts.append(fz * ux - fx * uz)
                weights.append(GRAVITY * (mz * ux - mx * uz))
                ux, uz = c * ux - s * uz, c * uz + s * ux
                xx, zx = c * xx - s * zx, c * zx + s * xx
                xy, zy = c * xy - s * zy, c * zy + s * xy
                xz, zz = c * xz - s * zz, c * zz + s * xz
            elif axis is _YAW:
                columns.append((fx * yx - fy * xx, fx * yy - fy * xy, fx * yz - fy * xz))
                lifts.append(fx * uy - fy * ux)
                weights.append(GRAVITY * (mx * uy - my * ux))
                ux, uy = c * ux + s * uy, c * uy - s * ux
                xx, yx = c * xx + s * yx, c * yx - s * xx
                xy, yy = c * xy + s * yy, c * yy - s * xy
                xz, yz = c * xz + s * yz, c * yz - s * xz
            else:
                columns.append((fy * zx - fz * yx, fy * zy - fz * yy, fy * zz - fz * yz))
                lifts.append(fy * uz - fz * uy)
                weights.append(GRAVITY * (my * uz - mz * uy))
                uy, uz = c * uy + s * uz, c * uz - s * uy
                yx, zx = c * yx + s * zx, c * zx - s * yx
                yy, zy = c * yy + s * zy, c * zy - s * yy
                yz, zz = c * yz + s * zz, c * zz - s * yz
        return LegStatics(foot, columns, lifts, weights), moment

    def _behind(self, angles: Sequence[float]) -> list[_Behind]:
        """Go from the foot inwards: each joint turns both the foot and the first moment of all that is behind it."""
        fx = fy = fz = mx = my = mz = 0.0
        behind: list[_Behind] = []
        for (axis, lx, ly, lz, nx, ny, nz), angle in zip(self._links, reversed(angles), strict=True):
            fx += lx
            fy += ly
            fz += lz
            mx += nx
            my += ny
            mz += nz
            c, s = math.cos(angle), math.sin(angle)
            if axis is _PITCH:
                fx, fz = c * fx + s * fz, c * fz - s * fx
                mx, mz = c * mx + s * mz, c * mz - s * mx
            elif axis is _YAW:
                fx, fy = c * fx - s * fy, s * fx + c * fy
                mx, my = c * mx - s * my, s * mx + c * my
            else:
                fy, fz = c * fy - s * fz, s * fy + c * fz
                my, mz = c * my - s * mz, s * my + c * mz
            behind.append((axis, c, s, fx, fy, fz, mx, my, mz))
        return behind

    def _in_base(self, whole: _Behind) -> tuple[Triple, Triple]:
        """Return the foot and the first moment as the base sees them."""
        _, _, _, fx, fy, fz, mx, my, mz = whole
        (x, y, z), mass, c, s = self._mount, self._mass, self._cos, self._sin
        return (
            (x + c * fx - s * fy, y + s * fx + c * fy, z + fz),
            (mass * x + c * mx - s * my, mass * y + s * mx + c * my, mass * z + mz))


def shared_loads(
    feet: Sequence[Triple], shares: Sequence[float], centre: Triple, weight: float, up: Triple
) -> tuple[float, ...]:
    """Return the load of each foot, N, by the shares (0 to 1) with which they stand; none pulls.

    Where the standing feet cannot hold the centre of mass, because they are in a line or it is outside their
    polygon, the moments are not balanced to the last.
    """
    # The feet seen from the centre of mass, in two axes across `up`.
    cx, cy, cz = centre
    ux, uy, uz = up
    norm = math.hypot(ux, uz)
    ex, ez = uz / norm, -ux / norm  # across up, in the base's x-z plane
    gx, gy, gz = uy * ez, uz * ex - ux * ez, -uy * ex  # up x e
    sw = sa = sb = saa = sab = sbb = 0.0
    arms: list[tuple[float, float]] = []
    for (x, y, z), share in zip(feet, shares, strict=True):
        dx, dy, dz = x - cx, y - cy, z - cz
        a, b = dx * ex + dz * ez, dx * gx + dy * gy + dz * gz
        arms.append((a, b))
        wa, wb = share * a, share * b
        sw, sa, sb = sw + share, sa + wa, sb + wb
        saa, sab, sbb = saa + wa * a, sab + wa * b, sbb + wb * b
    if sw <= 1e-6:
        return (0.0,) * len(arms)
    # About the feet's middle the three equations part: N_i = w_i (weight / sum w + p a_i + q b_i).
    ma, mb = sa / sw, sb / sw
    saa, sab, sbb = saa - sw * ma * ma, sab - sw * ma * mb, sbb - sw * mb * mb
    determinant = saa * sbb - sab * sab
    mean = 0.5 * (saa + sbb)
    weight *= min(determinant / (_SPREAD * mean * mean), 1.0) if mean > 0.0 else 0.0
    least = sw * _LEVER * _LEVER
    saa, sbb = saa + least, sbb + least
    determinant = saa * sbb - sab * sab
    p = -weight * (ma * sbb - mb * sab) / determinant
    q = -weight * (mb * saa - ma * sab) / determinant
    even = weight / sw
    loads = [
        max(share * (even + p * (a - ma) + q * (b - mb)), 0.0) for (a, b), share in zip(arms, shares, strict=True)]
    total = sum(loads)
    return tuple([load * weight / total for load in loads] if total > 0.0 else loads)


def _held(mount: Triple, leg: LegStatics, load: float) -> Sequence[float]:
    """Return the torques with which a leg bears a load, N m, leaning inwards as far as that spares its motors."""
    if load == 0.0:
        return leg.weights
    (mx, my, _), (x, y, _) = mount, leg.foot
    ix, iy = mx - x, my - y
    way = math.hypot(ix, iy) or 1.0
    push = load / way
    ix, iy = push * ix, push * iy
    upright: list[float] = []
    leaning: list[float] = []
    along = square = 0.0
    for weight, lift, (cx, cy, _) in zip(leg.weights, leg.lifts, leg.columns, strict=True):
        torque, by = weight - load * lift, cx * ix + cy * iy
        upright.append(torque)
        leaning.append(by)
        along, square = along + torque * by, square + by * by
    if along <= 0.0:
        return upright
    lean = min(along / square, _LEAN)
    return [torque - lean * by for torque, by in zip(upright, leaning, strict=True)]


def up_in_base(roll: float, pitch: float) -> Triple:
    """Return the way up in the frame of a base that rolls and pitches, rad."""
    cp = math.cos(pitch)
    return -math.sin(pitch), cp * math.sin(roll), cp * math.cos(roll)


class Bearing:
    """Follows what the joints of one robot bear, as feet take over the weight from each other."""

    def __init__(self, model: RobotModel) -> None:
        self._seat, self._weight = model.heights.sit, model.mass * GRAVITY
        self._mass = model.mass
        self._legs = tuple((leg.span, (*leg.mount,), LegMasses(leg, model.foot_mass)) for leg in model.legs)
        self._shares = [0.0] * len(model.legs)

    def step(
        self, angles: Sequence[float], attitude: Pose, height: float, planted: Sequence[bool], dt: float
    ) -> Statics:
        """Advance by `dt` s.

        Args:
            angles: of all joints, rad.
            attitude: of the body: its roll and its pitch.
            height: of the body over its feet, m; down to its seat, the ground takes over from them.
            planted: which feet stand.
            dt: s since the last step.
        """
        change = dt / _TAKE_OVER
        self._shares = [
            min(share + change, 1.0) if stands else max(share - change, 0.0)
            for share, stands in zip(self._shares, planted, strict=True)]
        up = up_in_base(attitude.roll, attitude.pitch)
        legs: list[LegStatics] = []
        mx = my = mz = 0.0
        for span, _, masses in self._legs:
            leg, (x, y, z) = masses.statics(angles[span], up)
            legs.append(leg)
            mx, my, mz = mx + x, my + y, mz + z
        mass = self._mass
        borne = min(max((height - self._seat) / _SEATING, 0.0), 1.0)
        loads = shared_loads(
            [leg.foot for leg in legs], self._shares, (mx / mass, my / mass, mz / mass), borne * self._weight, up)
        torques: list[float] = []
        for (_, mount, _), leg, load in zip(self._legs, legs, loads, strict=True):
            torques.extend(_held(mount, leg, load))
        return Statics(tuple(legs), loads, tuple(torques))
