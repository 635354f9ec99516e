"""Who drives in `robotwalk teleop`, as people type it."""

import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Literal

from cyclopts import Parameter

from robotwalk import assembly
from robotwalk.cli.options import Names
from robotwalk.teleop.ask import Device
from robotwalk.teleop.layout import LayoutName
from robotwalk.teleop.tiller import Tiller

Input = Literal["keyboard", "gamepad", "socket"]

_LISTEN = "127.0.0.1:8765"
_TOKEN = "ROBOTWALK_TOKEN"  # of the environment: what is on a command line everybody can read


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Drivers:
    """The devices that a robot is driven by.

    Attributes:
        input: What drives: keyboard, gamepad or socket; may be given several times. Default: the keyboard, if there is
            one.
        keys: Of the keyboard: ros (u i o, j k l, m , . as teleop_twist_keyboard) or wasd. The screen shows them.
        listen: HOST:PORT of the socket, by default 127.0.0.1:8765; implies --input socket. Beyond this computer clients
            need the token that is in the environment's ROBOTWALK_TOKEN.
        origin: Of web pages whose scripts may connect, such as http://localhost:8000. Programs need none.
    """

    input: Annotated[list[Input] | None, Parameter(negative="")] = None
    keys: LayoutName = "ros"
    listen: str | None = None
    origin: Names = None

    def opened(self, blueprint: assembly.Blueprint, tiller: Tiller) -> Iterator[Device]:
        """Open them for a robot, one after the other. A module is loaded only now: not everybody has a gamepad.

        Raises:
            UsageError: one cannot be had.
        """
        for name in self._inputs():
            yield self._open(name, blueprint, tiller)

    def _inputs(self) -> list[Input]:
        """Return what drives: by default the keyboard, or a socket alone if one is asked for and there are no keys."""
        inputs: list[Input] = list(dict.fromkeys(self.input or []))
        if not inputs and (self.listen is None or sys.stdin.isatty()):
            inputs.append("keyboard")
        if self.listen is not None and "socket" not in inputs:
            inputs.append("socket")
        return inputs

    def _open(self, name: Input, blueprint: assembly.Blueprint, tiller: Tiller) -> Device:
        if name == "keyboard":
            from robotwalk.teleop.keyboard import Keyboard

            return Keyboard(tiller, self.keys)
        if name == "gamepad":
            from robotwalk.teleop.gamepad import Gamepad

            return Gamepad(tiller)
        from robotwalk.teleop.websocket import Address, WebSocketDoor

        return WebSocketDoor(
            Address.parse(self.listen or _LISTEN), blueprint.model.name, tuple(blueprint.gaits),
            token=os.environ.get(_TOKEN), origins=self.origin or [])
