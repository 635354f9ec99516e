"""The baud rate of an open line."""

import os
import pty
import termios
import tty

import pytest

from hal.echo import EchoFilter
from hal.serial_transport import open_port
from robotwalk.clock import WallClock
from robotwalk.errors import BusError

from .rig import Chatter

PING, STATUS = b"\xff\xff\x01\x02\x01\xfb", b"\xff\xff\x01\x02\x00\xfc"


def test_the_baud_rate_changes_while_the_line_stays_open_and_old_bytes_are_gone() -> None:
    master, slave = pty.openpty()
    tty.setraw(slave)
    port = open_port(os.ttyname(slave), 1_000_000)
    os.write(master, STATUS)
    WallClock().wait((port,), WallClock().now() + 10**9)
    port.baud = 57600
    assert port.baud == 57600
    assert termios.tcgetattr(slave)[4:6] == [termios.B57600, termios.B57600]
    assert port.read() == b""
    port.write(PING)
    assert os.read(master, 100) == PING
    port.close()
    os.close(master)
    os.close(slave)


def test_a_line_that_is_gone_has_no_baud_rate() -> None:
    master, slave = pty.openpty()
    port = open_port(os.ttyname(slave), 1_000_000)
    os.close(slave)
    os.close(master)
    with pytest.raises(BusError, match="cannot be set to 57600 baud"):
        port.baud = 57600


class Loop(Chatter):
    """A line that echoes."""

    def __init__(self) -> None:
        super().__init__(b"")

    def write(self, data: bytes) -> None:
        self.noise += data

    def read(self) -> bytes:
        data, self.noise = self.noise, b""
        return data


def test_an_echo_is_still_dropped_at_the_next_baud_rate() -> None:
    line = Loop()
    port = EchoFilter(line)
    port.write(PING)
    assert port.read() == b""
    port.write(PING)
    port.baud = 57600  # that echo is gone with what had come
    line.noise = b""
    port.write(PING)
    line.noise += STATUS
    assert port.read() == STATUS
    assert line.baud == 57600
