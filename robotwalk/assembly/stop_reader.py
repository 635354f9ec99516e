"""Who has a robot's stop input read, in a process of its own: `robotwalk.assembly.stop_process`."""

import os
import subprocess
import sys
import time
from collections.abc import Mapping
from typing import NamedTuple

from hal.descriptor_port import DescriptorPort
from hal.hardware import STOP_PORT
from hal.serial_transport import names_hardware
from hal.stop_input.model import StopInputConfig
from robotwalk.errors import RobotwalkError
from robotwalk.ports import BytePort
from robotwalk.process.mailbox import packed
from robotwalk.process.shared import Mailbox, Stop
from robotwalk.process.stop_input import StopWatch

_STARTED = 30.0  # s within which it must read
_LOOK = 0.01  # s


class StopBrief(NamedTuple):
    """What that process is told at its start."""

    config: StopInputConfig
    url: str
    port: int  # descriptors
    mailbox: int
    lease: int  # the end of a pipe that ends with those who heed it


class StopReader:
    """The process, while it is needed.

    Attributes:
        lease: a descriptor; as long as anybody has it open the process reads on.
    """

    def __init__(
        self, config: StopInputConfig, urls: Mapping[str, str], opened: Mapping[str, BytePort], shared: int
    ) -> None:
        """Start it, and wait until it reads.

        Args:
            config: the stop input.
            urls, opened: of the robot's lines.
            shared: descriptor of the mailbox, into which its readings go.

        Raises:
            BusError: the port has no such line.
            RobotwalkError: the process does not start.
        """
        url, port = urls[_line_of(config)], opened[_line_of(config)]
        if config.line is not None:
            DescriptorPort(url, port.fileno(), config.baud).modem_lines()
        end, self.lease = os.pipe()
        self._process = subprocess.Popen(
            [sys.executable, "-m", "robotwalk.assembly.stop_process"], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
            start_new_session=True, pass_fds=[port.fileno(), shared, end])
        os.close(end)
        assert self._process.stdin is not None
        with self._process.stdin as stdin:
            stdin.write(packed(StopBrief(config, url, port.fileno(), shared, end)))
        slot, until = Mailbox(shared).stop_input, time.monotonic() + _STARTED
        while slot.number == 0:
            if time.monotonic() > until or self._process.poll() is not None:
                self.close()
                raise RobotwalkError("the process that reads the stop input does not start")
            time.sleep(_LOOK)

    def close(self) -> None:
        """Let it go. May be called twice."""
        if self.lease >= 0:
            os.close(self.lease)
            self.lease = -1
            self._process.wait()


def unreadable(config: StopInputConfig | None, urls: Mapping[str, str]) -> str | None:
    """Return why the stop input of a simulated robot cannot be read, in words, if that is so."""
    if config is None or config.line is None or names_hardware(urls[_line_of(config)]):
        return None
    return f"the stop input is not read: {urls[_line_of(config)]} is simulated, and has no modem lines"


def _line_of(config: StopInputConfig) -> str:
    return config.bus or STOP_PORT


def watch_of(config: StopInputConfig | None, mailbox: Mailbox) -> StopWatch:
    """Return what heeds a stop input that is read, or None if none is."""
    return StopWatch(mailbox.stop_input, Stop[config.stop.upper()] if config is not None else None)
