"""A servo is turned a few degrees there and back, and left as it was."""

import itertools
import math
from typing import Any

import pytest

from hal.maintenance.gentle import gently
from hal.maintenance.wiggle import wiggle
from robotwalk.errors import BusError, ServoError

from .body import SHOULDER, body

BRANDS = pytest.mark.parametrize("name", ["xl430-w250", "sts3215"])
CAP = {"xl430-w250": "goal_pwm", "sts3215": "torque_limit"}
ANYWHERE = (0, 4095)
FOUR_DEGREES = 46  # counts


def settings(table: Any, name: str) -> dict[str, int]:
    return {key: table[key] for key in ("torque_enable", "goal_position", CAP[name])}


@BRANDS
@pytest.mark.parametrize("first", [FOUR_DEGREES, -FOUR_DEGREES])
def test_it_moves_there_and_back_slowly_and_weakly_and_is_left_as_it_was(name: str, first: int) -> None:
    built = body(name)
    joint = SHOULDER[name]
    table, before = built.table(joint), settings(built.table(joint), name)
    start = built.angle(joint)
    seen, caps = [start], set()
    built.each_step(lambda: (seen.append(built.angle(joint)), caps.add(table[CAP[name]] * table["torque_enable"])))
    done = wiggle(built.servo(joint), built.clock, first, ANYWHERE, 0.25, lambda: None)
    assert [turn.asked for turn in done.turns] == [first, -first]
    assert all(turn.done for turn in done.turns)
    assert abs(done.rest) < 12
    assert max(seen) - start == pytest.approx(math.radians(4), abs=math.radians(1.5))
    assert start - min(seen) == pytest.approx(math.radians(4), abs=math.radians(1.5))
    fastest = max(abs(b - a) for a, b in itertools.pairwise(seen)) * built.robot.world.steps_per_second
    assert fastest < math.radians(40)
    largest = built.servo(joint).model[CAP[name]].range[1]
    assert caps == {0, round(0.25 * largest)}
    assert settings(table, name) == before


@BRANDS
def test_a_joint_that_is_held_does_not_move_and_no_more_force_is_used(name: str) -> None:
    built = body(name)
    joint = SHOULDER[name]
    built.weld(joint)
    done = wiggle(built.servo(joint), built.clock, FOUR_DEGREES, ANYWHERE, 0.25, lambda: None)
    assert not any(turn.done for turn in done.turns)
    assert settings(built.table(joint), name)["torque_enable"] == 0


@BRANDS
def test_a_side_without_room_is_left_out(name: str) -> None:
    built = body(name)
    servo = built.servo(SHOULDER[name])
    here = servo.read("present_position")
    done = wiggle(servo, built.clock, FOUR_DEGREES, (here - 10, here + 100), 0.25, lambda: None)
    assert [turn.asked for turn in done.turns] == [FOUR_DEGREES]
    done = wiggle(servo, built.clock, FOUR_DEGREES, (here - 20, here + 100), 0.25, lambda: None)
    assert done.turns[0].asked == FOUR_DEGREES
    assert -FOUR_DEGREES < done.turns[1].asked < -15, "shortened"


@BRANDS
def test_the_servos_own_limits_are_kept(name: str) -> None:
    built = body(name)
    servo = built.servo(SHOULDER[name])
    servo.write("max_position_limit", servo.read("present_position") + 5)
    done = wiggle(servo, built.clock, FOUR_DEGREES, ANYWHERE, 0.25, lambda: None)
    assert [turn.asked for turn in done.turns] == [-FOUR_DEGREES]


@BRANDS
@pytest.mark.parametrize(("bounds", "why"), [((0, 100), "outside its limits of 0 to 100"), (None, "has no room")])
def test_no_torque_where_there_is_no_room(name: str, bounds: tuple[int, int] | None, why: str) -> None:
    built = body(name)
    servo = built.servo(SHOULDER[name])
    here = servo.read("present_position")
    with pytest.raises(ServoError, match=why):
        wiggle(servo, built.clock, FOUR_DEGREES, bounds or (here - 3, here + 3), 0.25, lambda: None)
    assert built.table(SHOULDER[name])["torque_enable"] == 0


@BRANDS
def test_a_servo_that_holds_goes_on_holding(name: str) -> None:
    built = body(name)
    servo = built.servo(SHOULDER[name])
    servo.write("goal_position", servo.read("present_position"))
    servo.write("torque_enable", 1)
    before = settings(built.table(SHOULDER[name]), name)
    assert all(turn.done for turn in wiggle(servo, built.clock, 46, ANYWHERE, 0.25, lambda: None).turns)
    assert settings(built.table(SHOULDER[name]), name) == before


@BRANDS
def test_what_ends_it_leaves_it_limp(name: str) -> None:
    built = body(name)
    joint = SHOULDER[name]
    before = settings(built.table(joint), name)
    ticks = iter(range(10))

    def check() -> None:
        if next(ticks) == 9:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        wiggle(built.servo(joint), built.clock, FOUR_DEGREES, ANYWHERE, 0.25, check)
    assert settings(built.table(joint), name) == before


@BRANDS
def test_a_servo_that_falls_silent_may_be_under_torque_and_that_is_said(name: str) -> None:
    built = body(name)
    servo = built.servo(SHOULDER[name])
    port = built.robot.ports["legs"]
    with pytest.raises(BusError, match=r"does not answer any more: its torque may still be on"), \
            gently(servo, built.clock, 0.25):
        port.baud = 57_600


def test_a_servo_in_another_mode_or_with_an_error_is_not_moved() -> None:
    built = body("sts3215")
    servo = built.servo("lf_hip")
    servo.write("operating_mode", 1)
    with pytest.raises(ServoError, match=r"not set to control its position: robotwalk servo write 1 operating_mode=0"):
        wiggle(servo, built.clock, 46, ANYWHERE, 0.25, lambda: None)
    servo.write("operating_mode", 0)
    built.robot.physics.temperature_c[0] = 95.0
    built.clock.wait((), built.clock.now() + 200_000_000)
    with pytest.raises(ServoError, match="reports a hardware error: "):
        wiggle(servo, built.clock, 46, ANYWHERE, 0.25, lambda: None)
    assert built.table("lf_hip")["torque_enable"] == 0
