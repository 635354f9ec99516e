"""From a gait's file to the sectors of one robot's feet: given foot by foot, or by formula."""

from collections.abc import Sequence

from robotwalk.config.document import Document
from robotwalk.config.gait_schema import (
    GAIT_KINDS,
    AnyGaitConfig,
    GaitConfig,
    OffsetsConfig,
    OscillatorConfig,
    SteppingConfig,
    TimingConfig,
    WaveConfig,
)
from robotwalk.free_stepping import circles
from robotwalk.model import Leg
from robotwalk.oscillator import swing_share

_MIDDLE = 1e-3  # m from the robot's middle line to the side that a foot is on

Swing = dict[str, list[tuple[float, float]]]


def read_gait(document: Document) -> AnyGaitConfig:
    """Validate a gait's file by what its `kind` says; without one it gives sectors.

    Raises:
        ConfigError: it is wrong.
    """
    content = document.value(())
    kind = content.get("kind") if isinstance(content, dict) else None
    if kind is not None and kind not in GAIT_KINDS:
        raise document.error(("kind",), f"expected one of {', '.join(GAIT_KINDS)}", kind)
    return document.validate(GAIT_KINDS["sectors" if kind is None else kind])


def fitted(config: AnyGaitConfig, legs: Sequence[Leg]) -> GaitConfig | None:
    """Return a gait as sectors for these legs; None if it is not for them."""
    if isinstance(config, GaitConfig):
        return config if set(config.swing) == {leg.name for leg in legs} else None
    if isinstance(config, SteppingConfig):
        grouped = {leg for group in config.groups for leg in group}
        return circles(config) if grouped == {leg.name for leg in legs} else None
    if isinstance(config, WaveConfig):
        if not config.legs[0] <= len(legs) <= config.legs[1]:
            return None
        swing = wave(legs, config.pause)
    else:
        share = config.swing if isinstance(config, OffsetsConfig) else swing_share(config.bias)
        pairs = in_pairs(legs)
        if pairs is None or 2 * len(pairs) != config.legs:
            return None
        swing = by_offsets(pairs, config.front_back, config.left_right, share)
    common = config.model_dump(by_alias=True, include=set(TimingConfig.model_fields))
    bias = config.bias if isinstance(config, OscillatorConfig) else None
    return GaitConfig.model_validate(common | {"swing": swing, "bias": bias})


def wave(legs: Sequence[Leg], pause: float) -> Swing:
    """Return the sectors of a wave: one foot after the other, rear to front, first left then right.

    Args:
        legs: in any order; feet on the middle line count to the left.
        pause: turns after each side in which all feet stand.
    """
    order = sorted(legs, key=lambda leg: (leg.rest_foot.y < -_MIDDLE, leg.rest_foot.x))
    share = (1.0 - 2.0 * pause) / len(order)
    swing: Swing = {}
    for place, leg in enumerate(order):
        start = place * share + (pause if leg.rest_foot.y < -_MIDDLE else 0.0)
        swing[leg.name] = [(start, start + share)]
    return swing


def by_offsets(
    pairs: Sequence[tuple[Leg, Leg]], front_back: float, left_right: float, share: float
) -> Swing:
    """Return the sectors of pairs, from front to rear, (PARAM, leg phase differences); the left front foot's is at 0.

    Args:
        pairs: the left and the right leg of each.
        front_back: turns by which a pair swings later than the one ahead of it.
        left_right: turns by which a right foot swings later than its left one.
        share: turns that each foot swings.
    """
    swing: Swing = {}
    for row, pair in enumerate(pairs):
        for side, leg in enumerate(pair):
            start = _in_turn(row * front_back + side * left_right)
            swing[leg.name] = [(start, start + share)]
    return swing


def in_pairs(legs: Sequence[Leg]) -> list[tuple[Leg, Leg]] | None:
    """Return the (left, right) legs from front to rear; None if there is not one right foot to each left one."""
    ahead = sorted(legs, key=lambda leg: -leg.rest_foot.x)
    left = [leg for leg in ahead if leg.rest_foot.y > _MIDDLE]
    right = [leg for leg in ahead if leg.rest_foot.y < -_MIDDLE]
    if len(left) != len(right) or len(left) + len(right) != len(ahead):
        return None
    return list(zip(left, right, strict=True))


def _in_turn(turns: float) -> float:
    """Return an angle on the circle, 0 where it is a whole turn but for rounding."""
    rest = round(turns, 9) % 1.0
    return rest if rest < 1.0 else 0.0


