"""Where the body is to be: its course over the ground, its height, and its posture on top of both."""

import math
from collections.abc import Iterable

from robotwalk.types import LEVEL, UP, Pose, Triple, Twist, Vec3


def advanced(pose: Pose, twist: Twist, seconds: float) -> Pose:
    """Return a pose carried along the arc of a constant twist, exactly."""
    vx, vy, wz = twist
    turn = wz * seconds
    if abs(turn) < 1e-9:
        along, across = seconds, 0.5 * turn * seconds
    else:
        # By the half angle: 1 - cos(turn) would lose all its digits at a small turn.
        along, across = math.sin(turn) / wz, 2.0 * math.sin(0.5 * turn) ** 2 / wz
    dx, dy = vx * along - vy * across, vx * across + vy * along
    x, y, z, roll, pitch, yaw = pose
    c, s = math.cos(yaw), math.sin(yaw)
    return Pose(x + c * dx - s * dy, y + s * dx + c * dy, z, roll, pitch, yaw + turn)


def placed(pose: Pose, point: Triple) -> tuple[float, float]:
    """Return where a point of the base frame lies on the ground, if the body were level at this pose."""
    (x, y, _), yaw = point, pose.yaw
    c, s = math.cos(yaw), math.sin(yaw)
    return pose.x + c * x - s * y, pose.y + s * x + c * y


def composed(course: Pose, posture: Pose) -> Pose:
    """Return the body's pose for a course, nearly level, and a displacement from it, given in the base frame."""
    x, y = placed(course, (posture.x, posture.y, posture.z))
    return Pose(
        x, y, course.z + posture.z, course.roll + posture.roll, course.pitch + posture.pitch, course.yaw + posture.yaw)


def seen_from(pose: Pose, points: Iterable[Vec3]) -> list[Vec3]:
    """Return points of odom in the base frame of a body at `pose`."""
    px, py, pz, roll, pitch, yaw = pose
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    # Columns of Rz(yaw) Ry(pitch) Rx(roll): the base's axes in odom.
    xx, xy, xz = cy * cp, sy * cp, -sp
    yx, yy, yz = cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr
    zx, zy, zz = cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr
    seen = []
    for x, y, z in points:
        dx, dy, dz = x - px, y - py, z - pz
        seen.append(Vec3(
            xx * dx + xy * dy + xz * dz,
            yx * dx + yy * dy + yz * dz,
            zx * dx + zy * dy + zz * dz,
        ))
    return seen


class Attitude:
    """How a body at a pose lies in odom."""

    __slots__ = ("_pitch", "_roll", "_yaw")

    def __init__(self, pose: Pose) -> None:
        self._roll = math.cos(pose.roll), math.sin(pose.roll)
        self._pitch = math.cos(pose.pitch), math.sin(pose.pitch)
        self._yaw = math.cos(pose.yaw), math.sin(pose.yaw)

    def in_odom(self, vector: Triple) -> Vec3:
        """Return a vector of the base frame along odom's axes; a point needs the body's place added."""
        (cr, sr), (cp, sp), (cy, sy) = self._roll, self._pitch, self._yaw
        x, y, z = vector
        y, z = cr * y - sr * z, sr * y + cr * z
        x, z = cp * x + sp * z, cp * z - sp * x
        return Vec3(cy * x - sy * y, sy * x + cy * y, z)


def up_axis(pose: Pose) -> Vec3:
    """Return the up axis of a body's base at `pose`, in odom."""
    if pose.roll == pose.pitch == 0.0:
        return UP
    cr, sr = math.cos(pose.roll), math.sin(pose.roll)
    sp, cy, sy = math.sin(pose.pitch), math.cos(pose.yaw), math.sin(pose.yaw)
    return Vec3(cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, math.cos(pose.pitch) * cr)


class Ramp:
    """A value that follows another smoothly: bounded speed, no step in it (second order, critically damped)."""

    def __init__(self, value: float, speed: float, seconds: float = 0.15) -> None:
        self.value = value
        self.rate = 0.0
        self._speed = speed
        self._gain = 2.0 / seconds

    def step(self, target: float, dt: float) -> float:
        """Advance by `dt` s and return the value."""
        gain, speed = self._gain, self._speed
        wanted = min(max(0.5 * gain * (target - self.value), -speed), speed)
        self.rate += (wanted - self.rate) * min(2.0 * gain * dt, 1.0)
        self.value += self.rate * dt
        return self.value

    def settled(self, target: float, tolerance: float) -> bool:
        """Tell whether the value is at its target and stays."""
        return abs(target - self.value) <= tolerance and abs(self.rate) <= tolerance


class Body:
    """The body's course in odom and its posture."""

    # How fast the body rises and leans: slow enough that the feet keep their load.
    _RISE = 0.06  # m/s
    _SHIFT = 0.05  # m/s
    _LEAN = 0.35  # rad/s
    _REACHED = 1e-3  # m or rad, and per second

    def __init__(self, height: float) -> None:
        self.course = self.pose = LEVEL._replace(z=height)
        self.height = Ramp(height, self._RISE)
        self._level = True
        self._posture = [Ramp(0.0, self._SHIFT) for _ in range(3)] + [Ramp(0.0, self._LEAN) for _ in range(3)]

    def step(self, twist: Twist, height: float, posture: Pose, dt: float, *, still: bool = False) -> Pose:
        """Advance by `dt` s; return the body's pose in odom. Keep the height and the posture as they are if `still`."""
        x, y, _, roll, pitch, yaw = advanced(self.course, twist, dt)
        if still:
            height, posture = self.height.value, Pose(*(ramp.value for ramp in self._posture))
        self.course = Pose(x, y, self.height.step(height, dt), roll, pitch, yaw)
        if posture is LEVEL and self._level:
            self.pose = self.course
        else:
            leaning = Pose(*(ramp.step(target, dt) for ramp, target in zip(self._posture, posture, strict=True)))
            self._level = posture == LEVEL and all(ramp.settled(0.0, 1e-6) for ramp in self._posture)
            self.pose = composed(self.course, leaning)
        return self.pose

    @property
    def carried(self) -> float:
        """How high the body is carried over its feet, m."""
        return self.height.value + self._posture[2].value

    def shifted_from(self, posture: Pose) -> float:
        """Return how far the body is from the place that a posture has for it, m."""
        x, y, *_ = self._posture
        return math.hypot(x.value - posture.x, y.value - posture.y)

    def settled(self, height: float, posture: Pose) -> bool:
        """Tell whether the body has come to this height and posture."""
        if not self.height.settled(height, self._REACHED):
            return False
        if posture is LEVEL and self._level:
            return True
        return all(r.settled(p, self._REACHED) for r, p in zip(self._posture, posture, strict=True))
