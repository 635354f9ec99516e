"""The schema of `configs/robots`, all but a robot's `hardware` section, which is `hal`'s.

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
    """How the body is kept level, by an IMU (ARTH section 5.6)."""

    c1_per_s2: Annotated[float, Field(gt=0, le=100)] = 36.0  # angular acceleration per angle that it is off
    c2_per_s: Annotated[float, Field(gt=0, le=100)] = 12.0  # and its damping; 2 sqrt(c1) is critical
    limit_deg: Annotated[float, Field(gt=0, le=45)] = 12.0  # of the correction, in roll and in pitch


class OrientationConfig(Section):
    """How the body follows the ground by its feet (ARTH section 5.6)."""

    mode: Literal["cheap", "full", "as_needed"] = "as_needed"  # by elevations, the vectors, or these on large changes
    c1_per_s2: Positive = 36.0  # rate of an angle's error
    c2_per_s: Positive = 10.0  # deceleration
    frontal_bias: Annotated[float, Field(ge=0)] = 0.0  # by how much more the front pair counts
    share: Annotated[float, Field(ge=0, le=1)] = 1.0  # of the feet's slope that the body takes on
    in_swing: bool = False  # follow feet in the air, too, not only as they touch down
    plumb: bool = True  # keep odom upright by what the feet feel, or by an IMU


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
    gaits: list[str] | None = None  # in which all this is done. None: all
    wait_for_footing: bool = True  # no foot lifts off while another one, just set down, bears nothing
    out_of_turn: bool = True  # a foot that missed its turn, and so holds the body fast, steps out of it
    # The estimator of loads, fitted to a robot: how long after joints are read the next goals reach their servos, in
    # ticks, 0.5 being none the wiser; and the speed of a joint below which its friction is known in part only.
    goals_after: Annotated[float, Field(ge=0, le=1)] = 0.5
    creep_rad_s: Positive = 0.1


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
    stance_reflex: bool = True  # while the robot stands, a leg that is out of its place steps back to rest
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
