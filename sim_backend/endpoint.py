"""What a client opens to reach one bus."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from typing import Protocol


class Endpoint(Protocol):
    """A serial device that programs can open. No call blocks."""

    @property
    def url(self) -> str:
        """What a client opens."""
        ...

    @property
    def baud(self) -> int:
        """The baud rate that the client has set."""
        ...

    def descriptors(self) -> Sequence[int]:
        """Return what to poll for reading."""
        ...

    def receive(self, ready: Collection[int]) -> bytes:
        """Return what the client sent, knowing which descriptors are `ready`; let clients come and go."""
        ...

    def send(self, data: bytes) -> None:
        """Send to the client. What it leaves unread for too long is lost, as in a serial port's buffer."""
        ...

    def close(self) -> None:
        """Leave nothing behind."""
        ...


@contextmanager
def opened(doors: Mapping[str, Callable[[], Endpoint]]) -> Iterator[Mapping[str, Endpoint]]:
    """Open one endpoint for each bus, all or none; close them at the end."""
    with ExitStack() as stack:
        endpoints = {}
        for bus, door in doors.items():
            endpoints[bus] = door()
            stack.callback(endpoints[bus].close)
        yield endpoints
