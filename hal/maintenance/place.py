"""Where a servo is to be found: by which id, at which baud rate."""

from typing import NamedTuple

from hal.maintenance.dialogue import Dialogue

_ATTEMPTS = 3  # before an id counts as free: one answer may get lost


class Place(NamedTuple):
    """A servo's address."""

    baud: int
    id: int

    def __str__(self) -> str:
        return f"id {self.id} at {self.baud} baud"


def is_vacant(dialogue: Dialogue, place: Place) -> bool:
    """Tell whether nobody answers there. The line is left at the baud rate that it had.

    Raises:
        BusError: the adapter does not have that baud rate.
    """
    port = dialogue.port
    before = port.baud
    try:
        port.baud = place.baud
        return all(dialogue.ping(place.id).silent for _ in range(_ATTEMPTS))
    finally:
        port.baud = before


def settle_at(dialogue: Dialogue, *places: Place) -> Place | None:
    """Return the first of these where one servo answers, and tune the line to it; None if there is none."""
    before = dialogue.port.baud
    for place in places:
        dialogue.port.baud = place.baud
        if any(dialogue.ping(place.id).alone(place.id) for _ in range(_ATTEMPTS)):
            return place
    dialogue.port.baud = before
    return None
