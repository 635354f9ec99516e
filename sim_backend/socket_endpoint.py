"""A bus behind a TCP port of this computer: raw bytes, as pyserial's `socket://` speaks them."""

import contextlib
import ipaddress
import socket
from collections.abc import Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import partial
from typing import NamedTuple

from robotwalk.errors import BusError, UsageError
from sim_backend.endpoint import Endpoint, opened

_CHUNK = 65536
_LAST_PORT = 65535


class Address(NamedTuple):
    """Where to listen."""

    host: str
    port: int  # 0: any free one


def parse_address(text: str) -> Address:
    """Read `HOST:PORT`; the host is this computer, since servos know no passwords.

    Raises:
        UsageError: it is something else.
    """
    host, colon, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not colon or not port.isdecimal() or int(port) > _LAST_PORT:
        raise UsageError(f"should be HOST:PORT with a port up to {_LAST_PORT}, not {text!r}")
    if not _is_loopback(host):
        raise UsageError(f"serves this computer alone: the host should be localhost, 127.0.0.1 or [::1], not {host!r}")
    return Address(host, int(port))


def _is_loopback(host: str) -> bool:
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class SocketEndpoint:
    """A listening socket and at most one client; an `Endpoint`."""

    def __init__(self, address: Address, baud: int) -> None:
        """Listen.

        Raises:
            BusError: the port is taken.
        """
        self.baud = baud
        host, port = address
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            self._listener = socket.create_server(address, family=family)
        except (OSError, OverflowError) as error:
            raise BusError(f"cannot listen on {host}:{port}: {error}") from error
        self._listener.setblocking(False)
        self._client: socket.socket | None = None
        named = f"[{host}]" if family == socket.AF_INET6 else host
        self.url = f"socket://{named}:{self._listener.getsockname()[1]}"

    def descriptors(self) -> Sequence[int]:
        """Return what to poll for reading."""
        if self._client is None:
            return (self._listener.fileno(),)
        return self._listener.fileno(), self._client.fileno()

    def receive(self, ready: Collection[int]) -> bytes:
        """Return what the client sent; take the next client after it has gone, and turn away others."""
        data = self._read()
        if self._listener.fileno() in ready:
            self._accept()
        return data

    def send(self, data: bytes) -> None:
        """Send to the client, if there is one."""
        if self._client is not None:
            with contextlib.suppress(OSError):
                self._client.send(data)

    def close(self) -> None:
        """Hang up."""
        self._hang_up()
        self._listener.close()

    def _read(self) -> bytes:
        """Return all that has come. To read until nothing is left is also how a client's end is noticed."""
        pieces = []
        while self._client is not None:
            try:
                piece = self._client.recv(_CHUNK)
            except BlockingIOError:
                break
            except OSError:
                piece = b""
            pieces.append(piece)
            if not piece:
                self._hang_up()
        return b"".join(pieces)

    def _accept(self) -> None:
        with contextlib.suppress(OSError):  # it may have gone again
            client, _ = self._listener.accept()
            if self._client is not None:
                client.close()
                return
            client.setblocking(False)
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._client = client

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None


def open_sockets(address: Address, bauds: Mapping[str, int]) -> AbstractContextManager[Mapping[str, Endpoint]]:
    """Listen for each bus, on ports that follow each other."""
    host, port = address
    return opened({
        bus: partial(SocketEndpoint, Address(host, port + index if port else 0), baud)
        for index, (bus, baud) in enumerate(bauds.items())})
