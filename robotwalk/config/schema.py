"""The schema of `configs/robots` and `configs/gaits`, all but a robot's `hardware` section, which is `hal`'s.

A unit is part of a key's name. Values stay here as the file has them; `robotwalk.model` turns them into SI.
"""

import itertools
import math
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from robotwalk.config.safety import SafetyConfig
from robotwalk.config.section import Positive as Positive
from robotwalk.config.section import Section as Section

Triple = tuple[float, float, float]


def _ascending(pair: tuple[float, float]) -> tuple[float, float]:
    if pair[0] >= pair[1]:
        raise ValueError("should be [low, high] with low below high")
    return pair


Range = Annotated[tuple[float, float], AfterValidator(_ascending)]


class BodyConfig(Section):
    """The rigid body."""

    box_mm: tuple[Positive, Positive, Positive]
    mass_g: Positive


class FootConfig(Section):
    """The ball at the end of each leg."""

    radius_mm: Positive
    mass_g: Positive


class JointConfig(Section):
    """A revolute joint and the link behind it."""

    axis: Literal["yaw", "pitch", "roll"]
    link_mm: Triple
    mass_g: Positive
    radius_mm: Positive
    rest_deg: float
    limits_deg: Range  # relative to rest


class LegConfig(Section):
    """A serial chain on the body; joints in order from the body to the foot."""

    mount_mm: Triple
    yaw_deg: float
    joints: Annotated[dict[str, JointConfig], Field(min_length=1)]


class SkeletonConfig(Section):
    """What the robot is made of, whatever moves it."""

    body: BodyConfig
    foot: FootConfig
    legs: Annotated[dict[str, LegConfig], Field(min_length=3)]


class HeightConfig(Section):
    """Heights of the base's origin above the ground."""

    sit: Positive
    stand: Positive
    lowest: Positive
    highest: Positive


PathPointConfig = tuple[float, float]
BezierPiece = tuple[PathPointConfig, PathPointConfig, PathPointConfig, PathPointConfig]
_SAME_DIRECTION = 1e-3  # rad


def _spliced(pieces: list[BezierPiece], start: PathPointConfig, end: PathPointConfig) -> list[BezierPiece]:
    if pieces[0][0] != start or pieces[-1][3] != end:
        raise ValueError(f"should lead from {list(start)} to {list(end)}")
    for number, ((_, _, c, d), (a, b, _, _)) in enumerate(itertools.pairwise(pieces), start=1):
        if a != d:
            raise ValueError(f"piece {number + 1} should begin at {list(d)}, where piece {number} ends")
        before, after = (d[0] - c[0], d[1] - c[1]), (b[0] - a[0], b[1] - a[1])
        cross, dot = before[0] * after[1] - before[1] * after[0], before[0] * after[0] + before[1] * after[1]
        if dot <= 0.0 or abs(math.atan2(cross, dot)) > _SAME_DIRECTION:
            raise ValueError(
                f"piece {number + 1} should go on in the direction in which piece {number} ends: the control points on "
                f"both sides of {list(d)} in one line with it, none of them there")
    return pieces


class BezierConfig(Section):
    """A foot's path of cubic Bezier pieces, each of four control points [way, height].

    The way is a share of the step; heights are shares of each other: the highest becomes the leg's lift.
    """

    bezier: Annotated[
        list[BezierPiece], Field(min_length=1), AfterValidator(lambda p: _spliced(p, (0.0, 0.0), (1.0, 0.0)))]
    retraction: Annotated[
        list[BezierPiece], Field(min_length=1), AfterValidator(lambda p: _spliced(p, (1.0, 0.0), (0.0, 0.0)))
    ] | None = None

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if max(point[1] for piece in self.bezier for point in piece) <= 0.0:
            raise ValueError("should rise above the ground")
        return self


def _swing_path_kind(value: object) -> str:
    return "BezierConfig" if isinstance(value, (dict, BezierConfig)) else "named"


SwingPathConfig = Annotated[
    Annotated[Literal["parabola", "half_ellipse", "ellipse"], Tag("named")]
    | Annotated[BezierConfig, Tag("BezierConfig")], Discriminator(_swing_path_kind)]


class FootfallConfig(Section):
    """Where a foot rests, how far it may step, how high it is lifted."""

    rest_mm: tuple[float, float]  # from the mount, along its x and y
    max_stride_mm: Positive
    lift_mm: Positive
    swing_path: SwingPathConfig | None = None  # None: as the others


Solver = Literal["closed_form", "ccd"]


NotNegative = Annotated[float, Field(ge=0)]


class ReactionConfig(Section):
    """How the body answers to its feet. Each answer is off at a gain of 0."""

    height: NotNegative = 0.0  # share of the height that pseudo-physics gives (PPS section 4)
    weights: dict[str, Positive] = Field(default_factory=dict)  # of legs in it; those that are not named have 1
    bob: NotNegative = 0.0  # of the feet's mean height (LAYER)
    turn: NotNegative = 0.0  # of the angle that `turn_by` gives
    # The mean angle of the feet about the body (LAYER), or that between the sides, by which is forward (PARAM).
    turn_by: Literal["angles", "forward"] = "angles"
    damping_s: Positive = 0.15
    largest_bob_mm: Positive = 8.0
    largest_turn_deg: Positive = 5.0


class LevellingConfig(Section):
    """How the body is kept level, by an IMU or by the feet's loads (ARTH section 5.6)."""

    c1_per_s2: Annotated[float, Field(gt=0, le=100)] = 36.0  # angular acceleration per angle that it is off
    c2_per_s: Annotated[float, Field(gt=0, le=100)] = 12.0  # and its damping; 2 sqrt(c1) is critical
    limit_deg: Annotated[float, Field(gt=0, le=45)] = 12.0  # of the correction, in roll and in pitch
    by: Literal["imu", "load"] = "imu"  # load: how the weight lies on the feet, as `contact` feels it


class OrientationConfig(Section):
    """How the body follows the ground by its feet (ARTH section 5.6)."""

    mode: Literal["cheap", "full", "as_needed"] = "as_needed"  # by elevations, the vectors, or these on large changes
    c1_per_s2: Positive = 36.0  # rate of an angle's error
    c2_per_s: Positive = 10.0  # deceleration
    frontal_bias: Annotated[float, Field(ge=0)] = 0.0  # by how much more the front pair counts
    share: Annotated[float, Field(ge=0, le=1)] = 1.0  # of the feet's slope that the body takes on
    in_swing: bool = False  # follow feet in the air, too, not only as they touch down


class ContactConfig(Section):
    """What the feet do about the ground that they feel (ARTH sections 5.4-5.7 and 6)."""

    early_touchdown: bool = True  # a foot that is struck on its way down stands there
    step_over: bool = True  # a foot that is struck on its way steps higher
    reach_down_mm: Annotated[float, Field(ge=0)] = 60.0  # how far below the expected ground a foot feels for it
    search: bool = True  # and then around
    slip: bool = True  # a foot that loses its load steps anew
    caution_mm: Annotated[float, Field(ge=0, le=100)] = 25.0  # most that is added to lifts where ground surprised
    share_load: bool = False  # feet that bear less than is due press down, and no foot lifts off before the others bear
    sure_after_ms: Annotated[float, Field(ge=0, le=500)] = 0.0  # for how long a foot below must feel ground to stand
    up_to_mps: Positive | None = None  # of any foot over the ground; faster, it is felt too late. None: always
    gaits: list[str] | None = None  # in which all this is done, and the body levelled by load. None: all


class FeedForwardConfig(Section):
    """By what goals lead, so that joints arrive where and when they should."""

    lag: bool = True  # by the servo's damping, inertia and friction
    load: bool = True  # by what the joint bears, over the servo's stiffness


class LocomotionConfig(Section):
    """How the robot may move."""

    height_mm: HeightConfig
    max_speed_mps: Positive
    max_turn_deg_s: Positive
    acceleration_mps2: Positive
    turn_acceleration_deg_s2: Positive
    min_swing_s: Positive
    swing_path: SwingPathConfig
    solver: Solver | None = None  # of inverse kinematics; None: a closed form where there is one, else ccd
    levelling: LevellingConfig | None = None  # None: off; else the robot needs an IMU, or `contact`
    contact: ContactConfig | None = None  # None: it walks as if the ground were flat
    orientation: OrientationConfig | None = None  # None: the body stays level and at one height
    feed_forward: FeedForwardConfig = FeedForwardConfig()
    hold_course: bool = True  # turn against what odometry sees of turns that nobody asked for
    stability: bool = True  # tell how far the centre of mass is inside the standing feet; it moves nothing
    feet: dict[str, FootfallConfig]
    reaction: ReactionConfig = ReactionConfig()


class RobotConfig(Section):
    """One file of `configs/robots`."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    name: str
    description: str
    modelled_on: str = ""
    skeleton: SkeletonConfig
    locomotion: LocomotionConfig
    safety: SafetyConfig = SafetyConfig()
    hardware: dict[str, Any]


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
