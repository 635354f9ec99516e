"""What the servos tell of themselves beside their motion, on a bus of Dynamixel fakes."""

import numpy as np
import pytest

from robotwalk.types import ServoCondition, ServoLimits

from .bus_rig import COUNT, PERIOD, armed, next_tick, rig


def test_an_overheated_servo_raises_its_alert_in_the_cycle_and_its_data_still_counts() -> None:
    built = armed()
    built.physics.temperature_c[2] = 90.0
    built.physics.step(np.zeros(COUNT), np.zeros(COUNT), built.clock.now() + 20_000_000)
    state = built.bus.exchange([0.0] * COUNT, PERIOD)
    assert built.bus.alerts == {"j2": "reports overload, heat or a wrong voltage"}
    assert state.valid == (True,) * COUNT
    next_tick(built)
    assert built.bus.alerts == {"j2": "reports overheating"}, "it was asked what is wrong at once"


def test_every_servos_condition_is_read_in_turn_with_its_time() -> None:
    built = armed()
    limits = ServoLimits(hottest=72.0, lowest_voltage=6.0, highest_voltage=14.0)  # as the servo itself has them
    assert set(built.bus.conditions().values()) == {ServoCondition(None, None, None, None, (), limits)}
    built.physics.supply_v[:] = 11.4
    built.physics.temperature_c[3] = 41.0
    built.physics.step(np.zeros(COUNT), np.zeros(COUNT), built.clock.now() + 1_000_000)
    for _ in range(COUNT + 1):
        next_tick(built)
    conditions = built.bus.conditions()
    assert list(conditions) == [f"j{i}" for i in range(COUNT)]
    for joint, told in conditions.items():
        assert told.voltage is not None
        assert told.temperature is not None
        assert told.voltage.value == pytest.approx(11.4)
        assert told.temperature.value == (41.0 if joint == "j3" else 30.0)
        assert 0 <= built.clock.now() - told.voltage.heard <= (COUNT + 1) * 12_000_000
        assert told.holds
        assert told.current is None, "which this servo does not measure"
    next_tick(built)
    after = built.bus.conditions()
    anew = [joint for joint, told in conditions.items() if after[joint] is not told]
    assert len(anew) == 1, "a condition stays the same object until its servo is read again"


def test_a_condition_is_one_short_read_of_gathered_registers() -> None:
    built = armed()
    built.bus.exchange([0.0] * COUNT, PERIOD)
    next_tick(built)
    reads = [data[4:-2] for data in built.device.heard if data[7] == 0x02]
    assert reads == [bytes((1, 7, 0, 2, 224, 0, 6, 0))], "torque, error, voltage, temperature, watchdog from data 1"


def test_whoever_has_another_map_is_read_where_the_registers_lie() -> None:
    built = rig()
    built.servos[0].write(168, (65).to_bytes(2, "little"))  # not ours, and not a start's
    built.bus.arm(PERIOD)
    built.device.heard.clear()
    for _ in range(COUNT + 3):
        next_tick(built)
    reads = {(data[4], data[8]) for data in built.device.heard if data[7] == 0x02}
    assert reads == {(1, 64), (1, 98), (1, 144), *((i, 224) for i in range(2, COUNT + 1))}
    assert all(told.holds for told in built.bus.conditions().values())


def test_a_servo_that_restarted_unnoticed_is_found_by_its_torque() -> None:
    built = armed()
    for _ in range(COUNT + 1):
        next_tick(built)
    assert built.bus.alerts == {}
    built.servos[3].write(64, b"\0")
    for _ in range(COUNT + 1):
        next_tick(built)
    assert built.bus.alerts == {"j3": "has let go: its torque is off, and nobody switched it off"}
