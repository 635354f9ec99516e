"""A serial line that somebody has opened already: bytes in and out of its descriptor, without waiting."""

import contextlib
import errno
import fcntl
import os
import select
import struct
import termios

from robotwalk.errors import BusError

_CHUNK = 4096  # bytes; more than any reply
_COUNT = struct.Struct("i")


class DescriptorPort:
    """A `TunablePort` over a descriptor; its baud rate is another's business."""

    def __init__(self, url: str, descriptor: int, baud: int) -> None:
        """Take a descriptor; the name is for messages."""
        self._url = url
        self._fileno = descriptor
        self._baud = baud
        os.set_blocking(descriptor, False)

    @property
    def baud(self) -> int:
        """The baud rate at which it was opened."""
        return self._baud

    @baud.setter
    def baud(self, baud: int) -> None:
        raise BusError(f"{self._url} belongs to another process, which alone can set it to {baud} baud")

    def fileno(self) -> int:
        """Return the descriptor to poll."""
        return self._fileno

    def modem_lines(self) -> int:
        """Return which modem lines are on, as the bits TIOCM_* of tty_ioctl(4).

        Raises:
            BusError: the port has none, as a pseudo-terminal and a socket, or is gone.
        """
        try:
            bits: int = _COUNT.unpack(fcntl.ioctl(self._fileno, termios.TIOCMGET, bytes(_COUNT.size)))[0]
        except OSError as error:
            if error.errno in (errno.ENOTTY, errno.EINVAL):
                raise BusError(f"{self._url} has no modem lines") from error
            raise BusError(f"{self._url} is gone: {error.strerror}") from error
        return bits

    def write(self, data: bytes) -> None:
        """Send bytes.

        Raises:
            BusError: the line is gone.
        """
        # Not by pyserial: its write waits, or spins, for as long as a stuck adapter takes no bytes.
        try:
            written = os.write(self._fileno, data)
        except BlockingIOError:
            written = 0
        except OSError as error:
            raise BusError(f"{self._url} is gone: {error.strerror}") from error
        if written < len(data):
            raise BusError(f"{self._url} takes no more bytes: is its adapter stuck?")

    def waiting(self) -> int:
        """Return how many bytes can be read.

        Raises:
            BusError: the line is gone.
        """
        try:
            count: int = _COUNT.unpack(fcntl.ioctl(self._fileno, termios.FIONREAD, bytes(_COUNT.size)))[0]
        except OSError as error:
            raise BusError(f"{self._url} is gone: {error.strerror}") from error
        return count

    def read(self) -> bytes:
        """Return the bytes that have come.

        Raises:
            BusError: the line is gone.
        """
        # Not by pyserial, which asks twice whether there is anything.
        data = self._read()
        if data or not select.select([self._fileno], [], [], 0)[0]:
            return data
        data = self._read()  # what has come in between
        if not data:
            raise BusError(f"{self._url} is gone: it ends")
        return data

    def _read(self) -> bytes:
        try:
            return os.read(self._fileno, _CHUNK)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise BusError(f"{self._url} is gone: {error.strerror}") from error

    def close(self) -> None:
        """Give the descriptor back. May be called twice."""
        descriptor, self._fileno = self._fileno, -1
        if descriptor >= 0:
            with contextlib.suppress(OSError):
                os.close(descriptor)
