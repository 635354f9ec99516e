"""A joint's zero, direction and range, found with a hand on the leg; torque is off but for the proof at the end.

A servo is read again and again while the joint is moved by hand, and each step is taken the short way round: so a
shaft that passes from its last count to its first is followed, not thrown a whole turn aside. A joint whose range
lies across that seam cannot be driven, since a position servo never crosses it; that is an error which says by how
much the horn must be turned.
"""

import math
from collections.abc import Callable
from typing import Literal, NamedTuple

from hal.maintenance.gentle import folded, gently
from hal.maintenance.servo import Servo
from robotwalk.errors import ServoError
from robotwalk.ports import Clock

_NS = 1_000_000_000
_PERIOD = _NS // 50  # between looks
_READINGS = 8  # of a joint that is held still
_STILL = math.radians(1.0)  # that they may differ
_CLEAR = math.radians(8.0)  # that a joint must be moved to show its direction
_MARGIN_COUNTS = 8  # from the seam
_PROVEN = math.radians(2.0)  # from its zero, when it has moved back by itself


class Found(NamedTuple):
    """How a servo sits in its joint."""

    direction: Literal[1, -1]
    zero_deg: float  # the joint's angle where the servo reads its centre
    range_deg: tuple[float, float] | None


class Hand:
    """A servo whose joint is turned by hand. Counts go on across the encoder's seam."""

    def __init__(self, servo: Servo, clock: Clock) -> None:
        """Begin to follow.

        Raises:
            ServoError: its torque is on.
            BusError: it does not answer.
        """
        servo.require_limp()
        self._servo, self._clock = servo, clock
        self._turn = round(math.tau / servo.model.encoder.radians_per_tick)
        self.counts = self.lowest = self.highest = self._read()

    def look(self) -> int:
        """Read the servo, and return its counts. Raises BusError if it does not answer: then nothing is known."""
        step = (self._read() - self.counts) % self._turn
        self.counts += step if 2 * step <= self._turn else step - self._turn
        self.lowest, self.highest = min(self.lowest, self.counts), max(self.highest, self.counts)
        return self.counts

    def follow(self, done: Callable[[], bool]) -> None:
        """Look again and again until somebody says that it is done."""
        while not done():
            self.look()
            self._pause()

    def still(self) -> int:
        """Return the counts of a joint that is held still.

        Raises:
            ServoError: it moves.
        """
        readings = []
        for _ in range(_READINGS):
            readings.append(self.look())
            self._pause()
        spread = (max(readings) - min(readings)) * self._servo.model.encoder.radians_per_tick
        if spread > _STILL:
            raise ServoError(f"the joint moved by {math.degrees(spread):.1f} deg while it was read: hold it still")
        return sorted(readings)[len(readings) // 2]

    def forget_range(self) -> None:
        """Begin anew to look for the lowest and the highest."""
        self.lowest = self.highest = self.counts

    def _read(self) -> int:
        return folded(self._servo, self._servo.read(self._servo.model.cyclic.position))

    def _pause(self) -> None:
        self._clock.wait((), self._clock.now() + _PERIOD)


def direction(servo: Servo, at: int, moved: int) -> Literal[1, -1]:
    """Return which way the servo's counts go when its joint was moved the positive way, from `at` counts to `moved`.

    Raises:
        ServoError: that was too little to tell.
    """
    angle = (moved - at) * servo.model.encoder.radians_per_tick
    if abs(angle) < _CLEAR:
        raise ServoError(
            f"the joint moved by {math.degrees(abs(angle)):.1f} deg only; {math.degrees(_CLEAR):.0f} would do")
    return 1 if angle > 0.0 else -1


def found(
    servo: Servo, at: int, at_deg: float, way: Literal[1, -1], reach: tuple[int, int] | None
) -> Found:
    """Return how the servo sits, whose joint is at `at_deg` where it reads `at`; `reach` are its ends, in counts.

    Raises:
        ServoError: the encoder's seam lies within the range, or hardly beside it.
    """
    encoder = servo.model.encoder
    degrees = math.degrees(encoder.radians_per_tick)
    turn = round(math.tau / encoder.radians_per_tick)
    within = at % turn
    zero = at_deg - way * (within - encoder.centre) * degrees
    if reach is None:
        return Found(way, round(zero, 3), None)
    low, high = (end - at + within for end in reach)
    if low < _MARGIN_COUNTS or high > encoder.ticks - 1 - _MARGIN_COUNTS:
        off = encoder.centre - (low + high) // 2
        raise ServoError(
            f"the range of {servo} goes from count {low} to {high}, across the seam of its encoder (0 to "
            f"{encoder.ticks - 1}), which it cannot cross. Take the horn off, turn the servo's shaft by "
            f"{off * degrees:+.0f} deg (plus: its counts grow), put the horn on again, and calibrate anew")
    ends = sorted(at_deg + way * (end - within) * degrees for end in (low, high))
    return Found(way, round(zero, 3), (round(ends[0], 2), round(ends[1], 2)))


def prove(servo: Servo, clock: Clock, at: int, share: float, check: Callable[[], None]) -> float:
    """Have the servo bring its joint back to `at` counts, slowly and weakly; return how far off it came to rest, rad.

    Torque is then off again.

    Raises:
        BusError: it does not answer.
        ServoError: it is in no state to be moved.
    """
    goal = at % round(math.tau / servo.model.encoder.radians_per_tick)
    with gently(servo, clock, share, check) as gentle:
        return (gentle.creep(goal) - goal) * servo.model.encoder.radians_per_tick


def is_proven(off: float) -> bool:
    """Tell whether a joint came back near enough."""
    return abs(off) <= _PROVEN
