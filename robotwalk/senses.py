"""What the feet feel, and where that is in odom: worked out for the feet, and in the ticks, in which somebody asks."""

import math
from collections.abc import Sequence

from robotwalk.body import Attitude, seen_from
from robotwalk.contact import Felt, Plane, plane_of
from robotwalk.types import Pose, Triple, Vec3

_PLANE = 3  # feet that make one


class BodyInOdom:
    """The body at one moment, as it is told to be: by it, what its joints and feet tell is placed in odom."""

    __slots__ = ("_attitude", "_feet", "_felt", "_give", "_planted", "_stood", "_told")

    def __init__(
        self, told: Pose, stood: Sequence[Vec3], planted: Sequence[bool], feet: Sequence[Vec3 | None],
        felt: Sequence[Felt | None],
    ) -> None:
        """Take one moment.

        Args:
            told: where the body is told to be.
            stood: where each foot was told to stand, or stood last, in odom, m.
            planted: which feet stand.
            feet: where their joints tell that they are, in the base frame, m; None where a joint did not answer.
            felt: by each foot.
        """
        self._told = told
        self._stood, self._planted = stood, planted
        self._feet, self._felt = feet, felt
        self._attitude: Attitude | None = None
        self._give: Plane | None = None

    def along_odom(self, vector: Triple) -> Vec3:
        """Return a vector of the base frame along odom's axes."""
        if self._attitude is None:
            self._attitude = Attitude(self._told)
        return self._attitude.in_odom(vector)

    def place(self, foot: Vec3) -> Vec3:
        """Return where a foot is in odom, m, that its joints tell to be at `foot` in the base frame."""
        if self._give is None:
            self._give = self._sag()
        x, y, z = self.along_odom((foot.x, foot.y, foot.z - self._give.at(foot)))
        return Vec3(self._told.x + x, self._told.y + y, self._told.z + z)

    def _sag(self) -> Plane:
        """Return how the body hangs lower than told on the feet that stand, as legs give, m."""
        planted = [
            (place, got, felt.touching) for place, stands, got, felt in zip(
                self._stood, self._planted, self._feet, self._felt, strict=True)
            if stands and felt is not None and got is not None]
        bearing = sum(touching for _, _, touching in planted)
        # Two feet make no plane; then one that bears next to nothing tells more than none.
        standing = [(place, got) for place, got, touching in planted if touching or bearing < _PLANE]
        told = seen_from(self._told, [place for place, _ in standing])
        return plane_of([Vec3(got.x, got.y, got.z - want.z) for want, (_, got) in zip(told, standing, strict=True)])


class Sense:
    """What one foot feels, and where.

    Attributes:
        touching: whether it bears a load worth a step.
        sure: whether it does, however fast its leg is.
    """

    __slots__ = ("_body", "_foot", "_force", "sure", "touching")

    def __init__(self, felt: Felt, foot: Vec3, body: BodyInOdom) -> None:
        """Place what was felt by a foot that is at `foot` in the base frame, m."""
        self.touching, self.sure = felt.touching, felt.sure
        self._force, self._foot, self._body = felt.force, foot, body

    @property
    def strength(self) -> float:
        """Of the push, N."""
        return math.hypot(*self._force)

    @property
    def place(self) -> Vec3:
        """Where its centre is in odom, m, as its joints tell."""
        return self._body.place(self._foot)

    @property
    def push(self) -> Vec3:
        """The force of the ground on it along odom's axes, N."""
        return self._body.along_odom(self._force)
