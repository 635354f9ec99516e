"""How a robot's locomotion is set: its file's sections, in SI units and radians."""

import math
from collections.abc import Iterable
from typing import Literal, NamedTuple, Self

from robotwalk.config.schema import (
    ContactConfig,
    HeightConfig,
    LevellingConfig,
    LocomotionConfig,
    OrientationConfig,
    ReactionConfig,
)


class Heights(NamedTuple):
    """Heights of the base's origin above the ground, m."""

    sit: float
    stand: float
    lowest: float
    highest: float

    @classmethod
    def from_config(cls, config: HeightConfig) -> Self:
        """Convert a file's section to SI units."""
        return cls(
            _metres(config.sit), _metres(config.stand), _metres(config.lowest), _metres(config.highest))


class MotionLimits(NamedTuple):
    """How fast the body may go."""

    speed: float  # m/s
    turn: float  # rad/s
    acceleration: float  # m/s^2
    turn_acceleration: float  # rad/s^2
    min_swing: float  # s

    @classmethod
    def from_config(cls, config: LocomotionConfig) -> Self:
        """Convert a file's section to SI units."""
        return cls(
            speed=config.max_speed_mps,
            turn=math.radians(config.max_turn_deg_s),
            acceleration=config.acceleration_mps2,
            turn_acceleration=math.radians(config.turn_acceleration_deg_s2),
            min_swing=config.min_swing_s,
        )


class LevellingSettings(NamedTuple):
    """How the body is kept level; see `LevellingConfig`."""

    c1: float  # 1/s^2
    c2: float  # 1/s
    limit: float  # rad

    @classmethod
    def from_config(cls, config: LevellingConfig) -> Self:
        """Convert a file's section to SI units."""
        return cls(config.c1_per_s2, config.c2_per_s, math.radians(config.limit_deg))


class Reactions(NamedTuple):
    """How the body answers to its feet; gains without unit."""

    height: float
    weights: tuple[float, ...]  # of the legs, adding up to 1
    bob: float
    turn: float
    turn_by: Literal["angles", "forward"]
    damping: float  # s
    largest_bob: float  # m
    largest_turn: float  # rad

    @classmethod
    def from_config(cls, config: ReactionConfig, legs: Iterable[str]) -> Self:
        """Convert a file's section to SI units, for legs in their order."""
        weights = [config.weights.get(leg, 1.0) for leg in legs]
        return cls(
            config.height, tuple(weight / sum(weights) for weight in weights), config.bob, config.turn, config.turn_by,
            config.damping_s, _metres(config.largest_bob_mm), math.radians(config.largest_turn_deg))

    @property
    def off(self) -> bool:
        """Tell whether the body does not answer at all."""
        return self.height == self.bob == self.turn == 0.0


class ContactSettings(NamedTuple):
    """What the feet do about the ground that they feel; see `ContactConfig`."""

    early_touchdown: bool
    step_over: bool
    reach_down: float  # m
    search: bool
    slip: bool
    caution: float  # m
    fastest: float  # m/s of any foot over the ground
    share_load: bool = False
    sure_after: float = 0.0  # s
    gaits: tuple[str, ...] | None = None  # None: all
    wait_for_footing: bool = True
    out_of_turn: bool = True
    goals_after: float = 0.5  # of a tick
    creep: float = 0.1  # rad/s

    @classmethod
    def from_config(cls, config: ContactConfig) -> Self:
        """Convert a file's section to SI units."""
        return cls(
            config.early_touchdown, config.step_over, _metres(config.reach_down_mm), config.search, config.slip,
            _metres(config.caution_mm), math.inf if config.up_to_mps is None else config.up_to_mps,
            config.share_load, 1e-3 * config.sure_after_ms, None if config.gaits is None else tuple(config.gaits),
            config.wait_for_footing, config.out_of_turn, config.goals_after, config.creep_rad_s)


class OrientationSettings(NamedTuple):
    """How the body follows the ground; see `OrientationConfig`."""

    mode: Literal["cheap", "full", "as_needed"]
    c1: float  # 1/s^2
    c2: float  # 1/s
    frontal_bias: float
    share: float
    in_swing: bool
    plumb: bool = True

    @classmethod
    def from_config(cls, config: OrientationConfig) -> Self:
        """Convert a file's section to SI units."""
        return cls(
            config.mode, config.c1_per_s2, config.c2_per_s, config.frontal_bias, config.share, config.in_swing,
            config.plumb)


class Leads(NamedTuple):
    """By what goals lead; see `FeedForwardConfig`."""

    lag: bool = True
    load: bool = True


def _metres(millimetres: float) -> float:
    return millimetres * 1e-3
