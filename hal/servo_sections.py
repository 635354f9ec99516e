"""The sections of a servo's file, all but its registers, its motor and its firmware's switches."""

import math
from collections.abc import Collection
from typing import Annotated

from pydantic import Field

from hal.register import Register
from hal.schema import Row


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


class ProtectionLimits(Row):
    """The registers that say where a servo's own protections act; None: there is no such protection, or register."""

    hottest: str | None = None
    lowest_voltage: str | None = None
    highest_voltage: str | None = None
    largest_current: str | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Those that there are."""
        everything = (self.hottest, self.lowest_voltage, self.highest_voltage, self.largest_current)
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
    limits: ProtectionLimits = ProtectionLimits()


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
    # Faults after which a restart, or torque off and on, may follow unasked, as the error's flags say. Of a servo that
    # has no such register nothing is known: it may have been overloaded, and if it was not, its fault will stay.
    restart_clears: tuple[str, ...] = ()
    torque_clears: tuple[str, ...] = ()
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
