"""A gamepad, by SDL's data base of where each kind has its sticks and buttons."""

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from robotwalk.errors import UsageError
from robotwalk.teleop.ask import Ask, Wish
from robotwalk.teleop.layout import Act, Lean, Stick
from robotwalk.teleop.tiller import Tiller
from robotwalk.teleop.told import Told

if TYPE_CHECKING:
    from pygame._sdl2.controller import Controller

_DEAD_ZONE = 0.1  # of the way, within which a stick counts as centred
_FULL = 32767
_WISHES = {"start": Wish.STAND, "back": Wish.SIT, "b": Wish.STOP, "a": Wish.CLEAR}
_SETTINGS: Mapping[str, Act | Lean] = {
    "x": Act.LAST_GAIT, "y": Act.NEXT_GAIT, "leftstick": Act.HEADING, "rightstick": Act.LEVEL,
    "dpup": Lean(height=1), "dpdown": Lean(height=-1),
}

_HELP = (
    "hold a shoulder button to drive   left stick go, right turn   B STOP",
    "Start stand   Back sit   A clear   X/Y gait   D-pad height",
)


class Gamepad:
    """Drives while a shoulder button is held. Unplugged, it stops; plugged in again, it goes on."""

    name = "gamepad"

    def __init__(self, tiller: Tiller) -> None:
        """Look for gamepads.

        Raises:
            UsageError: pygame-ce is not installed.
        """
        # It needs no window; and signals are ours.
        for key, value in (
            ("SDL_VIDEODRIVER", "dummy"), ("SDL_NO_SIGNAL_HANDLERS", "1"), ("PYGAME_HIDE_SUPPORT_PROMPT", "1"),
            ("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1"),
        ):
            os.environ.setdefault(key, value)
        try:
            import pygame
            from pygame._sdl2 import controller
        except ImportError as error:
            raise UsageError("a gamepad needs the extra: pip install 'robotwalk[gamepad]'") from error
        pygame.display.init()
        controller.init()
        self._pygame = pygame
        self._controllers = controller
        self._tiller = tiller
        self._buttons = {
            name: getattr(pygame, f"CONTROLLER_BUTTON_{name.upper().replace('DP', 'DPAD_')}")
            for name in (*_WISHES, *_SETTINGS, "leftshoulder", "rightshoulder")}
        self._pad: Controller | None = None
        self._down: set[str] = set()
        self._driving = False
        self._polled_at = 0.0

    @property
    def status(self) -> str:
        """Which one, and whether its deadman button is held."""
        if self._pad is None:
            return "gamepad (none plugged in)"
        return f"gamepad ({self._pad.name}{', driving' if self._driving else ''})"

    @property
    def help(self) -> Sequence[str]:
        """What its buttons do."""
        return _HELP

    def poll(self, now: float, told: Told) -> Iterable[Ask]:
        """Return what sticks and buttons ask for."""
        self._pygame.event.pump()
        self._pygame.event.clear()
        since, self._polled_at = now - self._polled_at, now
        if self._pad is None or not self._pad.attached():
            self._find()
        pad = self._pad
        down = {name for name, button in self._buttons.items() if pad is not None and pad.get_button(button)}
        pressed, self._down = down - self._down, down
        asks = [Ask(self.name, wish=_WISHES[name]) for name in pressed if name in _WISHES]
        held = bool(down & {"leftshoulder", "rightshoulder"})
        if held and pad is not None:
            for name in pressed & _SETTINGS.keys():
                self._tiller.adjust(_SETTINGS[name])
            asks.append(Ask(self.name, self._tiller.command(self._stick(pad), told.pose.yaw, since)))
        elif self._driving:
            asks.append(Ask(self.name, wish=Wish.LEAVE))
        self._driving = held
        return asks

    def answer(self, ask: Ask, refusal: str) -> None:
        """A gamepad has no words."""

    def close(self) -> None:
        """Let the gamepad go."""
        self._pad = None
        self._pygame.quit()

    def _find(self) -> None:
        """Take the first gamepad that is plugged in, if any."""
        count = self._controllers.get_count()
        usable = next((index for index in range(count) if self._controllers.is_controller(index)), None)
        self._pad = self._controllers.Controller(usable) if usable is not None else None

    def _stick(self, pad: "Controller") -> Stick:
        pygame = self._pygame
        axes = (pygame.CONTROLLER_AXIS_LEFTY, pygame.CONTROLLER_AXIS_LEFTX, pygame.CONTROLLER_AXIS_RIGHTX)
        return Stick(*(-_beyond_dead_zone(pad.get_axis(axis) / _FULL) for axis in axes))


def _beyond_dead_zone(value: float) -> float:
    """Return how far a stick is past its dead zone, -1 to 1."""
    size = min(max(abs(value) - _DEAD_ZONE, 0.0) / (1.0 - _DEAD_ZONE), 1.0)
    return size if value > 0.0 else -size
