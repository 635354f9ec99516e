"""Keeps legs off each other and off the body: links are capsules, the body is a box, as the robot's file has them.

No point of a leg goes farther than its joints turn times its distance from them. So two legs that were so far apart
cannot meet before both together have gone so far; only then are they looked at again (conservative advancement,
Mirtich 1996). A leg is stopped while it still can stop: where it would come to rest, braking as hard as the gate lets
it, must be free. Legs that are too near may part.
"""

import itertools
import math
from collections.abc import Sequence

from robotwalk.capsules import between_segments, to_box
from robotwalk.chain import chain_points
from robotwalk.model import Leg, RobotModel
from robotwalk.types import Vec3

MARGIN = 0.004  # m; assumed: what joints give and lag
_MOUNTED = 2  # links of a leg, that are so near the body that their joints' limits must keep them off it
_BESIDE = 0.020  # m; links that are nearer than this at rest lie beside each other by design: their limits are enough
_SAMPLES = {1: 9, 2: 7, 3: 5}  # of each joint's range, by how many the leg has; else three
_CLOSING = 1e-9  # m


_Box = tuple[Vec3, Vec3]  # its lowest and its highest corner


class _Limb:
    """A leg with what its motion can reach."""

    def __init__(self, leg: Leg, foot_radius: float) -> None:
        self.leg = leg
        self.span = leg.span
        lengths = [math.hypot(*joint.link) for joint in leg.joints]
        # The farthest that any point can be from each joint, m.
        self.levers = [sum(lengths[index:]) for index in range(len(lengths))]
        self.radii = [joint.radius for joint in leg.joints]
        self.radii[-1] = max(self.radii[-1], foot_radius)
        self.rest = chain_points(leg, [joint.rest for joint in leg.joints])
        self._known: list[tuple[Sequence[float], list[Vec3]]] = []  # all joints' angles, and its points there

    def points(self, angles: Sequence[float]) -> list[Vec3]:
        """Return the ends of its links, m, for the angles of all joints."""
        for known, points in self._known:
            if known is angles:
                return points
        points = chain_points(self.leg, angles[self.span])
        self._known = [(angles, points), *self._known[:1]]
        return points

    def to_body(self, points: Sequence[Vec3], link: int, half: Vec3) -> float:
        """Return how far a link is from the body, m."""
        return to_box(points[link], points[link + 1], half) - self.radii[link]

    def reach(self) -> list[_Box]:
        """Return boxes that its links cannot leave, m."""
        count = _SAMPLES.get(len(self.leg.joints), 3)
        ranges = []
        for joint in self.leg.joints:
            step = (joint.upper - joint.lower) / (count - 1)
            ranges.append([joint.lower + step * index for index in range(count)])
        poses = [chain_points(self.leg, angles) for angles in itertools.product(*ranges)]
        boxes, between = [], 0.0  # between: how far a link may bulge out between two samples
        for link, radius in enumerate(self.radii):
            step = ranges[link][1] - ranges[link][0]
            between += self.levers[link] * (1.0 - math.cos(0.5 * min(step, math.pi)))
            ends = [point for pose in poses for point in pose[link:link + 2]]
            low, high = (Vec3(*(pick(end[axis] for end in ends) for axis in range(3))) for pick in (min, max))
            slack = radius + between
            boxes.append((Vec3(*(value - slack for value in low)), Vec3(*(value + slack for value in high))))
        return boxes


class Pair:
    """Two legs, or a leg and the body, and the links of each that may meet."""

    def __init__(self, first: _Limb, second: _Limb | None, links: list[tuple[int, int]], half: Vec3) -> None:
        """Pair a leg with another one, or with a body of these half lengths."""
        self.first, self.second, self.links = first, second, links
        self._half = half
        self._spans = tuple(slice(min(side), max(side) + 2) for side in zip(*links, strict=True))
        # A way that parts them at rest, and how far they stick out along it.
        ends = first.rest[self._spans[0]]
        if second is None:
            faces = [(axis, sign) for axis in range(3) for sign in (1.0, -1.0)]
            axis, sign = max(faces, key=lambda face: min(face[1] * end[face[0]] for end in ends) - half[face[0]])
            self._across = Vec3(*(sign if other == axis else 0.0 for other in range(3)))
            self._thick = max(first.radii) + half[axis]
        else:
            here, there = _middle(ends), _middle(second.rest[self._spans[1]])
            x, y = there.x - here.x, there.y - here.y
            way = math.hypot(x, y) or 1.0
            self._across = Vec3(x / way, y / way, 0.0)
            self._thick = max(first.radii) + max(second.radii)
        self.until = -math.inf  # m, that both together may have gone before they can meet

    def gap(self, angles: Sequence[float]) -> float:
        """Return how far apart they are along one way, m: no farther than they are, and quickly told."""
        x, y, z = self._across
        here = [x * a + y * b + z * c for a, b, c in self.first.points(angles)[self._spans[0]]]
        if self.second is None:
            return min(here) - self._thick
        there = [x * a + y * b + z * c for a, b, c in self.second.points(angles)[self._spans[1]]]
        return min(there) - max(here) - self._thick

    def apart(self, angles: Sequence[float]) -> float:
        """Return how far apart they are at these angles of all joints, m; less than 0 inside each other."""
        here = self.first.points(angles)
        if self.second is None:
            return min([self.first.to_body(here, link, self._half) for link, _ in self.links])
        there = self.second.points(angles)
        return min([between(self.first, here, a, self.second, there, b) for a, b in self.links])


class SelfCollision:
    """Looks after one robot."""

    def __init__(self, model: RobotModel, speeds: Sequence[float], accelerations: Sequence[float]) -> None:
        """Prepare for joints of these largest speeds, rad/s, and accelerations, rad/s^2, in joint order."""
        self.limbs = [_Limb(leg, model.foot_radius) for leg in model.legs]
        self._levers = [lever for limb in self.limbs for lever in limb.levers]
        self._brakes = [0.5 / acceleration for acceleration in accelerations]  # what braking takes, s^2/rad
        self._longest = max(speed * brake for speed, brake in zip(speeds, self._brakes, strict=True))  # s
        self.pairs = _pairs(self.limbs, Vec3(*(0.5 * length for length in model.body_box)))
        # Who they are, by their places in what follows: each leg's, and last the body's, which stays where it is.
        places = {limb: place for place, limb in enumerate((*self.limbs, None))}
        self._who = [(places[pair.first], places[pair.second]) for pair in self.pairs]
        self._gone = [0.0] * len(places)  # m, the most that any of its points can have gone so far
        self._ahead = [0.0] * len(places)  # m, and by when it stands, if it brakes now

    def reset(self) -> None:
        """Start anew, from wherever the joints are."""
        for pair in self.pairs:
            pair.until = -math.inf

    def step(self, goals: Sequence[float], speeds: Sequence[float], dt: float) -> list[slice]:
        """Return the legs that must brake now, by where their joints are, lest they meet something.

        Args:
            goals: of all joints, rad.
            speeds: at which they come there, rad/s.
            dt: s since the last step.
        """
        rates = [lever * abs(speed) for lever, speed in zip(self._levers, speeds, strict=True)]
        gone, ahead = self._gone, self._ahead
        for place, limb in enumerate(self.limbs):
            rate = sum(rates[limb.span])
            gone[place] += rate * dt
            ahead[place] = gone[place] + rate * self._longest
        braking: dict[_Limb, None] = {}
        stopped: list[float] = []  # where all joints would be
        for pair, (one, other) in zip(self.pairs, self._who, strict=True):
            if pair.until >= ahead[one] + ahead[other]:
                continue
            so_far = gone[one] + gone[other]
            pair.until = so_far + pair.gap(goals) - MARGIN
            if pair.until >= ahead[one] + ahead[other]:
                continue
            stopped = stopped or [
                goal + speed * abs(speed) * brake
                for goal, speed, brake in zip(goals, speeds, self._brakes, strict=True)]
            if pair.gap(stopped) >= MARGIN:
                continue
            now, then = pair.apart(goals), pair.apart(stopped)
            pair.until = so_far + now - MARGIN
            if then < MARGIN and then < now - _CLOSING:
                braking.update({limb: None for limb in (pair.first, pair.second) if limb is not None})
        return [limb.span for limb in braking]


def _pairs(limbs: Sequence[_Limb], half: Vec3) -> list[Pair]:
    """Return all that can meet at all, link by link."""
    reach = [limb.reach() for limb in limbs]
    body = (Vec3(-half.x, -half.y, -half.z), half)
    pairs = []
    for first, limb in enumerate(limbs):
        links = [
            (link, 0) for link, box in enumerate(reach[first])
            if link >= _MOUNTED and _overlap(box, body) and limb.to_body(limb.rest, link, half) > _BESIDE]
        if links:
            pairs.append(Pair(limb, None, links, half))
        for second in range(first + 1, len(limbs)):
            other = limbs[second]
            links = [
                (a, b) for a, box in enumerate(reach[first]) for b, its in enumerate(reach[second])
                if _overlap(box, its) and between(limb, limb.rest, a, other, other.rest, b) > _BESIDE]
            if links:
                pairs.append(Pair(limb, other, links, half))
    return pairs


def between(one: _Limb, here: Sequence[Vec3], a: int, other: _Limb, there: Sequence[Vec3], b: int) -> float:
    """Return how far a link of one leg is from one of another, m, for where their ends are."""
    apart = between_segments(here[a], here[a + 1], there[b], there[b + 1])
    return apart - one.radii[a] - other.radii[b]


def _overlap(one: _Box, other: _Box) -> bool:
    (low, high), (lower, higher) = one, other
    return all(a <= d and c <= b for a, b, c, d in zip(low, high, lower, higher, strict=True))


def _middle(points: Sequence[Vec3]) -> Vec3:
    return Vec3(*(sum(point[axis] for point in points) / len(points) for axis in range(3)))
