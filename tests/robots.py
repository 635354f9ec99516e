"""Robots' files for tests, made from bundled ones."""

import re

from robotwalk.config import library


def hexapod_that_does_not_feel() -> str:
    """Return the hexapod's file without its feet's reactions to the ground, tuned for its own servos and paths."""
    text = library.open_document("robots", "hexapod").text
    return re.sub(r"^  (contact|orientation):.*\n", "", text, flags=re.MULTILINE)
