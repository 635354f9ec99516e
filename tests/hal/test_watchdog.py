"""The servos' own watchdogs: armed last, fed by the cycle, off in a pause, and set up again where one has tripped."""

import math

import pytest
from pydantic import ValidationError

from hal.register_map import ServoModel

from .bus_rig import COUNT, MODEL, PERIOD, TICK, Rig, armed, next_tick, rig

ARMED, TRIPPED = 10, 0xFF  # counts; ten times 20 ms
TIME = 200_000_000  # ns


def watchdogs(built: Rig) -> list[int]:
    return [servo.table["bus_watchdog"] for servo in built.servos]


def goals(built: Rig) -> list[int]:
    return [servo.table["goal_position"] for servo in built.servos]


def let_pass(built: Rig, duration: int, shafts: list[float] | None = None) -> None:
    """Let time pass in which nobody says anything; the servos look at their clocks."""
    built.clock.wait((), built.clock.now() + duration)
    built.hold(shafts or [0.0] * COUNT)


def test_they_are_armed_as_the_last_step_of_a_start() -> None:
    built = rig()
    built.bus.arm(PERIOD)
    assert watchdogs(built) == [ARMED] * COUNT
    sent = [data for data in built.device.heard if data[7] in (0x03, 0x83)][-1]
    assert sent[-12:-2] == b"\x01\x0a\x02\x0a\x03\x0a\x04\x0a\x05\x0a", "nothing is written after that"


def test_the_cycle_feeds_them() -> None:
    built = armed()
    for _ in range(50):
        next_tick(built)
        built.hold([0.0] * COUNT)
    assert watchdogs(built) == [ARMED] * COUNT
    assert built.bus.statistics()["legs"].watchdog_trips == 0


def test_when_nobody_speaks_the_servos_stop_where_they_are_and_hold() -> None:
    built = armed()
    built.bus.exchange([0.3] * COUNT, PERIOD)
    let_pass(built, TIME + 1_000_000, [100 * TICK] * COUNT)
    assert watchdogs(built) == [TRIPPED] * COUNT
    assert goals(built) == [2148] * COUNT
    assert [servo.table["torque_enable"] for servo in built.servos] == [1] * COUNT


def test_in_a_pause_they_are_off_and_the_next_exchange_arms_them_again() -> None:
    built = armed()
    built.bus.pause()
    let_pass(built, 5 * TIME)
    assert watchdogs(built) == [0] * COUNT
    next_tick(built)
    assert watchdogs(built) == [ARMED] * COUNT


def test_disarming_leaves_none_armed() -> None:
    built = armed()
    assert built.bus.disarm() == []
    assert watchdogs(built) == [0] * COUNT


def test_an_exchange_that_comes_too_late_finds_them_tripped_and_goes_on() -> None:
    """As when the computer stalls: without a look at the registers, in the same tick."""
    built = armed()
    let_pass(built, TIME + 50_000_000)
    assert watchdogs(built) == [TRIPPED] * COUNT
    built.bus.exchange([50 * TICK] * COUNT, PERIOD)
    assert watchdogs(built) == [ARMED] * COUNT
    assert goals(built)[3] == 2098


def test_one_that_tripped_unnoticed_is_found_sent_to_where_it_is_and_armed() -> None:
    """As when its wire was broken for a while: nobody answers a goal, so nobody refuses it aloud."""
    built = armed()
    for _ in range(COUNT):
        next_tick(built)
    bite = built.servos[3]
    bite.table["bus_watchdog"] = TRIPPED
    bite.write(65, b"\0")  # any write makes the firmware look at its settings
    seeds = []
    for _ in range(COUNT + 2):
        built.hold([0.0, 0.0, 0.0, 100 * TICK, 0.0])
        next_tick(built)
        seeds.append(goals(built)[3])
    assert watchdogs(built) == [ARMED] * COUNT
    assert 2148 in seeds, "for one tick it is sent to where it is"
    assert seeds[-1] == 2048, "then it follows again"
    assert built.bus.statistics()["legs"].watchdog_trips == 1
    assert built.bus.alerts == {}


def test_whoever_takes_over_a_tripped_servo_lets_it_hold_where_it_is() -> None:
    built = armed()
    built.bus.exchange([0.3] * COUNT, PERIOD)
    let_pass(built, TIME + 1_000_000, [100 * TICK] * COUNT)
    assert built.bus.arm(PERIOD).position[0] == pytest.approx(100 * TICK)
    assert goals(built)[0] == 2148
    assert watchdogs(built) == [ARMED] * COUNT
    assert [note.partition(":")[0] for note in built.bus.notes] == [
        "had stopped, for it heard nothing any more; it holds where it is"]


def test_a_time_that_the_register_cannot_hold_is_refused() -> None:
    data = MODEL.model_dump(by_alias=True)
    for time_ms in (30, 3000, math.inf):
        data["arming"]["watchdog"] = {"name": "bus_watchdog", "time_ms": time_ms}
        with pytest.raises(ValidationError, match="time_ms"):
            ServoModel.model_validate(data)
