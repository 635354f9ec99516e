"""What judges a driven robot: its ground truth; and a terminal that a program takes for kitty."""

import contextlib
import json
import math
import os
import pty
import select
import termios
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

UNHURRIED = 60.0  # s that a shared machine may take for anything
STOPPED_WITHIN = 8.0  # s; by docs/teleop.md it takes 1.2 at the most, but this machine may stall
_SAME = 0.004  # m that a body may sway


def await_that(condition: Callable[[], object], what: str, seconds: float = UNHURRIED) -> None:
    """Wait until something is so."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"not so within {seconds} s: {what}"
        time.sleep(0.05)


class Truth:
    """What really happens to a simulated robot, as `--truth` tells."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._read = 0
        self._lines: list[dict[str, Any]] = []

    def lines(self) -> list[dict[str, Any]]:
        """Return all whole lines so far."""
        if self.path.exists():
            with self.path.open("rb") as file:
                file.seek(self._read)
                whole, newline, _ = file.read().rpartition(b"\n")
            self._read += len(whole + newline)
            self._lines += map(json.loads, whole.splitlines())
        return self._lines

    def place(self) -> tuple[float, float, float]:
        """Return where the body is now, m."""
        lines = self.lines()
        return tuple(lines[-1]["base"]["pos"]) if lines else (0.0, 0.0, 0.0)

    def await_standing(self) -> None:
        await_that(lambda: self.place()[2] > 0.09, "it stands")

    def await_going(self, metres: float = 0.03) -> None:
        x, y, _ = self.place()
        await_that(lambda: math.dist(self.place()[:2], (x, y)) > metres, "it goes")

    def assert_going(self) -> None:
        """Assert that it is on its way, not just coming to rest."""
        time.sleep(1.5)
        self.await_going(0.02)

    def assert_stops(self, since: float) -> None:
        """Assert that it comes to rest, for a second, within the stated time after `since` (s, monotonic)."""

        def moved_last() -> float:
            end = self.lines()[-1]["base"]["pos"][:2]
            return next(
                (line["t"] for line in reversed(self._lines) if math.dist(line["base"]["pos"][:2], end) > _SAME), 0.0)

        await_that(lambda: self.lines()[-1]["t"] > max(moved_last(), since) + 1.0, "it stands still")
        assert moved_last() < since + STOPPED_WITHIN

    def assert_sits(self) -> None:
        """Assert that it came down, upright and in no hurry, and did not fall on the way."""
        last = self.lines()[-1]
        assert last["base"]["pos"][2] < 0.04
        assert last["base"]["quat_wxyz"][0] > 0.9
        assert not last["fell"]


class Kitty:
    """A terminal with the kitty keyboard protocol, as a program at its other end sees it."""

    def __init__(self, columns: int = 80, lines: int = 24) -> None:
        self.master, self.slave = pty.openpty()
        termios.tcsetwinsize(self.slave, (lines, columns))
        self.answers = True
        self.seen = b""
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def key(self, code: int, event: int = 1, modifiers: int = 1) -> None:
        """Press (1), repeat (2) or release (3) a key."""
        os.write(self.master, b"\x1b[%d;%d:%du" % (code, modifiers, event))

    def hang_up(self) -> None:
        """Be closed."""
        self.answers = False
        with contextlib.suppress(OSError):
            os.close(self.slave)
        os.close(self.master)

    def _serve(self) -> None:
        """Answer what is asked: the mode in force, then what it is."""
        done = 0
        with contextlib.suppress(OSError, ValueError):
            while True:
                if not select.select([self.master], [], [], 0.2)[0]:
                    continue
                self.seen += os.read(self.master, 65536)
                while self.answers:
                    asked = [(self.seen.find(q, done), q) for q in (b"\x1b[?u", b"\x1b[c") if q in self.seen[done:]]
                    if not asked:
                        break
                    at, question = min(asked)
                    done = at + len(question)
                    os.write(self.master, b"\x1b[?11u" if question == b"\x1b[?u" else b"\x1b[?62;c")
