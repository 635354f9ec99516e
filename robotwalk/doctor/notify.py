"""What a service tells systemd of itself: that it is ready, alive, on its way down. Protocol: sd_notify(3).

Nobody listens where systemd did not start this process; then nothing is sent. What cannot be sent is let go: a robot
does not stop for that.
"""

import contextlib
import os
import socket
from collections.abc import MutableMapping

_US = 1e-6


class Notify:
    """The socket of who started this process, if it gave one."""

    def __init__(self, environment: MutableMapping[str, str] = os.environ) -> None:
        """Take it out of the environment: it is not for the processes that this one starts."""
        address = environment.pop("NOTIFY_SOCKET", "")
        period, whose = environment.pop("WATCHDOG_USEC", ""), environment.pop("WATCHDOG_PID", "")
        meant = whose in ("", str(os.getpid()))
        self._every = 0.5 * _US * int(period) if period.isdecimal() and meant else None  # s
        self._sent_at = float("-inf")
        self._socket: socket.socket | None = None
        if address.startswith(("/", "@")):
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK | socket.SOCK_CLOEXEC)
            with contextlib.suppress(OSError):
                self._socket.connect(address.replace("@", "\0", 1) if address.startswith("@") else address)

    def ready(self) -> None:
        """Tell that the service has started."""
        self._send(b"READY=1")

    def alive(self, now: float) -> None:
        """Tell that it lives, if it is to and half of its time is over; `now` is any clock's, s. Cheap to call."""
        if self._every is not None and now - self._sent_at >= self._every:
            self._sent_at = now
            self._send(b"WATCHDOG=1")

    def stopping(self) -> None:
        """Tell that the service is on its way down."""
        self._send(b"STOPPING=1")

    def close(self) -> None:
        """Give the socket back."""
        if self._socket is not None:
            self._socket.close()

    def _send(self, message: bytes) -> None:
        if self._socket is not None:
            with contextlib.suppress(OSError):
                self._socket.send(message)
