"""What a terminal sends when keys are pressed: bytes in, keystrokes out. Pure.

Two ways to tell. In the old one a key is a character, or an escape sequence, sent when it is pressed and while it
repeats; nobody tells when it is let go. In the kitty keyboard protocol it is `CSI code ; modifiers : event u`, and
events are 1 pressed, 2 repeated, 3 released.

Sources: kitty's documentation, "Comprehensive keyboard handling in terminals"; ECMA-48 section 5.4; xterm's
"Control Sequences" for DA1, arrows and focus.
"""

import re
from enum import Enum
from typing import NamedTuple


class Event(Enum):
    """What became of a key."""

    PRESSED = 1
    REPEATED = 2
    RELEASED = 3


class Stroke(NamedTuple):
    """A key, by what is on it without shift: "i", "," or a name such as "space" or "up"."""

    key: str
    shift: bool = False
    ctrl: bool = False
    event: Event = Event.PRESSED


class Sign(Enum):
    """What a terminal says besides."""

    HAS_KITTY = "has the kitty keyboard protocol"
    ATTRIBUTES = "answers, as every terminal does, to DA1"
    FOCUS_LOST = "its window has the keyboard no more"
    OTHER = "something else"


_CSI = re.compile(rb"\x1b\[([<-?]?)([0-9:;]{0,63})[ -/]?([@-~])")
_PART_OF_CSI = re.compile(rb"\x1b\[[0-?]{0,64}[ -/]?")
_SS3 = re.compile(rb"\x1bO([A-Z])")
_NAMES = {9: "tab", 13: "enter", 27: "esc", 32: "space", 127: "backspace"}
_ARROWS = {b"A": "up", b"B": "down", b"C": "right", b"D": "left"}
_SHIFTED = {"<": ",", ">": ".", "+": "="}  # on the keys of a US keyboard


class Decoder:
    """Splits what a terminal sends. A sequence may come in pieces."""

    def __init__(self) -> None:
        self._rest = b""

    @property
    def pending(self) -> bool:
        """Whether an escape sequence has begun, or the escape key was pressed: what follows will tell."""
        return bool(self._rest)

    def feed(self, data: bytes) -> list[Stroke | Sign]:
        """Take the next bytes; return all that is complete."""
        self._rest += data
        said: list[Stroke | Sign] = []
        while self._rest and not self._must_wait():
            said.append(self._next())
        return said

    def flush(self) -> list[Stroke | Sign]:
        """Nothing followed for a while, so what was pending is as it stands: a lone escape is the key."""
        rest, self._rest = self._rest, b""
        return [Stroke("esc")] if rest == b"\x1b" else []

    def _must_wait(self) -> bool:
        rest = self._rest
        return rest in (b"\x1b", b"\x1bO") or _PART_OF_CSI.fullmatch(rest) is not None

    def _next(self) -> Stroke | Sign:
        rest = self._rest
        if match := _CSI.match(rest):
            self._rest = rest[match.end():]
            return _sequence(*match.groups())
        if match := _SS3.match(rest):
            self._rest = rest[match.end():]
            return Stroke(_ARROWS[match[1]]) if match[1] in _ARROWS else Sign.OTHER
        self._rest = rest[1:]
        return _character(rest[0])


def _character(code: int) -> Stroke | Sign:
    """Read one byte of the old way."""
    if code in _NAMES or code == 10:
        return Stroke(_NAMES.get(code, "enter"))
    if code < 27:
        return Stroke(chr(code + 96), ctrl=True)
    if code > 126 or code < 32:
        return Sign.OTHER
    char = chr(code)
    if char in _SHIFTED:
        return Stroke(_SHIFTED[char], shift=True)
    return Stroke(char.lower(), shift=char.isupper())


def _sequence(private: bytes, parameters: bytes, final: bytes) -> Stroke | Sign:
    """Read a control sequence."""
    if private == b"?":
        return {b"u": Sign.HAS_KITTY, b"c": Sign.ATTRIBUTES}.get(final, Sign.OTHER)
    if private or final not in (b"u", *_ARROWS):
        return Sign.FOCUS_LOST if (private, parameters, final) == (b"", b"", b"O") else Sign.OTHER
    fields = [[int(number[:9] or 0) for number in field.split(b":")] for field in parameters.split(b";")]
    modifiers = fields[1] if len(fields) > 1 else [1]
    bits = max(modifiers[0], 1) - 1
    number = modifiers[1] if len(modifiers) > 1 else 1
    if not 1 <= number <= 3:
        return Sign.OTHER
    code = fields[0][0]
    if final in _ARROWS:
        key = _ARROWS[final]
    elif code in _NAMES:
        key = _NAMES[code]
    elif 32 < code < 127:
        key = chr(code).lower()
    else:
        return Sign.OTHER  # a modifier by itself, or a key that we have no use for
    return Stroke(key, bool(bits & 1), bool(bits & 4), Event(number))
