"""The schema of a robot's `safety` section: when its watchers act. All of it has defaults."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from robotwalk.config.section import Positive, Section

_BelowOne = Annotated[float, Field(gt=0, lt=1)]
_AboveOne = Annotated[float, Field(gt=1, le=2)]


class StaleConfig(Section):
    """What is done about a joint that does not answer: it goes on by its goals, then holds, then the robot sits."""

    hold_after_s: Positive = 0.2  # as long as servos with a watchdog of their own go on
    sit_after_s: Positive = 0.5

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.hold_after_s >= self.sit_after_s:
            raise ValueError("hold_after_s should be below sit_after_s")
        return self


class GovernorConfig(Section):
    """How near to its servos' own limits, as shares of them, the robot eases its walk, and sits down."""

    heat_ease: _BelowOne = 0.85
    heat_sit: _BelowOne = 0.95
    voltage_ease: _AboveOne = 1.10  # of the lowest voltage
    voltage_sit: _AboveOne = 1.04
    # Of the largest current, the root mean square of about so many seconds. Assumed: half of what an STS3215 draws at
    # stall, 0.4 of its limit; no random walk of a bundled robot came to it, and a joint held fast does in 2 s.
    current_ease: _BelowOne = 0.4
    current_over_s: Positive = 4.0
    pace: Annotated[float, Field(gt=0, le=1)] = 0.5  # of the commanded speed, while it is eased
    lower: bool = True  # to its lowest height for walking, while it is eased

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.heat_ease >= self.heat_sit:
            raise ValueError("heat_ease should be below heat_sit")
        if self.voltage_ease <= self.voltage_sit:
            raise ValueError("voltage_ease should be above voltage_sit")
        return self


class RecoveryConfig(Section):
    """How servos that have let go are brought back: the robot lies down for that, and gets up again."""

    tries: Annotated[int, Field(ge=0, le=100)] = 3  # with any one servo; 0: it sits down and stays there
    forget_after_s: Positive = 600.0  # a try
    walk_on_with_legs: Annotated[int, Field(ge=5)] | None = 5  # so many left; None: never without one of them


class DriverConfig(Section):
    """What is done about a driver of whom nothing is heard: the robot slows to a stand, then it sits."""

    slow_after_s: Positive = 0.5
    sit_after_s: Positive = 10.0

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.slow_after_s >= self.sit_after_s:
            raise ValueError("slow_after_s should be below sit_after_s")
        return self


class OverrunsConfig(Section):
    """What is done about a computer that keeps no time, by the share of its last ticks that were left out."""

    window_s: Annotated[float, Field(ge=0.1, le=60)] = 2.0
    slow_share: Annotated[float, Field(gt=0, le=1)] = 0.2
    sit_share: Annotated[float, Field(gt=0, le=1)] = 0.5
    pace: Annotated[float, Field(gt=0, le=1)] = 0.5  # of the commanded speed, while it is slowed

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.slow_share >= self.sit_share:
            raise ValueError("slow_share should be below sit_share")
        return self


class FallConfig(Section):
    """When the robot is taken to have fallen."""

    tilt_deg: Annotated[float, Field(gt=10, le=90)] = 45.0  # off level, by an IMU
    # Of the weight of all but the legs, that their motors should push up, without an IMU; 0: never. Robots that stood
    # were below 0.5 for 0.2 s at the most, and 0.5 s below this is a fall (docs/safety.md).
    least_share: Annotated[float, Field(ge=0, lt=1)] = 0.3


class SafetyConfig(Section):
    """All of it."""

    stale: StaleConfig = StaleConfig()
    governor: GovernorConfig = GovernorConfig()
    recovery: RecoveryConfig = RecoveryConfig()
    driver: DriverConfig = DriverConfig()
    overruns: OverrunsConfig = OverrunsConfig()
    fall: FallConfig = FallConfig()
