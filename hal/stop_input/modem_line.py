"""A stop button on a modem line of a serial port: `StopInput`."""

import termios
from typing import Protocol

from hal.stop_input.model import LineName
from robotwalk.errors import BusError

_BITS: dict[LineName, int] = {
    "cts": termios.TIOCM_CTS, "dsr": termios.TIOCM_DSR, "dcd": termios.TIOCM_CD, "ri": termios.TIOCM_RI}


class ModemPort(Protocol):
    """What it needs of a port."""

    def modem_lines(self) -> int:
        """Return which lines are on, as the bits TIOCM_*. Raises BusError."""
        ...

    def close(self) -> None:
        """Give the port back."""
        ...


class ModemLine:
    """A line that is on while its contact is closed."""

    def __init__(self, port: ModemPort, line: LineName, *, normally_closed: bool) -> None:
        self._port, self._name, self._bit = port, line.upper(), _BITS[line]
        self._runs_on = normally_closed

    def read(self) -> str | None:
        """Take a reading. A port that is gone says stop."""
        try:
            on = bool(self._port.modem_lines() & self._bit)
        except BusError as error:
            return str(error)
        return None if on is self._runs_on else f"its line {self._name} is {'on' if on else 'off'}"

    def close(self) -> None:
        """Give the port back. Never raises."""
        self._port.close()
