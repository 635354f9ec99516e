"""Runs `robotwalk` with a gamepad that SDL only imagines: its sticks and buttons are moved by lines on stdin.

    python -m tests.teleop.virtual_pad teleop hexapod --input gamepad

Lines: `axis 1 -32767`, `button 10 1`, `unplug`. Axes and buttons are in the order of SDL's game controllers.
"""

import ctypes
import os
import sys
import threading
from pathlib import Path

_GAME_CONTROLLER = 1  # SDL_JOYSTICK_TYPE_GAMECONTROLLER


def main() -> None:
    os.environ.update(SDL_VIDEODRIVER="dummy", SDL_NO_SIGNAL_HANDLERS="1", PYGAME_HIDE_SUPPORT_PROMPT="1")
    import pygame
    from pygame._sdl2 import controller

    pygame.display.init()
    controller.init()
    (library,) = (Path(pygame.__file__).parents[1] / "pygame_ce.libs").glob("libSDL2-2*")
    sdl = ctypes.CDLL(str(library))
    index = sdl.SDL_JoystickAttachVirtual(_GAME_CONTROLLER, 6, 15, 0)
    sdl.SDL_JoystickOpen.restype = ctypes.c_void_p
    pad = ctypes.c_void_p(sdl.SDL_JoystickOpen(index))

    def obey() -> None:
        for line in sys.stdin:
            match line.split():
                case ["axis", axis, value]:
                    sdl.SDL_JoystickSetVirtualAxis(pad, int(axis), ctypes.c_int16(int(value)))
                case ["button", button, value]:
                    sdl.SDL_JoystickSetVirtualButton(pad, int(button), ctypes.c_uint8(int(value)))
                case ["unplug"]:
                    sdl.SDL_JoystickDetachVirtual(index)

    threading.Thread(target=obey, daemon=True).start()
    from robotwalk.cli.main import main as robotwalk

    robotwalk()


if __name__ == "__main__":
    main()
