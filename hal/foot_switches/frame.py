"""What a board of foot switches sends, again and again: which of its sixteen inputs are closed (docs/foot-switches.md).

    46 53  closed  sum        5 bytes: "FS"; 16 bits, low byte first, bit i for input i; the sum of all bytes before it

Nobody makes such a board: the framing is ours, the least that a microcontroller can send and a host can trust. One
changed byte always spoils the sum.
"""

import re

from hal.unasked_frames import Framing

INPUTS = 16
FRAMING = Framing(re.compile(rb"FS"), size=5, summed_from=0)


def decode(frame: bytes) -> int:
    """Return a whole frame's inputs, as the bits of a number."""
    return frame[2] | frame[3] << 8
