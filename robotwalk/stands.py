"""Which feet will stand together in the coming turn of the needle, and where."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from robotwalk.gait import Gait, GaitClock, Support
from robotwalk.model import Leg
from robotwalk.stepping import Footfalls, footprint
from robotwalk.types import Pose, Twist, Vec3


class Stand(NamedTuple):
    """Feet that stand together for a while."""

    begin: float  # s from now
    end: float
    feet: list[Vec3]  # in odom, on the ground


def coming_stands(
    legs: Sequence[Leg], clock: GaitClock, footfalls: Footfalls, course: Pose, twist: Twist
) -> Iterator[Stand]:
    """Yield, in order, the stands of the present and of the coming turn in which some foot is in the air."""
    gait, period, planted = clock.gait, clock.period, footfalls.planted
    places = list(footfalls.footprints)
    first = gait.support_at(clock.phase)
    if planted != gait.supports[first].standing:
        yield from _stand(0.0, 0.0, places, planted)
    end = 0.0
    for index in range(first, first + len(gait.supports)):
        support = gait.supports[index % len(gait.supports)]
        begin, end = end, end + period * (support.left(clock.phase) if index == first else support.length)
        yield from _stand(begin, end, places, support.standing)
        for foot, leg in enumerate(legs):
            # What is in the air now has its footprint; the others' will be below the body then.
            if not support.standing[foot] and (planted[foot] or index != first):
                stance = _stance_after(gait, foot, support) * period
                places[foot] = footprint(leg, course, twist, end + 0.5 * stance)


def _stand(
    begin: float, end: float, places: Sequence[tuple[float, float]], standing: Sequence[bool]
) -> Iterator[Stand]:
    """Yield nothing if all feet stand."""
    if not all(standing):
        yield Stand(begin, end, [Vec3(*place, 0.0) for place, stands in zip(places, standing, strict=True) if stands])


def _stance_after(gait: Gait, foot: int, support: Support) -> float:
    sector = gait.sector_at(foot, (support.start + 0.5 * support.length) % 1.0)
    return sector.stance if sector is not None else 0.0
