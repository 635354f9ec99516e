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
from robotwalk.types import Pose, Vec3

GRAVITY = 9.81  # m/s^2
_TAKE_OVER = 0.06  # s in which a foot takes its load, or gives it up
_SEATING = 0.02  # m of height over which the feet take over from the belly
_LEAN = 0.2  # of a foot's load that it may push outwards, and friction holds it: an arch spares its bearers
_SPREAD = 0.2  # of feet across their line, 0 in a line to 1 all around; with less a robot is falling, not standing
_LEVER = 0.02  # m; feet whose spread in some direction is less than about this are in a line


class LegStatics(NamedTuple):
    """One leg at one moment, in the base frame."""

    foot: Vec3  # m
    columns: tuple[Vec3, ...]  # of its Jacobian: the foot's velocity per rad/s of each joint, m
    weights: tuple[float, ...]  # N m: the torque of each joint that holds up the links behind it


class Statics(NamedTuple):
    """The whole robot at one moment."""

    legs: tuple[LegStatics, ...]
    loads: tuple[float, ...]  # N on each foot, along the way up
    torques: tuple[float, ...]  # N m, in joint order


def leg_statics(leg: Leg, foot_mass: float, angles: Sequence[float], up: Vec3) -> tuple[LegStatics, Vec3]:
    """Return a leg's statics for joint angles (rad), and its mass times the place of its centre of mass, kg m.

    Args:
        leg: the chain; each link's mass is at its middle.
        foot_mass: kg.
        angles: of its joints, rad.
        up: the unit vector against gravity, in the base frame.
    """
    c, s = math.cos(leg.yaw), math.sin(leg.yaw)
    ax, ay, az = (c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)
    x, y, z = leg.mount
    origins: list[tuple[float, float, float]] = []
    axes: list[tuple[float, float, float]] = []
    for joint, angle in zip(leg.joints, angles, strict=True):
        origins.append((x, y, z))
        c, s = math.cos(angle), math.sin(angle)
        # Turn the two axes across the joint's from the first towards the second.
        if joint.axis is Axis.YAW:
            axes.append(az)
            ax, ay = (
                (c * ax[0] + s * ay[0], c * ax[1] + s * ay[1], c * ax[2] + s * ay[2]),
                (c * ay[0] - s * ax[0], c * ay[1] - s * ax[1], c * ay[2] - s * ax[2]))
        elif joint.axis is Axis.PITCH:
            axes.append(ay)
            az, ax = (
                (c * az[0] + s * ax[0], c * az[1] + s * ax[1], c * az[2] + s * ax[2]),
                (c * ax[0] - s * az[0], c * ax[1] - s * az[1], c * ax[2] - s * az[2]))
        else:
            axes.append(ax)
            ay, az = (
                (c * ay[0] + s * az[0], c * ay[1] + s * az[1], c * ay[2] + s * az[2]),
                (c * az[0] - s * ay[0], c * az[1] - s * ay[1], c * az[2] - s * ay[2]))
        lx, ly, lz = joint.link
        x += ax[0] * lx + ay[0] * ly + az[0] * lz
        y += ax[1] * lx + ay[1] * ly + az[1] * lz
        z += ax[2] * lx + ay[2] * ly + az[2] * lz
    mass, mx, my, mz = foot_mass, foot_mass * x, foot_mass * y, foot_mass * z
    ux, uy, uz = up
    columns: list[Vec3] = []
    weights: list[float] = []
    fx, fy, fz = x, y, z  # the far end of the link
    for (ox, oy, oz), (jx, jy, jz), joint in zip(reversed(origins), reversed(axes), reversed(leg.joints), strict=True):
        half = 0.5 * joint.mass
        mass += joint.mass
        mx, my, mz = mx + half * (ox + fx), my + half * (oy + fy), mz + half * (oz + fz)
        dx, dy, dz = x - ox, y - oy, z - oz
        columns.append(Vec3(jy * dz - jz * dy, jz * dx - jx * dz, jx * dy - jy * dx))
        dx, dy, dz = mx - mass * ox, my - mass * oy, mz - mass * oz
        weights.append(GRAVITY * (
            (jy * dz - jz * dy) * ux + (jz * dx - jx * dz) * uy + (jx * dy - jy * dx) * uz))
        fx, fy, fz = ox, oy, oz
    return LegStatics(Vec3(x, y, z), tuple(columns[::-1]), tuple(weights[::-1])), Vec3(mx, my, mz)


def shared_loads(
    feet: Sequence[Vec3], shares: Sequence[float], centre: Vec3, weight: float, up: Vec3
) -> tuple[float, ...]:
    """Return the load of each foot, N, by the shares (0 to 1) with which they stand; none pulls.

    Where the standing feet cannot hold the centre of mass, because they are in a line or it is outside their
    polygon, the moments are not balanced to the last.
    """
    # The feet seen from the centre of mass, in two axes across `up`.
    ux, uy, uz = up
    norm = math.hypot(ux, uz)
    ex, ez = uz / norm, -ux / norm  # across up, in the base's x-z plane
    gx, gy, gz = uy * ez, uz * ex - ux * ez, -uy * ex  # up x e
    sw = sa = sb = saa = sab = sbb = 0.0
    arms: list[tuple[float, float]] = []
    for foot, share in zip(feet, shares, strict=True):
        dx, dy, dz = foot.x - centre.x, foot.y - centre.y, foot.z - centre.z
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
    return tuple(load * weight / total for load in loads) if total > 0.0 else tuple(loads)


def _held(leg: Leg, statics: LegStatics, load: float, up: Vec3) -> list[float]:
    """Return the torques with which a leg bears a load, N m, leaning inwards as far as that spares its motors."""
    foot, (ux, uy, uz) = statics.foot, up
    ix, iy = leg.mount.x - foot.x, leg.mount.y - foot.y
    way = math.hypot(ix, iy) or 1.0
    ix, iy = ix / way, iy / way
    upright = [
        weight - load * (column.x * ux + column.y * uy + column.z * uz)
        for weight, column in zip(statics.weights, statics.columns, strict=True)]
    leaning = [load * (column.x * ix + column.y * iy) for column in statics.columns]
    square = sum(lean * lean for lean in leaning)
    if square == 0.0:
        return upright
    best = sum(torque * lean for torque, lean in zip(upright, leaning, strict=True)) / square
    lean = min(max(best, 0.0), _LEAN)
    return [torque - lean * by for torque, by in zip(upright, leaning, strict=True)]


def up_in_base(roll: float, pitch: float) -> Vec3:
    """Return the way up in the frame of a base that rolls and pitches, rad."""
    cp = math.cos(pitch)
    return Vec3(-math.sin(pitch), cp * math.sin(roll), cp * math.cos(roll))


class Bearing:
    """Follows what the joints of one robot bear, as feet take over the weight from each other."""

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self._shares = [0.0] * len(model.legs)

    def step(self, angles: Sequence[float], pose: Pose, planted: Sequence[bool], dt: float) -> Statics:
        """Advance by `dt` s.

        Args:
            angles: of all joints, rad.
            pose: of the body; down to its seat, the ground takes over from the feet.
            planted: which feet stand.
            dt: s since the last step.
        """
        model, change = self._model, dt / _TAKE_OVER
        self._shares = [
            min(share + change, 1.0) if stands else max(share - change, 0.0)
            for share, stands in zip(self._shares, planted, strict=True)]
        up = up_in_base(pose.roll, pose.pitch)
        legs: list[LegStatics] = []
        mx = my = mz = 0.0
        for leg in model.legs:
            statics, (x, y, z) = leg_statics(leg, model.foot_mass, angles[leg.span], up)
            legs.append(statics)
            mx, my, mz = mx + x, my + y, mz + z
        mass = model.mass
        borne = min(max((pose.z - model.heights.sit) / _SEATING, 0.0), 1.0)
        loads = shared_loads(
            [leg.foot for leg in legs], self._shares, Vec3(mx / mass, my / mass, mz / mass), borne * mass * GRAVITY, up)
        torques: list[float] = []
        for leg, statics, load in zip(model.legs, legs, loads, strict=True):
            torques.extend(_held(leg, statics, load, up))
        return Statics(tuple(legs), loads, tuple(torques))
