"""A servo model as data: the schema of `configs/servos/*.yaml`.

Registers, units and data-sheet figures. What is done with them lies elsewhere: encoding in `hal.encoding`,
a servo's behaviour in `sim_backend`.
"""

import itertools
import math
from collections.abc import Collection, Iterator, Mapping, ValuesView
from enum import StrEnum
from functools import cached_property
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import AfterValidator, Field, field_validator, model_validator

from hal.firmware_switches import AxFirmware as AxFirmware
from hal.firmware_switches import DynamixelFirmware as DynamixelFirmware
from hal.firmware_switches import FeetechFirmware as FeetechFirmware
from hal.firmware_switches import ScsFirmware as ScsFirmware
from hal.firmware_switches import StsFirmware as StsFirmware
from hal.motor import Motor as Motor
from hal.schema import Row as Row

_SI_UNITS = {
    "rpm": 2.0 * math.pi / 60.0, "rev/s": 2.0 * math.pi, "rev/min^2": 2.0 * math.pi / 3600.0,
    "us": 1e-6, "ms": 1e-3, "%": 1e-2, "mA": 1e-3,
}


ByteOrder = Literal["little", "big"]
ProtocolName = Literal["dynamixel-2.0", "dynamixel-1.0", "feetech-sts", "feetech-scs"]
_FRAMES = {"feetech-sts": "feetech", "feetech-scs": "feetech"}  # of the protocols that share them


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


def _by_address(registers: tuple[Register, ...]) -> tuple[Register, ...]:
    return tuple(sorted(registers, key=lambda register: register.address))


def _overlaps(by_address: tuple[Register, ...]) -> Iterator[tuple[Register, Register]]:
    return ((before, after) for before, after in itertools.pairwise(by_address) if before.end > after.address)


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


class Telemetry(Row):
    """The registers that tell a servo's condition: read in turn, in the wire time that is left."""

    torque: str  # 0 where the servo has let go: on its own, or in a restart that nobody noticed
    error: str | None  # whose `flags` name what is wrong; None: the error byte of each answer is all there is
    voltage: str
    temperature: str
    current: str | None = None  # None: not measured

    @property
    def names(self) -> tuple[str, ...]:
        """Those that there are."""
        everything = (self.torque, self.error, self.voltage, self.temperature, self.current)
        return tuple(name for name in everything if name is not None)


class Cyclic(Row):
    """The registers of the exchange in every tick."""

    goal: str
    effort: str
    effort_full_scale: Annotated[int, Field(gt=0)]  # counts at the servo's largest output
    velocity: str
    position: str
    torque_cap: str  # the register that bounds the output, for a gentle start
    telemetry: Telemetry


class BusWatchdog(Row):
    """What stops a servo that hears nothing any more; armed last, fed by the cycle, off in every pause."""

    name: str  # of its register. 0 disarms it; another value than was written: it has tripped
    time_ms: Annotated[float, Field(gt=0)]  # without any instruction on the wire


class Arming(Row):
    """What a servo must be set to before its torque comes on, in counts by register."""

    require: Annotated[dict[str, int], Field(default_factory=dict)]  # kept without power: not ours to change unasked
    set: Annotated[dict[str, int], Field(default_factory=dict)]  # forgotten without power: written where they differ
    explain: Annotated[dict[str, int], Field(default_factory=dict)]  # worth a word where they differ
    position_limits: tuple[str, str]  # between which a joint's whole range must lie
    restart_clears: tuple[str, ...] = ()  # faults after which a restart may follow unasked, as the error's flags say
    watchdog: BusWatchdog | None = None  # None: the servo has none, and keeps on by itself

    def among(self, names: Collection[str]) -> "Arming":
        """Return what of it concerns these registers."""
        def kept(counts: dict[str, int]) -> dict[str, int]:
            return {name: count for name, count in counts.items() if name in names}

        watchdog = self.watchdog if self.watchdog is not None and self.watchdog.name in names else None
        return self.model_copy(update={
            "require": kept(self.require), "set": kept(self.set), "explain": kept(self.explain), "watchdog": watchdog})


class OperatingPoint(Row):
    """The data sheet's figures at one supply voltage."""

    voltage_v: Annotated[float, Field(gt=0)]
    stall_torque_nm: Annotated[float, Field(gt=0)]
    stall_current_a: Annotated[float, Field(gt=0)] | None = None  # not every data sheet has it
    no_load_rpm: Annotated[float, Field(gt=0)]

    @property
    def no_load_speed(self) -> float:
        """Speed without load, rad/s."""
        return self.no_load_rpm * 2.0 * math.pi / 60.0


class Specification(Row):
    """The data sheet."""

    source: str
    rated: OperatingPoint
    others: tuple[OperatingPoint, ...] = ()
    mass_g: Annotated[float, Field(gt=0)]
    gear_ratio: Annotated[float, Field(gt=0)]


class PositionLoop(Row):
    """The firmware's position controller: duty = gain register / divisor x error in ticks / full-scale PWM."""

    proportional: str  # name of the gain's register
    divisor: Annotated[float, Field(gt=0)]
    pwm_full_scale: Annotated[int, Field(gt=0)]  # counts of the PWM registers at 100 % duty

    def duty_per_tick(self, counts: float) -> float:
        """Return how steeply the duty grows with the error, for counts of the gain's register."""
        return counts / self.divisor / self.pwm_full_scale


class ComplianceLoop(Row):
    """A position controller that is told its compliance: duty = punch + (error in ticks - margin) / slope.

    Within the margin it does nothing.
    """

    proportional: Annotated[str, Field(alias="slope")]  # name of the register that holds the slope, in ticks
    pwm_full_scale: Annotated[int, Field(gt=0)]  # counts of the punch and of the torque limits at 100 % duty

    def duty_per_tick(self, counts: float) -> float:
        """Return how steeply the duty grows with the error, for counts of the slope's register."""
        return 1.0 / counts


class OlderFirmware(Row):
    """What the control table was before some version of the firmware."""

    below: Annotated[int, Field(ge=0, le=255)]
    registers: tuple[Register, ...] = ()  # in place of those of their names, or more
    absent: tuple[str, ...] = ()  # registers that were not there yet


class ServoModel(Row):
    """One file of `configs/servos`, with what it is based on (`robotwalk.config.inheritance`)."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    name: str
    description: str
    protocol: ProtocolName
    byte_order: ByteOrder = "little"
    model_number: int
    sync_read: bool = True  # whether one instruction can read many of these servos
    fast_sync_read_firmware: int | None  # the first firmware that has it, and the fast bulk read; None: none has
    backup_firmware: int | None = None  # the first firmware that keeps a copy of its control table; None: none does
    baud_by_value: Annotated[Mapping[int, int], Field(alias="baud_rates", min_length=1)]  # of the baud_rate register
    encoder: Encoder
    cyclic: Cyclic
    arming: Arming
    specification: Specification
    motor: Motor
    position_loop: PositionLoop | ComplianceLoop
    firmware: Annotated[DynamixelFirmware | AxFirmware | StsFirmware | ScsFirmware, Field(discriminator="kind")]
    registers: Annotated[tuple[Register, ...], AfterValidator(_by_address)]
    older_firmware: tuple[OlderFirmware, ...] = ()

    @cached_property
    def by_name(self) -> dict[str, Register]:
        """The rows by their names."""
        return {register.name: register for register in self.registers}

    @property
    def frames(self) -> str:
        """What is spoken on its wire: servos of one brand's frames may share it, whatever their registers."""
        return _FRAMES.get(self.protocol, self.protocol)

    @cached_property
    def feedback(self) -> "Block":
        """The registers read in every tick."""
        names = (self.cyclic.effort, self.cyclic.velocity, self.cyclic.position)
        return Block(tuple(sorted((self[name] for name in names), key=lambda register: register.address)))

    @property
    def lock(self) -> Register | None:
        """The register that must be 0 for the EEPROM to keep what is written; None: it always does."""
        return self.by_name.get("lock")

    @cached_property
    def watchdog(self) -> tuple[Register, int] | None:
        """The bus watchdog's register, and the counts that arm it; None if there is none."""
        if self.arming.watchdog is None:
            return None
        register = self[self.arming.watchdog.name]
        return register, round(self.arming.watchdog.time_ms / register.scale)

    @cached_property
    def condition(self) -> tuple[str, ...]:
        """The registers that are read in turn: the telemetry, and whether the bus watchdog has tripped."""
        watchdog = self.arming.watchdog
        return self.cyclic.telemetry.names + (() if watchdog is None else (watchdog.name,))

    def __getitem__(self, name: str) -> Register:
        return self.by_name[name]

    def at_firmware(self, version: int) -> "ServoModel":
        """Return the model with the registers that it has at a version of its firmware."""
        if all(version >= older.below for older in self.older_firmware):
            return self
        rows = self._registers_at(version)
        fields = {field.alias or name: getattr(self, name) for name, field in type(self).model_fields.items()}
        arming = self.arming.among({row.name for row in rows})
        return ServoModel.model_validate({**fields, "arming": arming, "registers": rows, "older_firmware": ()})

    def _registers_at(self, version: int) -> tuple[Register, ...]:
        rows = dict(self.by_name)
        for older in sorted(self.older_firmware, key=lambda older: -older.below):
            if version < older.below:
                rows |= {register.name: register for register in older.registers}
                for name in older.absent:
                    rows.pop(name, None)
        return _by_address(tuple(rows.values()))

    @property
    def baud_rates(self) -> ValuesView[int]:
        """All that it has."""
        return dict(self.baud_by_value).values()

    def baud_value(self, baud: int) -> int:
        """Return what the baud_rate register holds for a baud rate. Raises ValueError if the servo has not got it."""
        for value, rate in self.baud_by_value.items():
            if rate == baud:
                return value
        raise ValueError(f"{self.name} does not have {baud} baud; it has {', '.join(map(str, self.baud_rates))}")

    @field_validator("baud_by_value", mode="before")
    @classmethod
    def _number_bauds(cls, bauds: Any) -> Any:
        """Let a plain list count from 0."""
        return dict(enumerate(bauds)) if isinstance(bauds, list) else bauds

    @model_validator(mode="before")
    @classmethod
    def _spread_byte_order(cls, data: Any) -> Any:
        """Tell every register the model's byte order."""
        if not isinstance(data, dict) or data.get("byte_order") != "big":
            return data
        rows = [{**row, "byte_order": "big"} if isinstance(row, dict) else row for row in data.get("registers", ())]
        return {**data, "registers": rows}

    @model_validator(mode="after")
    def _check_rows(self) -> "ServoModel":
        problems = list(self._row_problems())
        if problems:
            raise ValueError("; ".join(problems))
        return self

    def _row_problems(self) -> Iterator[str]:
        if len(self.by_name) != len(self.registers):
            names = [register.name for register in self.registers]
            yield f"register names must be unique: {sorted({n for n in names if names.count(n) > 1})}"
        for before, after in _overlaps(self.registers):
            yield f"registers {before.name} and {after.name} overlap at address {after.address}"
        for older in self.older_firmware:
            for before, after in _overlaps(self._registers_at(older.below - 1)):
                yield (
                    f"below firmware {older.below}, registers {before.name} and {after.name} overlap at "
                    f"address {after.address}")
        cyclic = self.cyclic
        needed = (
            cyclic.goal, cyclic.effort, cyclic.velocity, cyclic.position, cyclic.torque_cap,
            self.position_loop.proportional, *self.condition, *self.arming.require, *self.arming.set,
            *self.arming.explain, *self.arming.position_limits)
        for name in needed:
            if name not in self.by_name:
                yield f"no register is named {name!r}"
        yield from self._watchdog_problems()

    def _watchdog_problems(self) -> Iterator[str]:
        wanted = self.arming.watchdog
        register = self.by_name.get(wanted.name) if wanted is not None else None
        if wanted is None or register is None:
            return
        _, most = register.range or (0, 0)
        if register.unit != "ms" or not 1 <= wanted.time_ms / register.scale <= most or wanted.time_ms % register.scale:
            yield (
                f"arming.watchdog.time_ms: {register.name} takes multiples of {register.scale:g} {register.unit} up to "
                f"{most * register.scale:g}, not {wanted.time_ms:g} ms")
