"""The schema of `configs/gaits`. As in a robot's file, a unit is part of a key's name."""

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from robotwalk.config.section import Positive, Section

Share = Annotated[float, Field(gt=0, lt=1)]
Bias = Annotated[float, Field(ge=-5, le=5)]
Sector = tuple[Annotated[float, Field(ge=0, lt=1)], Annotated[float, Field(gt=0, lt=2)]]


class BalanceConfig(Section):
    """How the body is shifted over the feet that stand, for gaits that would tip the robot otherwise."""

    margin_mm: Positive  # of the centre of mass to the edge of their polygon
    acceleration_mps2: Positive  # of the shift; lift-offs wait for its end


class TimingConfig(Section):
    """What all files of `configs/gaits` have in common, whatever tells their feet's sectors."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    name: str
    description: str
    slowest_period_s: Positive
    fastest_period_s: Positive | None = None  # None: as fast as the feet can swing
    stride_share: Annotated[float, Field(gt=0, le=1)] = 1.0  # of each leg's largest stride, that the gait may take
    sideways_mps: Positive | None = None  # the fastest that the body may go to a side; None: as ahead
    askew_mps: Positive | None = None  # the fastest that a foot may pass over the ground but ahead; None: as ahead
    sideways_mps2: Positive | None = None  # the most that the body may speed up to a side; None: as ahead
    balance: BalanceConfig | None = None  # None: the body keeps to its course
    rocking: Annotated[float, Field(ge=0, le=1)] = 0.0  # share of what would keep the body from tipping; 0: none


class GaitConfig(TimingConfig):
    """The swing sectors of each foot's circle, in turns, foot by foot (PPS section 3)."""

    kind: Literal["sectors"] = "sectors"
    bias: Bias | None = None  # of the skewed waves that the feet swing by (PARAM); None: by the robot's swing path
    swing: Annotated[dict[str, Annotated[list[Sector], Field(min_length=1)]], Field(min_length=3)]


def _not_falling(pair: tuple[int, int]) -> tuple[int, int]:
    if pair[0] > pair[1]:
        raise ValueError("should be [fewest, most]")
    return pair


LegCounts = Annotated[tuple[Annotated[int, Field(ge=3)], int], AfterValidator(_not_falling)]


class WaveConfig(TimingConfig):
    """One foot at a time, for any number of feet: on each side from rear to front, first left then right."""

    kind: Literal["wave"]
    legs: LegCounts = (3, 99)
    pause: Annotated[float, Field(ge=0, lt=0.5)] = 0.0  # turns after each side in which all feet stand


class OffsetsConfig(TimingConfig):
    """Feet in pairs, one left and one right, by two phase offsets that add up (PARAM, leg phase differences)."""

    kind: Literal["offsets"]
    legs: Annotated[int, Field(ge=4, multiple_of=2)]
    front_back: float  # turns by which a pair swings later than the pair ahead of it
    left_right: float  # turns by which a right foot swings later than its left one
    swing: Share  # of the circle


class OscillatorConfig(TimingConfig):
    """Feet in pairs that rise and fall with a skewed wave (PARAM, swing-stance ratio)."""

    kind: Literal["oscillator"]
    legs: Annotated[int, Field(ge=4, multiple_of=2)]
    front_back: float  # as in OffsetsConfig
    left_right: float
    bias: Bias  # over 0 the stance is longer than the swing, below 0 shorter


def _spanning(curve: list[tuple[float, float]]) -> list[tuple[float, float]]:
    places = [place for place, _ in curve]
    if places[0] != -1.0 or places[-1] != 1.0 or places != sorted(set(places)):
        raise ValueError("should go from -1, straight back, to 1, straight ahead")
    return curve


Offset = tuple[float, Annotated[float, Field(gt=0, le=0.5)]]
OffsetCurve = Annotated[list[Offset], Field(min_length=2), AfterValidator(_spanning)]
_FARTHEST = 0.55  # of its largest stride that a foot may be from rest


class SteppingConfig(TimingConfig):
    """Feet that step when they have come too far from rest, group by group, without a clock (LAYER, leg groups).

    An offset curve gives a share of the leg's largest stride over the cosine of the angle to straight ahead.
    """

    kind: Literal["stepping"]
    # Of legs that may be in the air at once.
    groups: Annotated[list[Annotated[list[str], Field(min_length=1)]], Field(min_length=2)]
    allowed: OffsetCurve  # from rest before a foot wants to step
    allowed_of: dict[str, OffsetCurve] = Field(default_factory=dict)  # for legs of which it differs
    overshoot: Annotated[float, Field(gt=0, le=1)]  # of what is allowed that way, beyond rest
    largest_angle_deg: Positive  # about the body's middle, from rest
    escape: Annotated[float, Field(gt=1)]  # times what is allowed: from there on a foot steps out of turn

    @model_validator(mode="after")
    def _sound(self) -> Self:
        legs = [leg for group in self.groups for leg in group]
        if twice := {leg for leg in legs if legs.count(leg) > 1}:
            raise ValueError(f"each leg should be in one group, not {', '.join(sorted(twice))} in several")
        if strangers := set(self.allowed_of) - set(legs):
            raise ValueError(f"allowed_of names legs that are in no group: {', '.join(sorted(strangers))}")
        farthest = self.escape * max(share for curve in (self.allowed, *self.allowed_of.values()) for _, share in curve)
        if farthest > _FARTHEST:
            raise ValueError(f"escape times what is allowed should be {_FARTHEST} strides at most, not {farthest:.3g}")
        if self.balance is not None or self.rocking > 0.0:
            raise ValueError("a body is shifted and rocked by a clock: neither balance nor rocking is for stepping")
        return self


AnyGaitConfig = GaitConfig | WaveConfig | OffsetsConfig | OscillatorConfig | SteppingConfig
GAIT_KINDS: dict[str, type[AnyGaitConfig]] = {
    "sectors": GaitConfig, "wave": WaveConfig, "offsets": OffsetsConfig, "oscillator": OscillatorConfig,
    "stepping": SteppingConfig}
