"""Joins devices, helm and screen: one turn of it is one look at what drivers want."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from robotwalk.errors import UsageError
from robotwalk.teleop.ask import Ask, Device, Wish
from robotwalk.teleop.helm import Helm
from robotwalk.teleop.told import Told
from robotwalk.types import Command

_REFUSAL_LASTS = 4.0  # s that it is worth telling


class Turn(NamedTuple):
    """What the robot is to do now."""

    command: Command
    wishes: tuple[Wish, ...] = ()
    driver: str | None = None  # who drives, if anybody does
    refusal: str | None = None  # what somebody was refused not long ago, and why


class Bridge:
    """Hears all devices."""

    def __init__(self, devices: Sequence[Device], check: Callable[[Command], None]) -> None:
        """Listen to devices; `check` raises UsageError if the robot cannot do a command."""
        self._devices = devices
        self._check = check
        self._helm = Helm()
        self._refused = (-math.inf, "")  # when and why

    def turn(self, now: float, told: Told) -> Turn:
        """Hear what drivers ask for at `now` (s, monotonic), and return what comes of it."""
        told = told._replace(driver=self._helm.driver(now))
        wishes: list[Wish] = []
        for device in self._devices:
            for ask in device.poll(now, told):
                refusal = self._hear(ask, now)
                if refusal is not None:
                    self._refused = now, f"{ask.driver}: {refusal}"
                    device.answer(ask, refusal)
                elif ask.wish not in (None, Wish.LEAVE):
                    wishes.append(ask.wish)
        refused_at, refusal = self._refused
        return Turn(
            self._helm.command(now), tuple(wishes), self._helm.driver(now),
            refusal if now - refused_at < _REFUSAL_LASTS else None)

    def _hear(self, ask: Ask, now: float) -> str | None:
        """Return why something is not done, if it is not."""
        if ask.command is not None:
            try:
                self._check(ask.command)
            except UsageError as error:
                return str(error)
        return self._helm.hear(ask, now)
