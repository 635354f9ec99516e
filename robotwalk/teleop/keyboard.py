"""The keyboard of a terminal, over SSH too."""

import signal
from collections.abc import Iterable, Sequence

from robotwalk.teleop.ask import Ask, Wish
from robotwalk.teleop.hands import Hands, Held, Latched
from robotwalk.teleop.keystrokes import Event, Sign, Stroke
from robotwalk.teleop.layout import CENTRED, Act, LayoutName, Stick, action, help_of
from robotwalk.teleop.terminal import Terminal
from robotwalk.teleop.tiller import Tiller
from robotwalk.teleop.told import Told

_ASKED_EVERY = 0.15  # s; a terminal that tells releases is asked so often whether it is still there
_WISHES = {Act.STAND: Wish.STAND, Act.SIT: Wish.SIT, Act.STOP: Wish.STOP, Act.QUIT: Wish.QUIT}


class Keyboard:
    """Drives by keys. The end of its input, as when SSH drops, counts as a hang-up; a Ctrl-C as the signal."""

    name = "keyboard"

    def __init__(self, tiller: Tiller, layout: LayoutName, fd: int = 0) -> None:
        """Take over the terminal.

        Raises:
            UsageError: there is none.
        """
        self._terminal = Terminal(fd)
        self._tiller = tiller
        self._layout = layout
        self._hands: Hands = Latched()
        self._moving = False
        self._polled_at = self._asked_at = 0.0

    @property
    def status(self) -> str:
        """Which keys it takes, and how."""
        return f"keyboard ({self._layout}, {self._hands.name})"

    @property
    def help(self) -> Sequence[str]:
        """What its keys do."""
        return help_of(self._layout)

    def poll(self, now: float, told: Told) -> Iterable[Ask]:
        """Return what the keys ask for."""
        asks: list[Ask] = []
        changed = False
        for said in self._terminal.read(now):
            if isinstance(said, Stroke):
                self._hands.heard(now)
                changed = self._take(said, asks) or changed
            else:
                self._hear(said, now)
        if self._terminal.gone:
            signal.raise_signal(signal.SIGHUP)
            return [Ask(self.name, wish=Wish.QUIT)]
        if isinstance(self._hands, Held) and now - self._asked_at > _ASKED_EVERY:
            self._asked_at = now
            self._terminal.ask_whether_there()
        stick = self._hands.stick(now)
        moving = stick != CENTRED
        if moving or self._moving or changed:
            asks.append(Ask(self.name, self._tiller.command(stick, told.pose.yaw, now - self._polled_at)))
        self._moving, self._polled_at = moving, now
        return asks

    def answer(self, ask: Ask, refusal: str) -> None:
        """Let go of the keys: what is refused must not begin by itself once it no longer is."""
        self._hands.drop()

    def close(self) -> None:
        """Leave the terminal as it was."""
        self._terminal.close()

    def _hear(self, sign: Sign, now: float) -> None:
        """Take note of what the terminal itself says."""
        if sign is Sign.HAS_KITTY and isinstance(self._hands, Latched):
            self._hands = Held()
        if sign is Sign.FOCUS_LOST:
            self._hands.drop()
        if isinstance(self._hands, Held):
            self._hands.heard(now)

    def _take(self, stroke: Stroke, asks: list[Ask]) -> bool:
        """Do what a key stands for, or ask for it; return whether that makes another command."""
        if stroke.ctrl and stroke.key == "c":
            if stroke.event is Event.PRESSED:
                signal.raise_signal(signal.SIGINT)
            return False
        does = action(stroke, self._layout)
        if isinstance(does, Stick):
            self._hands.press(stroke.key, does, stroke.event)
            return False
        if stroke.event is Event.RELEASED:
            # A direction's key that is let go with another shift than it was pressed with.
            self._hands.press(stroke.key, CENTRED, stroke.event)
            return False
        if does is Act.HALT or does in _WISHES:
            self._hands.drop()
        if isinstance(does, Act) and does in _WISHES and stroke.event is Event.PRESSED:
            asks.append(Ask(self.name, wish=_WISHES[does]))
        return does is Act.HALT or (does is not None and self._tiller.adjust(does))
