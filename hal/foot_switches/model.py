"""The foot switches of a robot, in its file's `hardware` section."""

from typing import Annotated

from pydantic import Field

from hal.foot_switches.frame import INPUTS
from hal.schema import Row

Input = Annotated[int, Field(ge=0, lt=INPUTS)]


class FootSwitchConfig(Row):
    """A board, and the feet whose switches are on it."""

    port: str
    baud: Annotated[int, Field(gt=0)] = 115200
    rate_hz: Annotated[float, Field(gt=0, le=1000)] = 200.0  # that the board sends at
    inputs: Annotated[dict[str, Input], Field(min_length=1)]  # of the board, by leg; feet left out have no switch
    stale_after_s: Annotated[float, Field(gt=0, le=5)] = 0.1  # then what the board said last counts no more
    # A switch's operating force; a simulated one closes at it, nothing else relies on it. Assumed: snap-action
    # switches of 12 mm have 1 to 2.5 N, a foot of the hexapod bears 8 N.
    closes_at_n: Annotated[float, Field(gt=0, le=100)] = 1.5
