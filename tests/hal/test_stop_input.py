"""A stop button: what each kind of contact, line and board says, and that whatever is cut or gone says stop."""

import os
import pty
import termios
from typing import Any

import pytest

from hal.descriptor_port import DescriptorPort
from hal.hardware import HardwareConfig, stop_input_problems
from hal.stop_input.board_input import BoardInput
from hal.stop_input.modem_line import ModemLine
from robotwalk.errors import BusError

from .foot_switches.test_frames import framed
from .unasked_rig import MS, Line


class Adapter:
    """A serial port whose modem lines the test holds. No port with such lines is at hand; see docs/safety.md."""

    bits = 0

    def modem_lines(self) -> int:
        return self.bits

    def close(self) -> None:
        pass


@pytest.mark.parametrize("normally_closed", [True, False])
def test_a_line_stops_by_its_contact_and_no_other_line_does(normally_closed: bool) -> None:
    adapter = Adapter()
    line = ModemLine(adapter, "dsr", normally_closed=normally_closed)
    others = termios.TIOCM_CTS | termios.TIOCM_CD | termios.TIOCM_RI | termios.TIOCM_DTR | termios.TIOCM_RTS
    closed, opened = (None, "its line DSR is off") if normally_closed else ("its line DSR is on", None)
    for more in (0, others):
        adapter.bits = termios.TIOCM_DSR | more
        assert line.read() == closed
        adapter.bits = more
        assert line.read() == opened


@pytest.mark.parametrize("normally_closed", [True, False])
def test_a_port_that_is_gone_says_stop_and_a_terminal_has_no_lines(normally_closed: bool) -> None:
    master, slave = pty.openpty()
    port = DescriptorPort("/dev/ttyUSB0", slave, 9600)
    with pytest.raises(BusError, match="/dev/ttyUSB0 has no modem lines"):
        port.modem_lines()
    os.close(master)
    reading = ModemLine(port, "cts", normally_closed=normally_closed).read()
    assert reading is not None
    assert "is gone" in reading
    port.close()


def test_a_boards_input_stops_when_open_when_silent_and_when_gone() -> None:
    line = Line()
    button = BoardInput(line, line, 3, normally_closed=True, stale_after=0.1)
    assert button.read() is None, "it has its time to be heard"

    def after(milliseconds: int, data: bytes = b"") -> str | None:
        line.time += milliseconds * MS
        line.data += data
        return button.read()

    assert after(10, framed(0b1000)) is None
    assert after(10, framed(0b0111)) == "its input 3 is open"
    assert after(10, framed(0b1000)) is None
    assert after(90, b"F" * 40) is None
    assert after(20, framed(0b1000)[:4]) == "its board is silent"
    assert after(10, framed(0b1000)[4:]) is None
    line.gone = True
    assert after(110) == "/dev/ttyUSB1 is gone: it ends"


@pytest.mark.parametrize(("stop", "bus", "found"), [
    ({"bus": "legs", "line": "dsr"}, "legs", None),
    ({"port": "/dev/ttyUSB1", "line": "ri"}, "legs", None),
    ({"port": "/dev/ttyUSB1", "input": 15}, "legs", None),
    ({"line": "dsr"}, "legs", "either `bus`"),
    ({"bus": "legs", "port": "/dev/ttyUSB1", "line": "dsr"}, "legs", "either `bus`"),
    ({"port": "/dev/ttyUSB1"}, "legs", "either a `line`"),
    ({"bus": "arms", "line": "dsr"}, "legs", "no such bus; there are legs"),
    ({"bus": "legs", "input": 3}, "legs", "a board needs a `port`"),
    ({"port": "/dev/ttyUSB1", "input": 3}, "stop", "what the line of the stop input is called"),
])
def test_what_does_not_fit_is_told(stop: dict[str, Any], bus: str, found: str | None) -> None:
    config = HardwareConfig.model_validate(
        {"buses": {bus: {"port": "/dev/ttyUSB0", "baud": 1000000}}, "joints": {}, "stop_input": stop})
    problems = [problem.what for problem in stop_input_problems(config)]
    assert (problems == []) if found is None else (len(problems) == 1 and found in problems[0])
