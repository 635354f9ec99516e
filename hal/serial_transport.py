"""Serial lines by URL: a device file, or anything else that pyserial opens (`socket://host:port`)."""

import contextlib
import errno
import os
import termios
from pathlib import Path
from urllib.parse import urlsplit

import serial

from hal.descriptor_port import DescriptorPort
from hal.echo import EchoFilter
from hal.tunable_port import TunablePort
from robotwalk.errors import BusError

_LOOPBACK = ("localhost", "127.0.0.1", "::1")


def names_hardware(url: str) -> bool:
    """Tell whether a URL leads to what may be a physical robot: a pseudo-terminal, and a socket here, do not."""
    if "://" in url:
        try:
            return not (url.startswith("socket://") and urlsplit(url).hostname in _LOOPBACK)
        except ValueError:
            return True  # it will not open either
    return os.path.exists(url) and not os.path.realpath(url).startswith("/dev/pts/")


def open_port(url: str, baud: int) -> TunablePort:
    """Open a line for us alone, with as little latency as its adapter allows, its stale bytes thrown away.

    An echo of what is sent is dropped.

    Raises:
        BusError: it cannot be opened; says why, and what may help.
    """
    return EchoFilter(open_plainly(url, baud))


def open_plainly(url: str, baud: int) -> "SerialPort":
    """Open a line as `open_port` does, echo and all: to listen to others, who alone know what is an echo.

    Raises:
        BusError: it cannot be opened.
    """
    try:
        line = serial.serial_for_url(url, baudrate=baud, timeout=0, exclusive=True)
    except (serial.SerialException, ValueError, TypeError, OSError) as error:
        raise BusError(f"cannot open {url}: {_reason(url, error)}") from error
    if hasattr(line, "set_low_latency_mode"):
        # Pseudo-terminals and many adapters have nothing to set.
        with contextlib.suppress(ValueError, OSError):
            line.set_low_latency_mode(True)
    line.reset_input_buffer()
    return SerialPort(url, line)


class SerialPort(DescriptorPort):
    """A `TunablePort` over pyserial, which sets the line up; bytes go by its descriptor."""

    def __init__(self, url: str, line: serial.SerialBase) -> None:
        super().__init__(url, line.fileno(), line.baudrate)
        self._line = line

    @property
    def baud(self) -> int:
        """The baud rate. Setting it waits until what was written has left, and throws away what has come."""
        return int(self._line.baudrate)

    @baud.setter
    def baud(self, baud: int) -> None:
        try:
            self._line.flush()
            self._line.baudrate = baud
            self._line.reset_input_buffer()
        except (serial.SerialException, ValueError, OSError, termios.error) as error:
            raise BusError(f"{self._url} cannot be set to {baud} baud: {error}") from error

    def close(self) -> None:
        """Give the line back."""
        self._line.close()


def inherited_port(url: str, baud: int, descriptor: int, *, echoes: bool = True) -> TunablePort:
    """Return the line that our parent has opened; an echo of what is sent is dropped where it may be one."""
    port = DescriptorPort(url, descriptor, baud)
    return EchoFilter(port) if echoes else port


def _reason(url: str, error: Exception) -> str:
    """Say why a port does not open, and what may help."""
    if isinstance(error, (ValueError, TypeError)) or (url.startswith("socket://") and ":" not in url[9:]):
        return "this is no address of a port; try socket://host:port or a device file"
    number = getattr(error, "errno", None)
    if number == errno.ENOENT or (number is None and not url.startswith("socket://") and not Path(url).exists()):
        return "there is no such port; is the adapter plugged in?"
    if number in (errno.EACCES, errno.EPERM):
        return "permission denied; add yourself to the port's group: sudo usermod -aG dialout $USER, then log in again"
    if number in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in str(error):
        return "another program has it open"
    if number == errno.ECONNREFUSED or "refused" in str(error):
        return "nobody listens there"
    return str(error)
