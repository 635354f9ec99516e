"""The process that reads a robot's stop input, `python -m robotwalk.assembly.stop_process`.

`robotwalk.process.stop_input` tells why it is one of its own.
"""

import signal
import sys

from hal.descriptor_port import DescriptorPort
from hal.stop_input.board_input import BoardInput
from hal.stop_input.model import StopInputConfig
from hal.stop_input.modem_line import ModemLine
from robotwalk.assembly.stop_reader import StopBrief
from robotwalk.clock import WallClock
from robotwalk.ports import StopInput
from robotwalk.process.mailbox import unpacked
from robotwalk.process.shared import Mailbox
from robotwalk.process.stop_input import Settled, serve
from robotwalk.realtime import DEVICE_PRIORITY, name_process, raise_priority

_NS_PER_MS = 1_000_000


def stop_input_of(config: StopInputConfig, url: str, descriptor: int) -> StopInput:
    """Put a stop input on its opened port."""
    port, normally_closed = DescriptorPort(url, descriptor, config.baud), config.contact == "normally_closed"
    if config.line is not None:
        return ModemLine(port, config.line, normally_closed=normally_closed)
    assert config.input is not None
    return BoardInput(
        port, WallClock(), config.input, normally_closed=normally_closed, stale_after=config.stale_after_s)


def main() -> None:
    """Read until those who heed it are gone; signals are theirs."""
    name_process("robotwalk-stop")
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    brief: StopBrief = unpacked(sys.stdin.buffer.read())
    raise_priority(DEVICE_PRIORITY)
    source = Settled(
        stop_input_of(brief.config, brief.url, brief.port), round(brief.config.settle_ms * _NS_PER_MS))
    serve(source, Mailbox(brief.mailbox).stop_input, WallClock(), brief.lease)


if __name__ == "__main__":
    main()
