"""Signals that wait for the end of a tick, so that none cuts a cycle in half."""

import contextlib
import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any


class Interrupts:
    """Takes SIGINT, SIGTERM and SIGHUP while in force; `check` raises what came since."""

    _SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

    def __init__(self) -> None:
        self._came: list[int] = []
        self._sitting = False
        self._before: dict[int, Callable[[int, FrameType | None], Any] | int | None] = {}

    def install(self) -> None:
        """Take the signals. Only a main thread can; in any other this does nothing."""
        if threading.current_thread() is threading.main_thread():
            # A hang-up that `nohup` has told us to ignore stays ignored.
            wanted = [number for number in self._SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
            self._before = {number: signal.signal(number, self._note) for number in wanted}

    def restore(self) -> None:
        """Give the signals back."""
        for number, handler in self._before.items():
            with contextlib.suppress(ValueError, TypeError):
                signal.signal(number, handler)
        self._before = {}

    def heed_only_ctrl_c(self) -> None:
        """From now on only a new Ctrl-C counts: the robot sits down, and a hang-up that comes twice asks no more."""
        self._came = [number for number in self._came if number != signal.SIGINT]
        self._sitting = True

    def check(self, *, held: bool = False) -> None:
        """Raise what the oldest signal not yet raised stands for.

        Args:
            held: the robot is held in place, so it cannot sit down: all signals count.

        Raises:
            KeyboardInterrupt: for SIGINT.
            SystemExit: for the others, with the exit code that shells use, 128 + the signal's number.
        """
        while self._came:
            number = self._came.pop(0)
            if number == signal.SIGINT:
                raise KeyboardInterrupt
            if held or not self._sitting:
                raise SystemExit(128 + number)

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._came.append(number)
