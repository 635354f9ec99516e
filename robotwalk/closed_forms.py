"""Inverse kinematics in closed form, for each kind of leg that has one. The joints' limits are the gate's business."""

import math
from collections.abc import Sequence

from robotwalk.model import Axis, Leg
from robotwalk.reach import Reach, Solution
from robotwalk.types import Vec3


class _Triangle:
    """A leg's two last links and the line from the first one's joint to the foot, in the plane they bend in.

    Where no triangle closes, or hardly one, that line is shortened or lengthened and keeps its direction: the leg
    points at what it cannot reach.
    """

    def __init__(self, first: float, second: float) -> None:
        self._reach = Reach.between(abs(first - second), first + second)
        self._two_first = 2.0 * first
        self._two_both = 2.0 * first * second
        self._squares_difference = first * first - second * second
        self._squares_sum = first * first + second * second

    def solve(self, d: float) -> tuple[float, float, float]:
        """Return the angle from a line of d m to the first link, the knee's bend, and by how much d was changed, m."""
        clamped = self._reach.soften(d)
        square = clamped * clamped
        at_first = math.acos((self._squares_difference + square) / (self._two_first * clamped))
        knee = math.acos((self._squares_sum - square) / self._two_both)
        return at_first, math.pi - knee, abs(d - clamped)


class CoxaFemurTibia:
    """Closed form for yaw, pitch, pitch with straight links: the arthropod leg, knee up."""

    def __init__(self, leg: Leg) -> None:
        coxa, femur, tibia = (joint.link.x for joint in leg.joints)
        self._mount = (*leg.mount,)
        self._cos, self._sin = math.cos(leg.yaw), math.sin(leg.yaw)
        self._coxa, self._femur, self._tibia = coxa, femur, tibia
        self._triangle = _Triangle(femur, tibia)

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
        (x, y, z), c, s = self._mount, self._cos, self._sin
        drop = self._femur * math.sin(femur) + self._tibia * math.sin(shin)
        return Vec3(x + c * out - s * side, y + s * out + c * side, z - drop)

    def solve(self, x: float, y: float, z: float) -> Solution:
        """Return the angles for a foot centre at (x, y, z) m in the base frame."""
        mx, my, mz = self._mount
        x, y, z = x - mx, y - my, z - mz
        out = self._cos * x + self._sin * y
        side = self._cos * y - self._sin * x
        reach = math.sqrt(out * out + side * side) - self._coxa
        shoulder, bend, miss = self._triangle.solve(math.sqrt(reach * reach + z * z))
        return Solution((math.atan2(side, out), -math.atan2(z, reach) - shoulder, bend), miss)


class HipAbduction:
    """Closed form for roll, pitch, pitch: the quadruped's leg, its thigh beside the hip's axis.

    The hip's roll turns the plane in which thigh and calf bend about the leg's x axis, at the distance of the
    hip's lateral link. The foot is taken to be on the lower side of the hip; the knee bends as at rest.
    """

    def __init__(self, leg: Leg) -> None:
        hip, thigh, calf = leg.joints
        self._mount = (*leg.mount,)
        self._cos, self._sin = math.cos(leg.yaw), math.sin(leg.yaw)
        self._offset, self._thigh, self._calf = hip.link.y, -thigh.link.z, -calf.link.z
        self._knee_back = 1.0 if calf.rest < 0.0 else -1.0
        self._triangle = _Triangle(self._thigh, self._calf)

    @staticmethod
    def fits(leg: Leg) -> bool:
        """Tell whether this solver takes the leg."""
        if tuple(joint.axis for joint in leg.joints) != (Axis.ROLL, Axis.PITCH, Axis.PITCH):
            return False
        hip, *shanks = leg.joints
        hanging = all(joint.link.z < 0.0 and joint.link.x == joint.link.y == 0.0 for joint in shanks)
        return hip.link.x == hip.link.z == 0.0 and hanging and shanks[-1].rest != 0.0

    def foot(self, angles: Sequence[float]) -> Vec3:
        """Return the foot's centre in the base frame, m."""
        hip, thigh, calf = angles
        shin = thigh + calf
        ahead = -self._thigh * math.sin(thigh) - self._calf * math.sin(shin)
        drop = self._thigh * math.cos(thigh) + self._calf * math.cos(shin)
        side = self._offset * math.cos(hip) + drop * math.sin(hip)
        (x, y, z), c, s = self._mount, self._cos, self._sin
        return Vec3(
            x + c * ahead - s * side, y + s * ahead + c * side,
            z + self._offset * math.sin(hip) - drop * math.cos(hip))

    def solve(self, x: float, y: float, z: float) -> Solution:
        """Return the angles for a foot centre at (x, y, z) m in the base frame."""
        mx, my, mz = self._mount
        x, y, z = x - mx, y - my, z - mz
        ahead = self._cos * x + self._sin * y
        side = self._cos * y - self._sin * x
        square = side * side + z * z - self._offset * self._offset
        drop = math.sqrt(max(square, 0.0))
        hip = math.atan2(z, side) - math.atan2(-drop, self._offset)
        shoulder, bend, miss = self._triangle.solve(math.sqrt(ahead * ahead + drop * drop))
        if square < 0.0:
            # Nearer to the hip's axis than the leg's plane ever comes.
            miss = math.hypot(miss, abs(self._offset) - math.hypot(side, z))
        back = self._knee_back
        thigh = math.atan2(-ahead, drop) + back * shoulder
        return Solution((math.remainder(hip, math.tau), thigh, -back * bend), miss)
