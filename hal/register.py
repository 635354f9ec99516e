"""One row of a servo's control table, and what is read of a table at once."""

import itertools
import math
from collections.abc import Iterator
from enum import StrEnum
from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from hal.schema import Row

_SI_UNITS = {
    "rpm": 2.0 * math.pi / 60.0, "rev/s": 2.0 * math.pi, "rev/min^2": 2.0 * math.pi / 3600.0,
    "us": 1e-6, "ms": 1e-3, "%": 1e-2, "mA": 1e-3,
}

ByteOrder = Literal["little", "big"]


class Access(StrEnum):
    """Who may write a register."""

    READ = "r"
    READ_WRITE = "rw"


class Memory(StrEnum):
    """Whether a register outlives power."""

    EEPROM = "eeprom"
    RAM = "ram"


class Register(Row):
    """One row of a control table. Range and default are raw counts, as on the wire."""

    name: str
    address: Annotated[int, Field(ge=0, le=65535)]
    size: Literal[1, 2, 4]
    access: Access
    memory: Memory
    signed: bool = False  # two's complement
    sign_bit: int | None = None  # the bit that holds the sign, where the rest is the magnitude
    byte_order: ByteOrder = "little"  # the model's; not given row by row
    unit: str = ""  # of one count times `scale`
    scale: float = 1.0
    range: tuple[int, int] | None = None
    choices: tuple[int, ...] | None = None  # the only values allowed, where the range has holes
    default: int | None = None  # None: measured, or set up by the firmware at start
    flags: tuple[str | None, ...] = ()  # what each bit means, from bit 0 on; null: nothing that is known

    @property
    def end(self) -> int:
        """The address behind the last byte."""
        return self.address + self.size

    @property
    def si_scale(self) -> float:
        """The value of one count in the unit's SI counterpart."""
        return self.scale * _SI_UNITS.get(self.unit, 1.0)


class Block(NamedTuple):
    """Registers that are read at once, by address."""

    registers: tuple[Register, ...]

    @property
    def address(self) -> int:
        """Where it begins."""
        return self.registers[0].address

    @property
    def size(self) -> int:
        """How many bytes it spans, holes included."""
        return self.registers[-1].end - self.address


class Encoder(Row):
    """How position counts relate to the output shaft."""

    ticks: Annotated[int, Field(gt=0)]  # counts from 0 on
    span_deg: Annotated[float, Field(gt=0, le=360)] = 360.0  # over which they spread; the rest of a turn is dead
    centre: int  # counts at the middle of the range: 0 rad

    @property
    def radians_per_tick(self) -> float:
        """The angle of one count."""
        return math.radians(self.span_deg) / self.ticks

    @property
    def range_deg(self) -> tuple[float, float]:
        """The angles of the first and the last count, from the centre."""
        degrees = self.span_deg / self.ticks
        return -self.centre * degrees, (self.ticks - 1 - self.centre) * degrees


def by_address(registers: tuple[Register, ...]) -> tuple[Register, ...]:
    """Return registers in the order of their addresses."""
    return tuple(sorted(registers, key=lambda register: register.address))


def overlaps(ordered: tuple[Register, ...]) -> Iterator[tuple[Register, Register]]:
    """Yield neighbours, in the order of their addresses, that share bytes."""
    return ((before, after) for before, after in itertools.pairwise(ordered) if before.end > after.address)
