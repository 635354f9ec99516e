"""Who may come in by the socket, and what they are told: real connections, no robot."""

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection, connect

from robotwalk.teleop.ask import Ask, Wish
from robotwalk.teleop.told import Told
from robotwalk.teleop.websocket import Address, WebSocketDoor
from robotwalk.types import Measured, ServoCondition

from .rig import await_that

MUCH = Told(conditions={
    f"joint_{n}": ServoCondition(Measured(12.0, 0.0), Measured(40.0, 0.0), None, True, ()) for n in range(4000)})


@contextmanager
def door(**options: Any) -> Iterator[WebSocketDoor]:
    opened = WebSocketDoor(Address("127.0.0.1", 0), "hexapod", ("tripod",), **options)
    try:
        yield opened
    finally:
        opened.close()


def asked(at: WebSocketDoor, told: Told, count: int) -> list[Ask]:
    """Look as teleop does, until so much was asked for."""
    asks: list[Ask] = []
    await_that(lambda: asks.extend(at.poll(time.monotonic(), told)) or len(asks) >= count, f"{count} asks")
    return asks


def kinds(client: ClientConnection, count: int) -> list[str]:
    return [json.loads(client.recv(20.0))["type"] for _ in range(count)]


def test_it_takes_the_token_to_come_in() -> None:
    with door(token="swordfish") as at:
        for wrong in ({}, {"additional_headers": {"Authorization": "Bearer sword"}}):
            with pytest.raises(InvalidStatus, match="401"):
                connect(at.url, **wrong)
        for url, right in (
            (at.url, {"additional_headers": {"Authorization": "Bearer swordfish"}}), (f"{at.url}/?token=swordfish", {}),
        ):
            with connect(url, **right) as client:
                assert kinds(client, 1) == ["hello"]


def test_scripts_of_strange_web_pages_stay_out() -> None:
    with door(origins=["http://localhost:8000"]) as at:
        with pytest.raises(InvalidStatus, match="403"):
            connect(at.url, origin="http://example.org")
        with connect(at.url, origin="http://localhost:8000") as client:
            assert kinds(client, 1) == ["hello"]


def test_errors_go_back_and_who_goes_leaves() -> None:
    with door() as at:
        with connect(at.url) as client:
            client.send("walk!")
            client.send(b'{"type": "stop"}')
            assert asked(at, Told(), 1) == [Ask("socket 1", wish=Wish.STOP)]
            at.answer(Ask("socket 1"), "not now")
            texts = [json.loads(client.recv(20.0)).get("error", "") for _ in range(3)]
            assert texts[0] == "", "the first is hello"
            assert texts[1].startswith("message: not valid JSON")
            assert texts[2] == "not now"
        assert asked(at, Told(), 1) == [Ask("socket 1", wish=Wish.LEAVE)]


def test_who_does_not_read_holds_nobody_up() -> None:
    with door() as at, connect(at.url, max_queue=1, close_timeout=0.1) as sleeper, connect(at.url) as reader:
        assert kinds(reader, 1) == ["hello"]
        for _ in range(20):  # 8 MB, more than a socket takes
            list(at.poll(time.monotonic(), MUCH))
            assert kinds(reader, 1) == ["telemetry"]
        sleeper.send('{"type": "beat"}')
        assert asked(at, MUCH, 1) == [Ask("socket 1")]
