"""Programs that drive: JSON messages over a WebSocket, on this computer unless told otherwise.

The server runs in a thread of its own, for it must answer while the main one waits. Messages go to the main thread
through a queue; telemetry goes the other way as one text, always the newest, so that a slow client only gets less.
"""

import asyncio
import contextlib
import hmac
import http
import ipaddress
import itertools
import socket
import threading
from collections import deque
from collections.abc import Iterable, Sequence
from typing import NamedTuple
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.typing import Origin

from robotwalk.errors import ConfigError, UsageError
from robotwalk.teleop import messages
from robotwalk.teleop.ask import Ask, Wish
from robotwalk.teleop.told import Told

_TELEMETRY_PERIOD = 0.1  # s
_BETWEEN_MESSAGES = 0.002  # s, at the least: a flood is slowed down, not queued
_LONGEST = 4096  # bytes of a message
_MOST_CLIENTS = 16


class Address(NamedTuple):
    """Where to listen."""

    host: str
    port: int

    @classmethod
    def parse(cls, text: str) -> "Address":
        """Read HOST:PORT. Raises UsageError if it is something else."""
        host, separator, port = text.rpartition(":")
        if not (separator and host and port.isdecimal() and int(port) < 65536):
            raise UsageError(f"--listen should be HOST:PORT, such as 127.0.0.1:8765, not {text!r}")
        return cls(host.strip("[]"), int(port))

    @property
    def loopback(self) -> bool:
        """Whether only this computer can reach it."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False


class WebSocketDoor:
    """Lets programs drive and watch."""

    def __init__(
        self, address: Address, robot: str, gaits: Sequence[str], *, token: str | None = None,
        origins: Sequence[str] = (),
    ) -> None:
        """Listen.

        Args:
            address: where.
            robot, gaits: what clients are told first.
            token: what clients must know; beyond this computer there must be one.
            origins: of pages whose scripts may connect; programs that are no browsers have none.

        Raises:
            UsageError: it is wider than this computer and there is no token, or the address cannot be had.
        """
        if token is None and not address.loopback:
            raise UsageError(
                f"anyone who can reach {address.host} could drive the robot: put a token into ROBOTWALK_TOKEN, or "
                "listen on 127.0.0.1")
        try:
            family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
            listener = socket.create_server(address, family=family)
        except OSError as error:
            raise UsageError(f"cannot listen at {address.host}:{address.port}: {error.strerror or error}") from error
        self._hello = robot, tuple(gaits)
        self._token = token
        self._origins = [None, *map(Origin, origins)]
        self._asks: deque[Ask] = deque()
        self._refusals: dict[str, str] = {}
        self._telemetry = ""
        self._clients = 0
        self._numbers = itertools.count(1)
        self._loop = asyncio.new_event_loop()
        self._end = asyncio.Event()
        host = f"[{address.host}]" if ":" in address.host else address.host
        self.url = f"ws://{host}:{listener.getsockname()[1]}"
        self._thread = threading.Thread(target=self._run, args=(listener,), name="teleop-socket", daemon=True)
        self._thread.start()

    @property
    def status(self) -> str:
        """Where it listens, and how many do listen."""
        return f"{self.url} ({self._clients})"

    @property
    def help(self) -> Sequence[str]:
        """Programs need none here."""
        return ()

    def poll(self, now: float, told: Told) -> Iterable[Ask]:
        """Return what clients ask for."""
        self._telemetry = messages.telemetry(told) if self._clients else ""
        return [self._asks.popleft() for _ in range(len(self._asks))]

    def answer(self, ask: Ask, refusal: str) -> None:
        """Tell a client why not, with the next telemetry."""
        self._refusals[ask.driver] = refusal

    def close(self) -> None:
        """Close all connections."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._end.set)
            self._thread.join(2.0)

    def _run(self, listener: socket.socket) -> None:
        with contextlib.closing(self._loop):
            self._loop.run_until_complete(self._serve(listener))

    async def _serve(self, listener: socket.socket) -> None:
        server: Server
        async with serve(
            self._client, sock=listener, origins=self._origins, process_request=self._admit, max_size=_LONGEST,
            compression=None, close_timeout=1.0, server_header=None,
        ) as server:
            await self._end.wait()
            server.close()

    def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        """Return why a client may not connect, if it may not."""
        if self._clients >= _MOST_CLIENTS:
            return connection.respond(http.HTTPStatus.SERVICE_UNAVAILABLE, "too many clients\n")
        if self._token is None:
            return None
        given = request.headers.get("Authorization", "").removeprefix("Bearer ")
        given = given or parse_qs(urlsplit(request.path).query).get("token", [""])[0]
        if hmac.compare_digest(given.encode(), self._token.encode()):
            return None
        return connection.respond(
            http.HTTPStatus.UNAUTHORIZED, "send the token as `Authorization: Bearer TOKEN` or as ?token=TOKEN\n")

    async def _client(self, connection: ServerConnection) -> None:
        """Serve one client until it goes or is gone."""
        name = f"socket {next(self._numbers)}"
        self._clients += 1
        telling = asyncio.ensure_future(self._tell(connection, name))
        try:
            await connection.send(messages.hello(*self._hello, name))
            async for text in connection:
                try:
                    self._asks.append(messages.read(text, name))
                except ConfigError as error:
                    await connection.send(messages.error(str(error)))
                await asyncio.sleep(_BETWEEN_MESSAGES)
        except ConnectionClosed:
            pass
        finally:
            self._clients -= 1
            self._asks.append(Ask(name, wish=Wish.LEAVE))
            self._refusals.pop(name, None)
            telling.cancel()

    async def _tell(self, connection: ServerConnection, name: str) -> None:
        """Send telemetry, and refusals; what a slow client cannot take it never gets."""
        with contextlib.suppress(ConnectionClosed):
            while True:
                await asyncio.sleep(_TELEMETRY_PERIOD)
                if refusal := self._refusals.pop(name, None):
                    await connection.send(messages.error(refusal))
                if self._telemetry:
                    await connection.send(self._telemetry)
