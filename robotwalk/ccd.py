"""Inverse kinematics of any serial chain, its limits kept: cyclic coordinate descent (PPS section 3; Wang, Chen 1991).

One joint after the other, from the foot to the body, takes the angle within its limits that brings the foot nearest to
the target. Alone that creeps along valleys. So behind every second sweep all joints go on together in the direction of
the last sweep, as far as the secant of the miss says (Anderson's mixing of depth one), if that helps: five sweeps
instead of fifty. The joints next to the foot would do most of it; where there are more than a foot's place needs, each
takes a share only, and all are drawn to their rest.
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from robotwalk.model import Axis, Joint, Leg
from robotwalk.reach import Reach, Solution
from robotwalk.types import Vec3

_MOST_SWEEPS = 100
_CLOSE = 1e-7  # m; nearer need not be
_STUCK = 1e-10  # m; a sweep that brings the foot no nearer than this is the last
_FARTHEST_STEP = 50.0  # times the last sweep
_WARM = 0.05  # m; a target this near the last one is approached from the last solution
_ENOUGH = 3  # joints that a foot's place needs; the pose of a chain of more is settled by the next two
_LEAST_SHARE = 0.05
_PULL = 0.02  # of the way to rest, for each solve
_MOST_SEEDS = 32
_ORIGIN = Vec3(0.0, 0.0, 0.0)
_FAR = Vec3(100.0, 0.0, 0.0)  # m
_NOTHING = 1e-24  # m^4; a lever too short to turn

# The two axes that a joint turns, the first towards the second, and the one about which.
_PLANES = {Axis.YAW: (0, 1, 2), Axis.PITCH: (2, 0, 1), Axis.ROLL: (1, 2, 0)}


class _Hinge(NamedTuple):
    """A joint, by the indices of its axes."""

    first: int
    second: int
    along: int
    link: Vec3
    lower: float
    upper: float

    def carried(self, point: Vec3, angle: float) -> Vec3:
        """Return a point of the frame behind the link, as it is seen from in front of the joint."""
        i, j, k, link, _, _ = self
        a, b = point[i] + link[i], point[j] + link[j]
        c, s = math.cos(angle), math.sin(angle)
        seen = [0.0, 0.0, 0.0]
        seen[i], seen[j], seen[k] = c * a - s * b, s * a + c * b, point[k] + link[k]
        return Vec3(*seen)

    def nearest(self, angle: float) -> float:
        """Return the angle within the limits that is nearest to this one, round the circle."""
        turns = math.tau * math.ceil((self.lower - angle) / math.tau)
        if angle + turns <= self.upper:
            return angle + turns
        below, above = math.remainder(angle - self.lower, math.tau), math.remainder(angle - self.upper, math.tau)
        return self.lower if abs(below) < abs(above) else self.upper


class _Descent:
    """Brings the end of a chain to a point, in the frame in front of its first joint."""

    def __init__(self, joints: Sequence[Joint]) -> None:
        self.hinges = tuple(_Hinge(*_PLANES[joint.axis], joint.link, joint.lower, joint.upper) for joint in joints)
        self.rest = tuple(min(max(joint.rest, joint.lower), joint.upper) for joint in joints)
        self._shares = self._own_shares() if len(joints) > _ENOUGH else [1.0] * len(joints)

    def _own_shares(self) -> list[float]:
        """Return each joint's share by the square of its lever to the end, at rest."""
        levers, end = [], _ORIGIN
        for hinge, angle in zip(reversed(self.hinges), reversed(self.rest), strict=True):
            end = hinge.carried(end, angle)
            levers.append(end[hinge.first] ** 2 + end[hinge.second] ** 2)
        longest = max(levers)
        return [max(lever / longest, _LEAST_SHARE) for lever in reversed(levers)]

    def starts(self) -> Iterator[Sequence[float]]:
        """Yield the resting pose, then those with each joint at a quarter or three quarters of its range."""
        yield self.rest
        shares = itertools.product((0.25, 0.75), repeat=len(self.hinges))
        for choice in itertools.islice(shares, _MOST_SEEDS):
            yield [
                hinge.lower + share * (hinge.upper - hinge.lower)
                for hinge, share in zip(self.hinges, choice, strict=True)]

    def descend(self, angles: Sequence[float], target: Vec3) -> tuple[Sequence[float], float]:
        """Return the angles reached from a start, and how far from the target they leave the end, m."""
        tx, ty, tz = target
        before: tuple[Sequence[float], float, float, float] | None = None
        miss = math.inf
        for _ in range(_MOST_SWEEPS):
            last_miss = miss
            angles, (x, y, z) = self._sweep(angles, target)
            rx, ry, rz = x - tx, y - ty, z - tz
            miss = math.sqrt(rx * rx + ry * ry + rz * rz)
            if miss <= _CLOSE or last_miss - miss < _STUCK:
                break
            if before is not None:
                last, lx, ly, lz = before
                dx, dy, dz = rx - lx, ry - ly, rz - lz
                square = dx * dx + dy * dy + dz * dz
                step = -(rx * dx + ry * dy + rz * dz) / square if square > 0.0 else 0.0
                if step > 0.0:
                    farther = self._farther(last, angles, min(step, _FARTHEST_STEP))
                    then = math.dist(self.end(farther), target)
                    if then < miss:
                        angles, miss, before = farther, then, None
                        continue
            before = angles, rx, ry, rz
        return angles, miss

    def _farther(self, last: Sequence[float], now: Sequence[float], step: float) -> list[float]:
        return [
            min(max(b + step * (b - a), hinge.lower), hinge.upper)
            for a, b, hinge in zip(last, now, self.hinges, strict=True)]

    def end(self, angles: Sequence[float]) -> Vec3:
        """Return where the end is for these angles, m."""
        end = _ORIGIN
        for hinge, angle in zip(reversed(self.hinges), reversed(angles), strict=True):
            end = hinge.carried(end, angle)
        return end

    def _sweep(self, angles: Sequence[float], target: Vec3) -> tuple[list[float], tuple[float, float, float]]:
        """Turn each joint once, the last one first; return the angles and where the foot is then."""
        # The target as each joint sees it, before its own turn.
        seen = [list(target)]
        for hinge, angle in zip(self.hinges[:-1], angles, strict=False):
            i, j, k, link, _, _ = hinge
            c, s, p = math.cos(angle), math.sin(angle), seen[-1]
            q = [0.0, 0.0, 0.0]
            q[i] = c * p[i] + s * p[j] - link[i]
            q[j] = c * p[j] - s * p[i] - link[j]
            q[k] = p[k] - link[k]
            seen.append(q)
        turned, shares = list(angles), self._shares
        foot = [0.0, 0.0, 0.0]
        for index in range(len(turned) - 1, -1, -1):
            hinge, goal = self.hinges[index], seen[index]
            i, j, k, link, lower, upper = hinge
            a, b = foot[i] + link[i], foot[j] + link[j]
            cross, dot = a * goal[j] - b * goal[i], a * goal[i] + b * goal[j]
            angle = turned[index]
            if cross * cross + dot * dot > _NOTHING:
                best = math.atan2(cross, dot)
                if not lower <= best <= upper:
                    best = hinge.nearest(best)
                angle += shares[index] * (best - angle)
                turned[index] = angle
            c, s = math.cos(angle), math.sin(angle)
            moved = [0.0, 0.0, 0.0]
            moved[i], moved[j], moved[k] = c * a - s * b, s * a + c * b, foot[k] + link[k]
            foot = moved
        return turned, (foot[0], foot[1], foot[2])


class CyclicDescent:
    """Both kinematics of one leg. It goes on from its last solution, so each leg of each user needs its own.

    A first or far-off target is approached from several poses, the resting one first; the first that arrives is taken,
    else the nearest. Targets that follow each other never make the leg change its pose at once.
    """

    def __init__(self, leg: Leg) -> None:
        self._mount = leg.mount
        self._cos, self._sin = math.cos(leg.yaw), math.sin(leg.yaw)
        self._chain = _Descent(leg.joints)
        self._pull = _PULL if len(leg.joints) > _ENOUGH else 0.0
        self._swivel = _Swivel(leg.joints)
        self._angles: Sequence[float] = self._chain.rest
        self._target: Vec3 | None = None

    def foot(self, angles: Sequence[float]) -> Vec3:
        """Return the foot's centre in the base frame, m."""
        x, y, z = self._chain.end(angles)
        mount = self._mount
        return Vec3(mount.x + self._cos * x - self._sin * y, mount.y + self._sin * x + self._cos * y, mount.z + z)

    def solve(self, x: float, y: float, z: float) -> Solution:
        """Return the angles for a foot centre at (x, y, z) m in the base frame."""
        x, y, z = x - self._mount.x, y - self._mount.y, z - self._mount.z
        wanted = Vec3(self._cos * x + self._sin * y, self._cos * y - self._sin * x, z)
        target = self._swivel.shortened(wanted)
        if self._target is not None and math.dist(target, self._target) < _WARM:
            pull = self._pull
            start = [a + pull * (rest - a) for a, rest in zip(self._angles, self._chain.rest, strict=True)]
            angles, miss = self._chain.descend(start, target)
        else:
            angles, miss = _best(self._chain, target)
        self._angles, self._target = angles, target
        miss = miss if target == wanted else math.dist(self._chain.end(angles), wanted)
        return Solution(tuple(angles), miss if miss > _CLOSE else 0.0)


def _best(chain: _Descent, target: Vec3) -> tuple[Sequence[float], float]:
    best: Sequence[float] = ()
    least = math.inf
    for start in chain.starts():
        angles, miss = chain.descend(start, target)
        if miss < least:
            best, least = angles, miss
        if miss <= _CLOSE:
            break
    return best, least


def _planar_reach(joints: Sequence[Joint]) -> Reach:
    """Return how near to its begin the end of a chain can come that bends in one plane, and how far away."""
    chain = _Descent(joints)
    nearest, farthest = (
        min(chain.descend(start, target)[1] for start in chain.starts()) for target in (_ORIGIN, _FAR))
    return Reach.between(nearest, _FAR.x - farthest)


class _Swivel:
    """Where the line begins that a leg points along, and how far its foot may be along that.

    Where the first joint turns the plane in which all others bend, that is at the second joint; else at the first. How
    near and how far is what the joints behind allow by their limits, or else by the links' lengths.
    """

    def __init__(self, joints: Sequence[Joint]) -> None:
        first, *others = joints
        self._axis: Axis | None = None
        self._link = _ORIGIN
        self._beside = 0.0
        if others and first.axis is not Axis.PITCH and all(joint.axis is Axis.PITCH for joint in others):
            self._axis = first.axis
            self._link = first.link
            self._beside = sum(joint.link.y for joint in joints)  # of the first joint's axis, the plane
            others[0] = others[0]._replace(lower=-math.pi, upper=math.pi)
            self._reach = _planar_reach([joint._replace(link=joint.link._replace(y=0.0)) for joint in others])
        else:
            lengths = [math.hypot(*joint.link) for joint in joints]
            self._reach = Reach.between(max(2.0 * max(lengths) - sum(lengths), 0.0), sum(lengths))

    def shortened(self, wanted: Vec3) -> Vec3:
        """Return the target for a foot, or the one nearer or farther on the same line that it can reach."""
        x, y, z = wanted
        if self._axis is None:
            distance = math.sqrt(x * x + y * y + z * z)
            share = self._reach.soften(distance) / distance if distance > 0.0 else 1.0
            return wanted if share == 1.0 else Vec3(share * x, share * y, share * z)
        link, beside = self._link, self._beside
        yaws = self._axis is Axis.YAW
        around = x * x + y * y if yaws else y * y + z * z
        radius = math.sqrt(max(around - beside * beside, 0.0))  # from the first axis, in the plane
        dx, dz = (radius - link.x, z - link.z) if yaws else (x - link.x, -radius - link.z)
        distance = math.sqrt(dx * dx + dz * dz)
        share = self._reach.soften(distance) / distance if distance > 0.0 else 1.0
        if share == 1.0 or radius == 0.0:
            return wanted
        if yaws:
            c, s = self._carried(radius, link.x + share * dx)
            return Vec3(c * x - s * y, s * x + c * y, link.z + share * dz)
        c, s = self._carried(radius, -link.z - share * dz)
        return Vec3(link.x + share * dx, c * y - s * z, s * y + c * z)

    def _carried(self, radius: float, new_radius: float) -> tuple[float, float]:
        """Return the turn, with a change of length, that takes a point of the plane to another radius in it."""
        beside = self._beside
        square = radius * radius + beside * beside
        return (radius * new_radius + beside * beside) / square, beside * (radius - new_radius) / square
