"""What drivers ask for: nothing else reaches the robot. And what a device is."""

from collections.abc import Iterable, Sequence
from enum import Enum
from typing import NamedTuple, Protocol

from robotwalk.teleop.told import Told
from robotwalk.types import Command


class Wish(Enum):
    """What may be asked for besides motion."""

    STAND = "stand"
    SIT = "sit"
    STOP = "stop"  # hold in place, and stay so; anyone may ask for it
    CLEAR = "clear"  # end that: it sits down
    LEAVE = "leave"  # give the helm back
    QUIT = "quit"  # sit down and end


class Ask(NamedTuple):
    """One thing that one driver asks for."""

    driver: str
    command: Command | None = None
    wish: Wish | None = None


class Device(Protocol):
    """Where asks come from. No call blocks."""

    def poll(self, now: float, told: Told) -> Iterable[Ask]:
        """Return what was asked for since the last call.

        A driver that wants motion asks for it in every call or at least every `helm.SILENCE` s, and else not at all.

        Args:
            now: s, on the monotonic clock.
            told: what is known of the robot.
        """
        ...

    def answer(self, ask: Ask, refusal: str) -> None:
        """Tell the driver why what it asked for is not done."""
        ...

    @property
    def status(self) -> str:
        """What it is and how it does, in a few words."""
        ...

    @property
    def help(self) -> Sequence[str]:
        """How to drive with it, in lines of at most 76 columns."""
        ...

    def close(self) -> None:
        """Leave everything as it was found. May be called twice."""
        ...
