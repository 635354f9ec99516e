"""Adapters that let a host hear its own bytes: found out once, dropped from then on."""

from hal.tunable_port import TunablePort


class EchoFilter:
    """A port that drops the echo of what was sent, if its adapter echoes.

    Whether it does shows in the first bytes that come back: a servo's answer is never the request itself.
    Without this, the echo of a Feetech ping would pass for the status of a servo in error.
    """

    def __init__(self, port: TunablePort) -> None:
        self._port = port
        self._echoes: bool | None = None  # None: not known yet
        self._expected = b""  # sent, its echo not yet seen
        self._held = b""  # read while it is not known yet

    @property
    def baud(self) -> int:
        """The port's baud rate. Setting it throws away what has come."""
        return self._port.baud

    @baud.setter
    def baud(self, baud: int) -> None:
        self._port.baud = baud
        self._expected = self._held = b""

    def fileno(self) -> int:
        """Return the port's descriptor."""
        return self._port.fileno()

    def waiting(self) -> int:
        """Return how many bytes may be read; echoes among them."""
        return self._port.waiting()

    def write(self, data: bytes) -> None:
        """Send bytes."""
        if self._echoes is not False:
            self._expected += data
        self._port.write(data)

    def read(self) -> bytes:
        """Return the bytes that have come, less the echo."""
        data = self._port.read()
        if self._echoes is None:
            data = self._find_out(self._held + data)
        if self._echoes and data:
            data = self._without_echo(data)
        return data

    def close(self) -> None:
        """Close the port."""
        self._port.close()

    def _find_out(self, data: bytes) -> bytes:
        """Compare the first bytes with what was sent; hold them back while both are still possible."""
        together = min(len(data), len(self._expected))
        if data[:together] != self._expected[:together]:
            self._echoes = False
            self._expected = b""
        elif self._expected and together == len(self._expected):
            self._echoes = True
        else:
            self._held = data
            return b""
        self._held = b""
        return data

    def _without_echo(self, data: bytes) -> bytes:
        """Drop as much of the expected echo as has come; what does not match is no echo."""
        together = min(len(data), len(self._expected))
        if data[:together] == self._expected[:together]:
            self._expected = self._expected[together:]
            return data[together:]
        self._expected = b""
        return data
