"""Foot switches on a serial line of their own: `FootSwitches`."""

import math
from collections.abc import Sequence

from hal.foot_switches.frame import FRAMING, decode
from hal.foot_switches.model import FootSwitchConfig
from hal.unasked_line import UnaskedLine
from robotwalk.ports import BytePort, Clock
from robotwalk.types import FootSwitch, SensorStatistics

_UNKNOWN = FootSwitch(None, math.inf)


class SerialFootSwitches:
    """A board that talks unasked, and which foot is on which of its inputs."""

    def __init__(self, port: BytePort, clock: Clock, legs: Sequence[str], config: FootSwitchConfig) -> None:
        """Listen on an opened port; `legs` are the robot's, in its order."""
        self._line = UnaskedLine(port, clock, FRAMING)
        self._inputs = tuple(config.inputs.get(leg) for leg in legs)
        self._stale_after = config.stale_after_s
        self._closed: int | None = None  # inputs, as bits

    def read(self) -> tuple[FootSwitch, ...]:
        """Take what has come; return what is known of each foot now."""
        frames = self._line.take()
        age = self._line.heard(len(frames))
        if frames:
            self._closed = decode(frames[-1])
        if self._closed is None:
            return (_UNKNOWN,) * len(self._inputs)
        fresh, closed = age <= self._stale_after, self._closed
        return tuple(
            _UNKNOWN if bit is None else FootSwitch(bool(closed >> bit & 1) if fresh else None, age)
            for bit in self._inputs)

    def statistics(self) -> SensorStatistics:
        """Return what the board has said so far."""
        return self._line.statistics()

    def close(self) -> None:
        """Give the port back. Never raises."""
        self._line.close()
