"""A joint's zero, direction and range, with somebody's hand on the shaft."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.maintenance.calibrate import Hand, direction, found, is_proven, prove
from hal.maintenance.servo import Servo
from robotwalk.errors import BusError, ServoError

from .body import SHOULDER, body
from .rig import rig

BRANDS = pytest.mark.parametrize("name", ["xl430-w250", "sts3215"])
COUNT = math.tau / 4096


class Held(NamedTuple):
    """A servo on the bench, and the hand that turns its shaft."""

    built: Any
    servo: Servo

    def turn(self, counts: float) -> None:
        physics = self.built.servos[0]._physics
        physics.step(np.array([(counts - 2048) * COUNT]), np.zeros(1), self.built.clock.now())

    def turn_to(self, hand: Hand, start: int, end: int) -> None:
        """Turn it steadily, a hundredth of a turn between two looks."""
        steps = max(abs(end - start) // 40, 1)
        at = iter(np.linspace(start, end, steps + 1))

        def done() -> bool:
            position = next(at, None)
            if position is None:
                return True
            self.turn(float(position))
            return False

        hand.follow(done)


def held(name: str, counts: int = 2048) -> Held:
    built = rig(name, 1)
    one = Held(built, built.bench.servo(1))
    one.turn(counts)
    return one


@BRANDS
def test_a_joint_turned_by_hand_is_found_with_its_zero_direction_and_range(name: str) -> None:
    one = held(name, 2300)
    hand = Hand(one.servo, one.built.clock)
    at = hand.still()
    assert at == pytest.approx(2300, abs=2)
    one.turn_to(hand, 2300, 2100)
    way = direction(one.servo, at, hand.look())
    assert way == -1
    hand.forget_range()
    one.turn_to(hand, 2100, 3300)
    one.turn_to(hand, 3300, 1300)
    result = found(one.servo, at, 90.0, way, (hand.lowest, hand.highest))
    assert result.zero_deg == pytest.approx(90.0 + 252 * 360 / 4096, abs=0.3)
    assert result.range_deg == pytest.approx((90 - 1000 * 360 / 4096, 90 + 1000 * 360 / 4096), abs=0.5)


@BRANDS
def test_a_shaft_that_passes_its_encoders_seam_is_followed_and_refused_with_the_way_out(name: str) -> None:
    one = held(name, 3900)
    hand = Hand(one.servo, one.built.clock)
    at = hand.still()
    one.turn_to(hand, 3900, 4500)
    assert hand.look() == pytest.approx(4500, abs=3), "no jump by a whole turn"
    one.turn_to(hand, 4500, 3300)
    assert (hand.lowest, hand.highest) == pytest.approx((3300, 4500), abs=3)
    refusal = r"from count 3\d+ to 4\d+, across the seam .* turn the servo's shaft by -16\d"
    with pytest.raises(ServoError, match=refusal):
        found(one.servo, at, 0.0, 1, (hand.lowest, hand.highest))


@given(at=st.integers(300, 3700), at_deg=st.floats(-150, 150), way=st.sampled_from([1, -1]), angle=st.floats(-90, 90))
def test_the_zero_found_makes_every_count_the_right_angle(at: int, at_deg: float, way: Any, angle: float) -> None:
    servo = SERVO
    result = found(servo, at, at_deg, way, None)
    counts = at + way * angle / math.degrees(COUNT)
    told = result.zero_deg + way * (counts - 2048) * math.degrees(COUNT)
    assert told == pytest.approx(at_deg + angle, abs=0.002)


SERVO = rig("xl430-w250", 1).bench.servo(1)


def test_too_small_a_move_tells_no_direction() -> None:
    with pytest.raises(ServoError, match=r"moved by 4\.\d deg only"):
        direction(SERVO, 2000, 2050)


def test_a_joint_that_is_not_held_still_is_not_read() -> None:
    one = held("xl430-w250")
    hand = Hand(one.servo, one.built.clock)
    positions = iter(range(2048, 3048, 20))
    look = hand.look
    hand.look = lambda: (one.turn(next(positions)), look())[1]  # type: ignore[method-assign]
    with pytest.raises(ServoError, match="hold it still"):
        hand.still()


def test_a_failed_read_is_no_position() -> None:
    one = held("xl430-w250")
    hand = Hand(one.servo, one.built.clock)
    one.built.device.tamper = lambda sent, replies: []
    with pytest.raises(BusError):
        hand.look()
    assert (hand.lowest, hand.highest) == (hand.counts, hand.counts)


def test_nobody_is_calibrated_who_may_stand_on_his_torque() -> None:
    one = held("xl430-w250")
    one.servo.write("torque_enable", 1)
    with pytest.raises(ServoError, match="has its torque on"):
        Hand(one.servo, one.built.clock)


@BRANDS
def test_a_joint_proves_its_zero_by_moving_back_gently_and_lets_go(name: str) -> None:
    built = body(name)
    servo = built.servo(SHOULDER[name])
    here = servo.read("present_position")
    assert is_proven(prove(servo, built.clock, here + 60, 0.25, lambda: None))
    assert built.table(SHOULDER[name])["torque_enable"] == 0
    built.weld(SHOULDER[name])
    assert not is_proven(prove(servo, built.clock, here - 60, 0.25, lambda: None))
    assert built.table(SHOULDER[name])["torque_enable"] == 0


