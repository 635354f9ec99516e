"""From joint angles to the foot and back, one leg at a time, in the base frame.

Forward kinematics takes any serial chain. Inverse kinematics is closed form for each kind of leg that has
one; `solver_for` picks it by the chain's axes and links (locomotion sources: PPS section 3, PARAM's leg).
"""

import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol

from robotwalk.errors import ConfigError
from robotwalk.model import Axis, Leg, RobotModel
from robotwalk.types import Vec3

# A leg stretched to its very end has no speed left along itself; IK stays this far off, in metres.
_STRETCH_MARGIN = 1e-6


class Solution(NamedTuple):
    """Joint angles that bring the foot to a target, or as near as the leg's lengths allow."""

    angles: tuple[float, ...]  # rad, from the body to the foot
    miss: float  # m from the target to where the foot is; 0 within reach


class LegSolver(Protocol):
    """Both kinematics of one leg, in closed form."""

    def foot(self, angles: Sequence[float]) -> Vec3:
        """Return what `foot_position` does, faster."""
        ...

    def solve(self, x: float, y: float, z: float) -> Solution:
        """Return the angles for a foot centre at (x, y, z) m in the base frame. Never raises."""
        ...


def foot_position(leg: Leg, angles: Sequence[float]) -> Vec3:
    """Return the foot's centre in the base frame, m, for joint angles in rad."""
    return chain_points(leg, angles)[-1]


def chain_points(leg: Leg, angles: Sequence[float]) -> list[Vec3]:
    """Return each joint's origin and at last the foot's centre, in the base frame, m."""
    points = [leg.mount]
    # Columns of the rotation from the current link to the base.
    c, s = math.cos(leg.yaw), math.sin(leg.yaw)
    x, y, z = leg.mount
    ax, ay, az = (c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)
    for joint, angle in zip(leg.joints, angles, strict=True):
        c, s = math.cos(angle), math.sin(angle)
        if joint.axis is Axis.YAW:
            ax, ay = _turn(ax, ay, c, s)
        elif joint.axis is Axis.PITCH:
            az, ax = _turn(az, ax, c, s)
        else:
            ay, az = _turn(ay, az, c, s)
        lx, ly, lz = joint.link
        x += ax[0] * lx + ay[0] * ly + az[0] * lz
        y += ax[1] * lx + ay[1] * ly + az[1] * lz
        z += ax[2] * lx + ay[2] * ly + az[2] * lz
        points.append(Vec3(x, y, z))
    return points


_Column = tuple[float, float, float]


def _turn(first: _Column, second: _Column, c: float, s: float) -> tuple[_Column, _Column]:
    """Rotate two axes by an angle from the first towards the second."""
    return (
        (c * first[0] + s * second[0], c * first[1] + s * second[1], c * first[2] + s * second[2]),
        (c * second[0] - s * first[0], c * second[1] - s * first[1], c * second[2] - s * first[2]),
    )


class CoxaFemurTibia:
    """Closed form for yaw, pitch, pitch with straight links: the arthropod leg, knee up.

    In the leg's plane the femur and the tibia are two sides of a triangle whose third, d, runs from the
    femur's joint to the foot. Where no triangle closes, d is cut to what the lengths allow and keeps its
    direction: the leg points at what it cannot reach.
    """

    def __init__(self, leg: Leg) -> None:
        coxa, femur, tibia = (joint.link.x for joint in leg.joints)
        self._mount = leg.mount
        self._cos, self._sin = math.cos(leg.yaw), math.sin(leg.yaw)
        self._coxa, self._femur, self._tibia = coxa, femur, tibia
        self._longest = femur + tibia - _STRETCH_MARGIN
        self._shortest = abs(femur - tibia) + _STRETCH_MARGIN
        self._two_femur = 2.0 * femur
        self._two_femur_tibia = 2.0 * femur * tibia
        self._squares_difference = femur * femur - tibia * tibia
        self._squares_sum = femur * femur + tibia * tibia

    @staticmethod
    def fits(leg: Leg) -> bool:
        """Tell whether this solver takes the leg."""
        axes = tuple(joint.axis for joint in leg.joints)
        straight = all(joint.link.x > 0.0 and joint.link.y == joint.link.z == 0.0 for joint in leg.joints)
        return axes == (Axis.YAW, Axis.PITCH, Axis.PITCH) and straight

    def foot(self, angles: Sequence[float]) -> Vec3:
        """Return the foot's centre in the base frame, m."""
        coxa, femur, tibia = angles
        shin = femur + tibia
        reach = self._coxa + self._femur * math.cos(femur) + self._tibia * math.cos(shin)
        out, side = reach * math.cos(coxa), reach * math.sin(coxa)
        mount, c, s = self._mount, self._cos, self._sin
        drop = self._femur * math.sin(femur) + self._tibia * math.sin(shin)
        return Vec3(mount.x + c * out - s * side, mount.y + s * out + c * side, mount.z - drop)

    def solve(self, x: float, y: float, z: float) -> Solution:
        """Return the angles for a foot centre at (x, y, z) m in the base frame."""
        mount = self._mount
        x -= mount.x
        y -= mount.y
        z -= mount.z
        out = self._cos * x + self._sin * y
        side = self._cos * y - self._sin * x
        reach = math.sqrt(out * out + side * side) - self._coxa
        d = math.sqrt(reach * reach + z * z)
        clamped = min(max(d, self._shortest), self._longest)
        square = clamped * clamped
        shoulder = math.acos((self._squares_difference + square) / (self._two_femur * clamped))
        knee = math.acos((self._squares_sum - square) / self._two_femur_tibia)
        angles = (math.atan2(side, out), -math.atan2(z, reach) - shoulder, math.pi - knee)
        return Solution(angles, abs(d - clamped))


def resting_angles(model: RobotModel, height: float) -> list[float]:
    """Return all joints' angles with the body level at `height` m and the feet at rest on the ground."""
    angles: list[float] = []
    for leg in model.legs:
        foot = leg.rest_foot
        angles.extend(solver_for(leg).solve(foot.x, foot.y, model.foot_radius - height).angles)
    return angles


def solver_for(leg: Leg) -> LegSolver:
    """Return the closed form for a leg.

    Raises:
        ConfigError: there is none for its chain.
    """
    if CoxaFemurTibia.fits(leg):
        return CoxaFemurTibia(leg)
    axes = ", ".join(joint.axis.name.lower() for joint in leg.joints)
    raise ConfigError(f"leg {leg.name}: no inverse kinematics for the chain ({axes}); known: yaw, pitch, pitch")
