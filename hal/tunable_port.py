"""A serial line whose baud rate can be changed while it is open."""

from typing import Protocol

from robotwalk.ports import BytePort


class TunablePort(BytePort, Protocol):
    """What the tools for single servos need of a port; the loop needs no more than `BytePort`."""

    baud: int  # setting it raises BusError where the adapter does not have that rate
