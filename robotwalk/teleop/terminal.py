"""A terminal whose keys are read one by one, and that is left as it was found."""

import contextlib
import os
import select
import termios
import time
import tty

from robotwalk.errors import UsageError
from robotwalk.teleop.keystrokes import Decoder, Sign, Stroke

_ALONE = 0.1  # s after which an escape that nothing followed is the key
_LONGEST_DRAIN = 0.5  # s; the way to the terminal and back
_LFLAG = 3  # index in what tcgetattr returns

ASK_FOR_KITTY = b"\x1b[?u"
ASK_FOR_ATTRIBUTES = b"\x1b[c"  # DA1: whoever does not know the question before this, knows this one
_HEAR_RELEASES = b"\x1b[>11u\x1b[?1004h"  # 1 unambiguous, 2 events, 8 all keys so; and tell when the focus is lost
_AS_BEFORE = b"\x1b[<u\x1b[?1004l"


class Terminal:
    """Keys as they are pressed, and released where the terminal can tell."""

    def __init__(self, fd: int) -> None:
        """Take over the terminal at a descriptor.

        Raises:
            UsageError: it is none.
        """
        if not os.isatty(fd):
            raise UsageError("the keyboard's input is no terminal: run it in one, or choose another with --input")
        self._fd = fd
        self._decoder = Decoder()
        self._heard_at = 0.0
        self._answered = False
        self.tells_releases = False
        self.gone = False
        self._before = termios.tcgetattr(fd)
        self._attended = False
        tty.setcbreak(fd)
        self._say(ASK_FOR_KITTY + ASK_FOR_ATTRIBUTES)

    def read(self, now: float) -> list[Stroke | Sign]:
        """Return what came since the last call, at `now` (s)."""
        if not self._attended:
            self._attend()
        data = self._bytes()
        if data:
            self._heard_at = now
            said = self._decoder.feed(data)
        elif self._decoder.pending and now - self._heard_at > _ALONE:
            said = self._decoder.flush()
        else:
            return []
        self._answered = self._answered or Sign.ATTRIBUTES in said
        if Sign.HAS_KITTY in said and not self.tells_releases:
            self.tells_releases = True
            self._say(_HEAR_RELEASES)
        return said

    def _attend(self) -> None:
        """From now on a Ctrl-C comes as a key, in both protocols; before, nobody would have read it."""
        self._attended = True
        with contextlib.suppress(termios.error):
            attributes = termios.tcgetattr(self._fd)
            attributes[_LFLAG] &= ~termios.ISIG
            termios.tcsetattr(self._fd, termios.TCSANOW, attributes)

    def ask_whether_there(self) -> None:
        """Have it say something, if it tells releases."""
        self._say(ASK_FOR_KITTY)

    def close(self) -> None:
        """Leave it as it was found, and nothing behind that it still sends: a shell would take that for input."""
        if not self.gone:
            if self.tells_releases:
                self._say(_AS_BEFORE)
            if self.tells_releases or not self._answered:
                self._drain()
        with contextlib.suppress(termios.error, OSError):
            termios.tcsetattr(self._fd, termios.TCSAFLUSH, self._before)
        self.gone = True

    def _drain(self) -> None:
        """Read until it has answered a last question, which comes after all that it has sent before."""
        self._say(ASK_FOR_ATTRIBUTES)
        missing = 1 if self._answered else 2
        ends = time.monotonic() + _LONGEST_DRAIN
        while missing > 0 and not self.gone and (left := ends - time.monotonic()) > 0.0:
            with contextlib.suppress(OSError):
                select.select([self._fd], [], [], left)
            missing -= self._decoder.feed(self._bytes()).count(Sign.ATTRIBUTES)

    def _bytes(self) -> bytes:
        """Read what is there; at the end of the input, or without a terminal any more, it is gone."""
        if self.gone:
            return b""
        try:
            if not select.select([self._fd], [], [], 0.0)[0]:
                return b""
            data = os.read(self._fd, 4096)
        except OSError:
            data = b""
        self.gone = not data
        return data

    def _say(self, data: bytes) -> None:
        """Write, unless it takes nothing: a terminal that hangs must not hold the driver up."""
        with contextlib.suppress(OSError):
            if select.select([], [self._fd], [], 0.0)[1]:
                os.write(self._fd, data)
