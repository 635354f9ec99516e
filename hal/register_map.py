"""A servo model as data: the schema of `configs/servos/*.yaml`.

Registers, units and data-sheet figures. What is done with them lies elsewhere: encoding in `hal.encoding`,
a servo's behaviour in `sim_backend`.
"""

from collections.abc import Iterator, Mapping, ValuesView
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, field_validator, model_validator

from hal.firmware_switches import AxFirmware as AxFirmware
from hal.firmware_switches import DynamixelFirmware as DynamixelFirmware
from hal.firmware_switches import FeetechFirmware as FeetechFirmware
from hal.firmware_switches import ScsFirmware as ScsFirmware
from hal.firmware_switches import StsFirmware as StsFirmware
from hal.motor import Motor as Motor
from hal.register import Access as Access
from hal.register import Block as Block
from hal.register import ByteOrder as ByteOrder
from hal.register import Encoder as Encoder
from hal.register import Memory as Memory
from hal.register import Register as Register
from hal.register import by_address, overlaps
from hal.schema import Row as Row
from hal.servo_sections import Arming as Arming
from hal.servo_sections import ComplianceLoop as ComplianceLoop
from hal.servo_sections import Cyclic as Cyclic
from hal.servo_sections import OlderFirmware as OlderFirmware
from hal.servo_sections import OperatingPoint as OperatingPoint
from hal.servo_sections import PositionLoop as PositionLoop
from hal.servo_sections import Specification as Specification

ProtocolName = Literal["dynamixel-2.0", "dynamixel-1.0", "feetech-sts", "feetech-scs"]
_FRAMES = {"feetech-sts": "feetech", "feetech-scs": "feetech"}  # of the protocols that share them


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
    registers: Annotated[tuple[Register, ...], AfterValidator(by_address)]
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
    def feedback(self) -> Block:
        """The registers read in every tick."""
        names = (self.cyclic.effort, self.cyclic.velocity, self.cyclic.position)
        return Block(tuple(sorted((self[name] for name in names), key=lambda register: register.address)))

    @property
    def effort_is_current(self) -> bool:
        """Whether its effort is a current, and so tells of torque whatever the supply; else it is a duty cycle."""
        return self[self.cyclic.effort].unit == "mA"

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
        return by_address(tuple(rows.values()))

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
        for before, after in overlaps(self.registers):
            yield f"registers {before.name} and {after.name} overlap at address {after.address}"
        for older in self.older_firmware:
            for before, after in overlaps(self._registers_at(older.below - 1)):
                yield (
                    f"below firmware {older.below}, registers {before.name} and {after.name} overlap at "
                    f"address {after.address}")
        cyclic = self.cyclic
        needed = (
            cyclic.goal, cyclic.effort, cyclic.velocity, cyclic.position, cyclic.torque_cap,
            self.position_loop.proportional, *self.condition, *cyclic.limits.names, *self.arming.require,
            *self.arming.set, *self.arming.explain, *self.arming.position_limits)
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
