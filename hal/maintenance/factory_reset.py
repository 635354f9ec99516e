"""A servo back to what the factory has set, and where it is then to be found."""

import itertools
from collections.abc import Sequence
from typing import NamedTuple

from hal.maintenance.place import Place, is_vacant
from hal.maintenance.servo import Servo
from hal.maintenance.vendor_sdk import Keep, Outcome, VendorSdk
from hal.register_map import Memory
from robotwalk.errors import BusError, ServoError, UsageError

_NS = 1_000_000_000
_STARTING = 4 * _NS  # for the servo to come back; its light blinks meanwhile
_PAUSE = _NS // 2  # before it is asked: at first the old servo may still answer


class Reset(NamedTuple):
    """Where a servo is after its reset, and how many registers of its EEPROM are others than before."""

    id: int
    baud: int
    changed: int


def factory_reset(servo: Servo, sdk: VendorSdk, keep: Keep) -> Reset:
    """Reset a servo and wait until it answers again.

    Raises:
        UsageError: the servo cannot be told to keep that.
        BusError: it does not answer, before or after.
        ServoError: it refuses, or another servo is where it would go.
    """
    if keep not in sdk.outcomes:
        raise UsageError(
            f"a {servo.model.name} cannot be told to keep its {keep.value.replace('-', ' ')}: back it up, reset it, "
            "and restore it")
    rows = [register for register in servo.model.registers if register.memory is Memory.EEPROM]
    before = servo.read_all(rows)
    places = _places(servo, sdk.outcomes[keep])
    _require_vacant(servo, places)
    sdk.factory_reset(servo.id, keep)
    _await(servo, places)
    after = servo.read_all(rows)
    return Reset(servo.id, servo.dialogue.port.baud, sum(before[name] != after[name] for name in before))


def _places(servo: Servo, outcome: Outcome) -> Sequence[Place]:
    """Return where it may be afterwards."""
    model = servo.model
    ids = _possible(outcome.id, servo.id, model["id"].default or 0)
    bauds = _possible(outcome.baud, servo.dialogue.port.baud, model.baud_by_value[model["baud_rate"].default or 0])
    return list(itertools.starmap(Place, itertools.product(bauds, ids)))


def _possible(kept: bool | None, now: int, factory: int) -> Sequence[int]:
    if kept is None:
        return list(dict.fromkeys((now, factory)))
    return [now if kept else factory]


def _require_vacant(servo: Servo, places: Sequence[Place]) -> None:
    """Refuse if another servo is where this one may go."""
    for place in places:
        if place != servo.place and not is_vacant(servo.dialogue, place):
            raise ServoError(f"after the reset {servo} would be {place}, where another servo is: disconnect that")


def _await(servo: Servo, places: Sequence[Place]) -> None:
    """Wait until the servo answers, wherever."""
    dialogue = servo.dialogue
    deadline = dialogue.clock.now() + _STARTING
    dialogue.clock.wait((), dialogue.clock.now() + _PAUSE)
    while dialogue.clock.now() < deadline:
        for dialogue.port.baud, servo_id in places:
            if dialogue.ping(servo_id).of(servo_id):
                servo.id = servo_id
                return
    raise BusError(f"{servo} was told to reset and does not answer again as {' or as '.join(map(str, places))}")
