"""From a robot that holds itself to a limp one: torque off, and a look whether it is. Undoes `hal.arming`."""

import contextlib
from collections.abc import Iterable

from hal.servo_line import ServoLine
from hal.wired import Wired
from robotwalk.errors import BusError
from robotwalk.ports import Clock

_QUIET = 10_000_000  # ns after which no reply is under way any more
_UNHEARD = 3  # servos in a row; where so many are not to be heard the others hardly are either, and somebody waits


def settle(clock: Clock) -> None:
    """Let what is under way on the wires come to its end."""
    clock.wait((), clock.now() + _QUIET)


def disarm(lines: Iterable[ServoLine], clock: Clock) -> list[str]:
    """Switch torque off; return the joints at which that could not be confirmed. Never raises."""
    doubtful: list[str] = []
    for line in lines:
        try:
            doubtful += _let_go(line, clock)
        except Exception:
            doubtful += [servo.joint for servo in line.servos]
    return doubtful


def disarm_watchdogs(line: ServoLine) -> None:
    """Disarm a wire's watchdogs. Where that is lost they trip in vain: the servos hold all the same."""
    frames = line.watchdogs.disarmed()
    if frames:
        with contextlib.suppress(BusError, OSError):
            line.wire.send(frames)


def _let_go(line: ServoLine, clock: Clock) -> list[str]:
    """Switch a wire's torque off, twice since nobody acknowledges a broadcast, and look whether it is."""
    for _ in range(2):
        settle(clock)
        line.broadcast_torque_off()
    disarm_watchdogs(line)
    settle(clock)
    doubtful: list[str] = []
    unheard = 0
    for servo in line.servos:
        if unheard < _UNHEARD:
            try:
                _switch_off(line, servo, clock)
                unheard = 0
                continue
            except BusError:
                unheard += 1
        doubtful.append(servo.joint)
    return doubtful


def _switch_off(line: ServoLine, servo: Wired, clock: Clock) -> None:
    """Switch a servo's torque off if it is on. Raises BusError if that cannot be confirmed."""
    if line.read_register(clock, servo, "torque_enable") != 0:
        line.write_register(clock, servo, "torque_enable", 0)
