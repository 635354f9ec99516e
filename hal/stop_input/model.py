"""The stop input of a robot, in its file's `hardware` section (docs/safety.md)."""

from typing import Annotated, Literal

from pydantic import Field

from hal.foot_switches.model import Input
from hal.schema import Row

LineName = Literal["cts", "dsr", "dcd", "ri"]


class StopInputConfig(Row):
    """Where the button is, and what it does. Just one of `bus` and `port`, and of `line` and `input`."""

    bus: str | None = None  # a servo bus, on whose adapter the line is
    port: str | None = None  # or a port of its own
    line: LineName | None = None  # of the modem lines that a serial port can hear
    input: Input | None = None  # or of a board that sends what a foot-switch board does
    baud: Annotated[int, Field(gt=0)] = 115200  # of a port of its own
    contact: Literal["normally_closed", "normally_open"] = "normally_closed"  # open stops; closed does
    stop: Literal["hold", "sit", "limp"] = "hold"  # as `robotwalk stop` does, with this option
    settle_ms: Annotated[float, Field(ge=0, le=200)] = 20.0  # that it must read the same: contacts bounce
    stale_after_s: Annotated[float, Field(gt=0, le=1)] = 0.1  # so long after the board's last word it counts as gone
