"""A bus behind a pseudo terminal, for any program that opens a serial port."""

from collections.abc import Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path

from sim_backend.device_link import DeviceLink
from sim_backend.endpoint import Endpoint, opened
from sim_backend.pseudo_terminal import PseudoTerminal


class PtyEndpoint:
    """A pseudo terminal under a name of its own; an `Endpoint`."""

    def __init__(self, path: Path, baud: int, unasked: bool = False) -> None:
        """Open a terminal and link it as `path`; `unasked` is what hangs there if it also talks to who never asked.

        Raises:
            BusError: a living process serves under that name.
            UsageError: the link cannot be made.
        """
        self.url = str(path)
        self._terminal = PseudoTerminal(baud)
        self._unasked, self._talks_at = unasked, baud
        self._in_use = False  # whether a client that has sent something is still there
        try:
            self._link = DeviceLink(path, self._terminal.path)
        except BaseException:
            self._terminal.close()
            raise

    @property
    def baud(self) -> int:
        """The baud rate that the client has set."""
        return self._terminal.baud

    def descriptors(self) -> Sequence[int]:
        """Return what to poll for reading."""
        return self._terminal.master, self._terminal.departures

    def receive(self, ready: Collection[int]) -> bytes:
        """Return what the client sent. One that has gone leaves nothing to the next."""
        data = self._terminal.read() if self._terminal.master in ready else b""
        if data and not self._in_use:
            self._in_use = not self._terminal.is_vacant()
        if self._terminal.departures in ready and self._terminal.note_departures():
            self._in_use = False
        return data

    def send(self, data: bytes) -> None:
        """Send to the client. What comes after it has gone is no business of the next one."""
        if self._in_use or self._overhears():
            self._terminal.write(data)

    def _overhears(self) -> bool:
        """Return whether a client need not ask, and is there, at the baud rate of what talks.

        At another one it would get garbage; here it gets nothing.
        """
        return self._unasked and self._terminal.baud == self._talks_at and not self._terminal.is_vacant()

    def close(self) -> None:
        """Remove the link, then the terminal."""
        self._link.remove()
        self._terminal.close()


def open_ptys(
    folder: Path, bauds: Mapping[str, int], unasked: Collection[str] = ()
) -> AbstractContextManager[Mapping[str, Endpoint]]:
    """Open a terminal for each bus, linked as `folder/<bus>`; on those in `unasked` talks what nobody need ask."""
    return opened({bus: partial(PtyEndpoint, folder / bus, baud, bus in unasked) for bus, baud in bauds.items()})
