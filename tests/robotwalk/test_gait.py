"""When feet swing, and how the period follows the speed."""

import math
from itertools import combinations

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from robotwalk.config.gait_schema import GaitConfig
from robotwalk.errors import UsageError
from robotwalk.gait import Gait, GaitClock
from robotwalk.gait_rules import wave
from robotwalk.model import RobotModel
from robotwalk.types import STILL, Twist

LF, LM, LR, RF, RM, RR = range(6)
MIN_SWING, STRIDE = 0.3, 0.1

twists = st.builds(Twist, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-3.0, 3.0))


def gait(model: RobotModel, slowest: float = 1.0, **swing: list[list[float]]) -> Gait:
    """Make a gait; feet not named swing in the first half."""
    circles = {leg.name: swing.get(leg.name, [[0.0, 0.5]]) for leg in model.legs}
    return Gait(GaitConfig.model_validate(
        {"schema": 1, "name": "own", "description": "", "slowest_period_s": slowest, "swing": circles}), model)


def swinging(gait: Gait, phase: float) -> set[int]:
    return {foot for foot in range(6) if gait.sector_at(foot, phase) is not None}


def test_tripods_alternate(gaits: dict[str, Gait]) -> None:
    tripod = gaits["tripod"]
    assert swinging(tripod, 0.0) == swinging(tripod, 0.499) == {LF, LR, RM}
    assert swinging(tripod, 0.5) == swinging(tripod, 0.999) == {LM, RF, RR}


def test_a_wave_runs_from_rear_to_front_one_foot_at_a_time(gaits: dict[str, Gait]) -> None:
    order = [swinging(gaits["wave"], (slot + 0.5) / 6) for slot in range(6)]
    assert order == [{LR}, {LM}, {LF}, {RR}, {RM}, {RF}]


def test_a_sector_may_run_past_the_top_of_the_circle(gaits: dict[str, Gait]) -> None:
    ripple = gaits["ripple"]
    assert ripple.sector_at(RM, 0.9) is not None
    assert ripple.sector_at(RM, 0.1) is not None
    assert ripple.sector_at(RM, 0.17) is None
    sector = ripple.sector_at(RM, 0.0)
    assert sector is not None
    assert sector.progress(0.0) == pytest.approx(0.5, abs=1e-5)
    assert sector.progress(0.5) >= 1.0


def test_which_feet_may_be_in_the_air_together(hexapod: RobotModel, gaits: dict[str, Gait]) -> None:
    legs = [leg.name for leg in hexapod.legs]

    def together(gait: str, *feet: str) -> bool:
        return gaits[gait].lifts_together({legs.index(foot) for foot in feet})

    assert together("tripod", "lf", "rm", "lr")
    assert together("tripod", "lf", "rm")
    assert not together("tripod", "lf", "lm")
    assert together("ripple", "lr", "rf")
    assert not together("ripple", "lr", "rf", "lm")
    assert together("wave", "rm")
    assert not together("wave", "rm", "lf")


@given(st.floats(0.0, 0.3))
def test_a_foot_whose_swing_begins_as_anothers_ends_waits_for_it(hexapod: RobotModel, pause: float) -> None:
    in_turn = gait(hexapod, **{leg: [list(span) for span in spans] for leg, spans in wave(hexapod.legs, pause).items()})
    assert all(in_turn.lifts_together({foot}) for foot in range(6))
    assert not any(map(in_turn.lifts_together, map(set, combinations(range(6), 2))))


def test_a_foot_may_swing_twice_a_turn(hexapod: RobotModel) -> None:
    twice = gait(hexapod, lf=[[0.6, 0.7], [0.1, 0.3]])
    first, second = twice.feet[LF]
    assert (first.start, first.length, first.stance) == pytest.approx((0.1, 0.2, 0.3))
    assert (second.start, second.length, second.stance) == pytest.approx((0.6, 0.1, 0.4))
    assert twice.longest_stance[LF] == pytest.approx(0.4)
    assert twice.until_lift_off(LF, 0.0) == pytest.approx(0.1)
    assert twice.until_lift_off(LF, 0.35) == pytest.approx(0.25)
    assert twice.until_lift_off(LF, 0.75) == pytest.approx(0.35)
    assert twice.starts == [0.0, 0.1, 0.6]


def test_the_stride_saturates_before_the_cadence_rises(gaits: dict[str, Gait]) -> None:
    tripod = gaits["tripod"]
    # Tripod: stance is half of a period of 1 s at most, the largest stride 100 mm.
    assert tripod.period(STILL) == 1.0
    assert tripod.period(Twist(0.1, 0.0, 0.0)) == 1.0
    assert tripod.period(Twist(0.2, 0.0, 0.0)) == pytest.approx(1.0)
    assert tripod.period(Twist(0.0, 0.25, 0.0)) == pytest.approx(0.8)
    assert tripod.period(Twist(-0.25, 0.0, 0.0)) == pytest.approx(0.8)


def test_turning_strides_are_those_of_the_farthest_foot(gaits: dict[str, Gait]) -> None:
    # Front and rear feet rest 0.2638 m from the middle: 1 rad/s carries them 0.2638 m/s.
    assert gaits["tripod"].period(Twist(0.0, 0.0, 1.0)) == pytest.approx(0.1 / (0.2638 * 0.5), rel=1e-3)
    # Driving ahead while turning left, the right feet go faster: 0.1 + 0.5 * 0.235 at the middle.
    speeds = gaits["tripod"].foot_speeds(Twist(0.1, 0.0, 0.5))
    assert (speeds[LM], speeds[RM]) == pytest.approx((0.0175, 0.2175))


@given(twists, st.sampled_from(["tripod", "ripple", "wave"]))
def test_no_twist_makes_a_swing_shorter_than_the_servos_can(
    gaits: dict[str, Gait], twist: Twist, name: str
) -> None:
    shortest = min(sector.length for sectors in gaits[name].feet for sector in sectors)
    assert gaits[name].period(twist) * shortest >= MIN_SWING - 1e-9


def test_a_hasty_gait_is_slowed_to_what_the_servos_can(hexapod: RobotModel) -> None:
    hasty = gait(hexapod, slowest=0.4, lf=[[0.5, 0.9]])
    assert hasty.period(STILL) * 0.4 >= MIN_SWING - 1e-9


@given(twists, st.sampled_from(["tripod", "ripple", "wave"]))
def test_at_the_largest_scale_the_longest_stride_is_the_largest(
    gaits: dict[str, Gait], twist: Twist, name: str
) -> None:
    assume(math.hypot(*twist) > 1e-3)
    walked = gaits[name]
    scale = walked.largest_scale(twist)
    largest = Twist(*(scale * component for component in twist))
    strides = [
        speed * walked.period(largest) * max(sector.stance for sector in sectors)
        for speed, sectors in zip(walked.foot_speeds(largest), walked.feet, strict=True)
    ]
    assert max(strides) == pytest.approx(STRIDE)
    assert walked.largest_scale(largest) == pytest.approx(1.0)


@given(st.floats(-math.pi, math.pi), st.floats(-1.0, 1.0))
def test_a_gait_may_be_slower_askew_than_ahead(hexapod: RobotModel, direction: float, turn: float) -> None:
    swing = {leg.name: [(0.0, 0.5)] for leg in hexapod.legs}
    slow = Gait(GaitConfig.model_validate({
        "schema": 1, "name": "askew", "description": "", "slowest_period_s": 1.0, "askew_mps": 0.1, "swing": swing}),
        hexapod)
    ahead = hexapod.motion.speed
    assert slow.largest_scale(Twist(ahead, 0.0, 0.0)) == pytest.approx(1.0)
    assert slow.largest_scale(Twist(-0.1, 0.0, 0.0)) == slow.largest_scale(Twist(0.0, 0.1, 0.0)) == pytest.approx(1.0)
    twist = Twist(math.cos(direction), math.sin(direction), turn)
    speeds = slow.foot_speeds(Twist(*(slow.largest_scale(twist) * v for v in twist)))
    assert max(speeds) <= ahead + 1e-9
    assert max(speeds) >= 0.1 - 1e-9


def test_a_robot_that_stands_still_may_be_scaled_by_anything(gaits: dict[str, Gait]) -> None:
    assert gaits["tripod"].largest_scale(STILL) == math.inf


def test_a_gait_for_other_feet_is_refused(hexapod: RobotModel) -> None:
    config = GaitConfig.model_validate({
        "schema": 1, "name": "crawl", "description": "", "slowest_period_s": 1.0,
        "swing": {"fl": [[0.0, 0.2]], "fr": [[0.25, 0.45]], "rl": [[0.5, 0.7]]}})
    with pytest.raises(UsageError, match=r"gait 'crawl' is for the feet fl, fr, rl; robot 'hexapod' has lf, lm"):
        Gait(config, hexapod)


def test_the_needle_turns_once_a_period(gaits: dict[str, Gait]) -> None:
    clock = GaitClock(gaits["tripod"])
    start = clock.phase
    for _ in range(25):
        clock.advance(Twist(0.05, 0.0, 0.0), 0.01, 1.0)
    assert (clock.phase - start) % 1.0 == pytest.approx(0.25)
    for _ in range(75):
        clock.advance(Twist(0.05, 0.0, 0.0), 0.01, 1.0)
    assert math.remainder(clock.phase - start, 1.0) == pytest.approx(0.0, abs=1e-9)


def test_the_period_changes_by_no_more_than_a_factor_of_four_a_second(gaits: dict[str, Gait]) -> None:
    clock = GaitClock(gaits["wave"])
    clock.change(gaits["tripod"], 0.3)
    assert (clock.gait.name, clock.phase, clock.period) == ("tripod", 0.3, 2.8)
    for _ in range(25):
        clock.advance(STILL, 0.01, 1.0)
    assert clock.period == pytest.approx(2.8 / math.sqrt(2.0))
    for _ in range(100):
        clock.advance(STILL, 0.01, 1.0)
    assert clock.period == pytest.approx(1.0)


def test_the_needle_hurries_while_the_feet_cannot_bear_the_speed(gaits: dict[str, Gait]) -> None:
    clock = GaitClock(gaits["tripod"])
    for _ in range(200):
        clock.advance(Twist(0.1, 0.0, 0.0), 0.01, 0.8)
    assert clock.period == pytest.approx(0.8)
    for _ in range(200):
        clock.advance(Twist(0.1, 0.0, 0.0), 0.01, 0.0)
    assert 0.5 * clock.period == pytest.approx(MIN_SWING, rel=0.1)
    assert 0.5 * clock.period >= MIN_SWING - 1e-9


def test_a_start_begins_with_the_next_lift_off(gaits: dict[str, Gait]) -> None:
    clock = GaitClock(gaits["wave"])
    for phase, expected in ((0.4, 0.5), (0.51, 2 / 3), (0.9, 0.0), (0.333333, 1 / 3)):
        clock.change(gaits["wave"], phase)
        clock.rewind()
        assert clock.phase == pytest.approx(expected)
