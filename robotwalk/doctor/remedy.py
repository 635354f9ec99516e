"""How something is mended: the command that people run, and what it writes."""

import shlex
from collections.abc import Sequence
from typing import NamedTuple


class Write(NamedTuple):
    """A text that is to stand in a file."""

    path: str
    text: str  # without its last line end


class Remedy(NamedTuple):
    """One command that mends something. What only writes files `robotwalk doctor --fix` can do itself."""

    command: str
    writes: tuple[Write, ...] = ()
    then: str = ""  # what it takes to be in force, if it is not at once


def writing(text: str, paths: Sequence[str], then: str = "") -> Remedy:
    """Return what has a text stand in files, as root."""
    lines = " ".join(shlex.quote(line) for line in text.splitlines())
    return Remedy(
        f"printf '%s\\n' {lines} | sudo tee {shlex.join(paths)}", tuple(Write(path, text) for path in paths), then)
