"""The driver: which foot it tells of, and when it does not know."""

import math

import pytest

from hal.foot_switches.model import FootSwitchConfig
from hal.foot_switches.serial_foot_switches import SerialFootSwitches
from robotwalk.types import FootSwitch

from ..unasked_rig import MS, Line
from .test_frames import framed

UNKNOWN = FootSwitch(None, math.inf)


def made() -> tuple[Line, SerialFootSwitches]:
    line = Line()
    config = FootSwitchConfig.model_validate({"port": "", "inputs": {"lf": 3, "rr": 0}})
    switches = SerialFootSwitches(line, line, ["lf", "lr", "rf", "rr"], config)
    assert switches.read() == (UNKNOWN,) * 4
    return line, switches


def later(line: Line, switches: SerialFootSwitches, milliseconds: int, data: bytes = b"") -> tuple[FootSwitch, ...]:
    line.time += milliseconds * MS
    line.data += data
    return switches.read()


def test_the_newest_report_counts_by_the_input_that_each_foot_is_on() -> None:
    line, switches = made()
    assert later(line, switches, 10, framed(0b1000)[:4]) == (UNKNOWN,) * 4
    assert later(line, switches, 10, framed(0b1000)[4:] + framed(0b0110)) == (
        FootSwitch(False, 0.0), UNKNOWN, UNKNOWN, FootSwitch(False, 0.0))
    assert [switch.closed for switch in later(line, switches, 10, framed(0b1000))] == [True, None, None, False]
    assert switches.statistics().reports == 3


def test_a_silent_or_garbled_board_is_unknown_after_its_time_and_known_with_its_next_word() -> None:
    line, switches = made()
    later(line, switches, 10, framed(0b1001))
    young = later(line, switches, 90, b"F" * 40)
    assert young[0] == (True, pytest.approx(0.09))
    old = later(line, switches, 20, b"\x00FS\x09")
    assert old[0] == (None, pytest.approx(0.11))
    assert later(line, switches, 10, framed(0b0001))[3] == (True, 0.0)
    assert switches.statistics().max_age == pytest.approx(0.11)


def test_what_piled_up_in_a_pause_and_a_port_that_is_gone_tell_nothing() -> None:
    line, switches = made()
    later(line, switches, 10, framed(0b1001))
    assert later(line, switches, 3000, framed(0))[0].closed is None
    line.gone = True
    assert later(line, switches, 10)[0].closed is None
    assert switches.statistics().failure == "/dev/ttyUSB1 is gone: it ends"
