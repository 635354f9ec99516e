"""A servo turned a few degrees there and back: whether it moves, and which way."""

from collections.abc import Callable
from typing import NamedTuple

from hal.maintenance.gentle import folded, gently
from hal.maintenance.servo import Servo
from robotwalk.errors import ServoError
from robotwalk.ports import Clock

_MOVED = 0.5  # of the way asked for
_ROOM = 0.34  # of the way asked for, which a side must have to be tried
_LIMITS = (("min_position_limit", "max_position_limit"), ("cw_angle_limit", "ccw_angle_limit"))


class Turn(NamedTuple):
    """One way from where the shaft was."""

    asked: int  # counts
    moved: int

    @property
    def done(self) -> bool:
        """Whether it got there, more or less."""
        return self.moved / self.asked >= _MOVED


class Wiggled(NamedTuple):
    """What came of it."""

    start: int  # counts
    turns: tuple[Turn, ...]
    rest: int  # counts from the start, in the end


def wiggle(
    servo: Servo, clock: Clock, first: int, bounds: tuple[float, float], share: float, check: Callable[[], None]
) -> Wiggled:
    """Turn a servo by `first` counts, then by as much the other way, and back, with a `share` of its torque.

    A way that would leave the bounds is shortened, or left out if there is hardly any.

    Raises:
        BusError: it does not answer.
        ServoError: it is out of its bounds, in no state to be moved, or there is no room.
    """
    low, high = _within_limits(servo, bounds)
    start = folded(servo, servo.read(servo.model.cyclic.position))
    if not low <= start <= high:
        raise ServoError(f"{servo} is at {start} counts, outside its limits of {low} to {high}: turn it by hand")
    ways = [min(max(start + way, low), high) - start for way in (first, -first)]
    ways = [way for way in ways if abs(way) >= _ROOM * abs(first)]
    if not ways:
        raise ServoError(f"{servo} has no room to move: its limits are {low} to {high} counts, and it is at {start}")
    with gently(servo, clock, share, check) as gentle:
        turns = [Turn(way, gentle.creep(start + way) - start) for way in ways]
        rest = gentle.creep(start) - start
    return Wiggled(start, tuple(turns), rest)


def _within_limits(servo: Servo, bounds: tuple[float, float]) -> tuple[int, int]:
    """Narrow bounds to the limits that the servo keeps itself."""
    low, high = round(bounds[0]), round(bounds[1])
    for names in _LIMITS:
        if all(name in servo.model.by_name for name in names):
            least, most = (servo.read(name) for name in names)
            if least < most:  # else it has none
                low, high = max(low, least), min(high, most)
    return low, high
