"""Which way the keys point: held down, where the terminal tells when a key is let go, else latched for a while."""

import math

from robotwalk.teleop.helm import SILENCE
from robotwalk.teleop.keystrokes import Event
from robotwalk.teleop.layout import CENTRED, Stick

_LATCHED = 0.7  # s that a direction lasts without a byte; a key that is held repeats after 0.66 s at the latest
_RAMP = 0.3  # s that it then takes to centre


class Latched:
    """The last direction lasts until 0.7 s without a byte have passed, then fades: a key that is held repeats."""

    name = "latched keys"

    def __init__(self) -> None:
        self._stick = CENTRED
        self._heard_at = -math.inf

    def heard(self, now: float) -> None:
        """Note that the terminal said something."""
        self._heard_at = now

    def press(self, key: str, stick: Stick, event: Event) -> None:
        """Take what a direction's key does."""
        self._stick = stick

    def drop(self) -> None:
        """Let go of everything."""
        self._stick = CENTRED

    def stick(self, now: float) -> Stick:
        """Return where the keys point at `now` (s)."""
        share = min(1.0, 1.0 - (now - self._heard_at - _LATCHED) / _RAMP)
        if share <= 0.0:
            self._stick = CENTRED
            return CENTRED
        return Stick(*(share * axis for axis in self._stick))


class Held:
    """Directions last while their keys are held down, and add up; all are let go if the terminal falls silent."""

    name = "keys held"

    def __init__(self) -> None:
        self._held: dict[str, Stick] = {}
        self._heard_at = -math.inf

    def heard(self, now: float) -> None:
        """Note that the terminal said something."""
        self._heard_at = now

    def press(self, key: str, stick: Stick, event: Event) -> None:
        """Take what a direction's key does."""
        if event is Event.RELEASED:
            self._held.pop(key, None)
        elif event is Event.PRESSED or key in self._held:  # what repeats after a halt is to be pressed anew
            self._held[key] = stick

    def drop(self) -> None:
        """Let go of everything."""
        self._held.clear()

    def stick(self, now: float) -> Stick:
        """Return where the keys point at `now` (s)."""
        if now - self._heard_at > SILENCE:
            self.drop()
        x, y, w = (max(-1, min(1, sum(axis))) for axis in zip(CENTRED, *self._held.values(), strict=True))
        return Stick(x, y, w)


Hands = Latched | Held
