"""What a driver and a loop in two processes tell each other, through a mailbox."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from robotwalk.loop import Tick
from robotwalk.process.plain import Codec
from robotwalk.supervisor import State
from robotwalk.types import BusStatistics, Command, SensorStatistics, ServoCondition


class Brief(NamedTuple):
    """What a loop's process is told at its start."""

    parent: int  # process id
    files: Mapping[str, str]  # the robot's
    lines: Mapping[str, tuple[str, int]]  # URL and descriptor of each serial line
    mailbox: int  # descriptors
    doorbell: int
    rate_hz: int
    recorded: bool
    stop_input: bool  # another process reads it
    hung: bool  # the robot is on a stand


class Orders(NamedTuple):
    """What the driver wants; it lasts until the next."""

    command: Command
    away: bool  # the driver has nothing to say for a while, and need not beat; the robot stands


class Call(NamedTuple):
    """What the driver has the loop do once."""

    name: str
    argument: Any = None


class Answer(NamedTuple):
    """What came of a call."""

    call: int  # its number
    error: tuple[str, str] | None  # class and text
    result: Any
    state: State
    armed: bool
    tick: int  # the number of the newest before


class Report(NamedTuple):
    """A tick, and what else may have changed by then."""

    tick: Tick  # without the statics of the legs: the most of it, and no driver's business
    fault: str | None
    low: bool
    missed: int


REPORT = Codec(Report)


class Status(NamedTuple):
    """What changes slowly."""

    missed: int
    cuts: Counter[tuple[str, str]]
    digest: str
    notes: Sequence[str]
    conditions: Mapping[str, ServoCondition]
    statistics: Mapping[str, BusStatistics]
    sensors: Mapping[str, SensorStatistics]  # by the names of their lines
    lacking: Sequence[str]  # what the loop has not been given to keep its deadlines, in words
    ended: str | None  # why the loop is no more, in words; "": it was told to end
    doubtful: Sequence[str]  # joints whose torque may still be on then
