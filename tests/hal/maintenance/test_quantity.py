"""Register values for people, and what is said of values that a register does not take."""

import pytest

from hal.maintenance import quantity
from robotwalk.errors import UsageError

from .rig import STS3215, XL430


@pytest.mark.parametrize(("model", "name", "counts", "text", "value"), [
    (XL430, "max_voltage_limit", 125, "12.5 V", 12.5),
    (XL430, "velocity_limit", 265, "60.69 rpm", 60.69),
    (XL430, "pwm_limit", 442, "49.95 %", 49.95),
    (XL430, "bus_watchdog", 5, "100 ms", 100.0),
    (XL430, "homing_offset", -131073, "-131073 pulse", -131073.0),
    (XL430, "led", 1, "1", 1.0),
    (XL430, "shutdown", 52, "52 (overheating, electrical shock, overload)", 52.0),
    (XL430, "hardware_error_status", 0x03, "3 (input voltage, bit 1)", 3.0),
    (STS3215, "protection_current", 500, "3250 mA", 3250.0),
    (STS3215, "goal_velocity", -3400, "-0.83008 rev/s", -0.83008),
    (STS3215, "acceleration", 20, "2000 step/s^2", 2000.0),
    (STS3215, "hardware_error_status", 0x20, "32 (overload)", 32.0),
])
def test_a_value_with_its_unit(model: object, name: str, counts: int, text: str, value: float) -> None:
    register = model[name]
    assert quantity.text(register, counts) == text
    assert quantity.in_units(register, counts) == value


@pytest.mark.parametrize(("model", "name", "words", "counts"), [
    (XL430, "max_voltage_limit", "12.5", 125),
    (XL430, "max_voltage_limit", "12.5V", 125),
    (XL430, "max_voltage_limit", " 12.5 V ", 125),
    (XL430, "velocity_limit", "60", 262),  # the nearest count
    (XL430, "goal_velocity", "-22.9rpm", -100),
    (XL430, "goal_position", "+1e3", 1000),
    (STS3215, "protection_time", "500ms", 50),
    (STS3215, "torque_enable", "128", 128),
])
def test_a_value_is_understood_with_its_unit_or_without(model: object, name: str, words: str, counts: int) -> None:
    assert quantity.counts(model[name], words) == counts


def test_raw_values_are_counts() -> None:
    assert quantity.counts(XL430["max_voltage_limit"], "125", raw=True) == 125


@pytest.mark.parametrize(("name", "words", "raw", "sentence"), [
    ("max_voltage_limit", "15", False, "max_voltage_limit should be 6 V to 14 V, not 15 V (counts: 150)"),
    ("max_voltage_limit", "14.06", False, "max_voltage_limit should be 6 V to 14 V, not 14.1 V (counts: 141)"),
    ("max_voltage_limit", "12.5", True, "max_voltage_limit should be a whole number, not '12.5'"),
    ("max_voltage_limit", "12mV", False, "max_voltage_limit should be a number of V, not '12mV'"),
    ("max_voltage_limit", "12V", True, "max_voltage_limit should be a number, not '12V'"),
    ("max_voltage_limit", "nan", False, "max_voltage_limit should be a number of V, not 'nan'"),
    ("max_voltage_limit", "1e999", False, "max_voltage_limit should be a number of V, not '1e999'"),
    ("operating_mode", "2", False, "operating_mode should be one of 1, 3, 4, 16, not 2"),
    ("present_position", "2", False, "present_position is read-only"),
    ("goal_position", "2.5", False, "goal_position should be a whole number, not '2.5'"),
    ("indirect_data_1", "256", False, "indirect_data_1 should be 0 to 255, not 256"),
])
def test_a_value_that_the_register_does_not_take(name: str, words: str, raw: bool, sentence: str) -> None:
    with pytest.raises(UsageError) as error:
        quantity.counts(XL430[name], words, raw=raw)
    assert str(error.value) == sentence


def test_a_name_that_is_nearly_right() -> None:
    with pytest.raises(UsageError, match="has no register 'goal_positon'; did you mean 'goal_position'"):
        quantity.register_of(XL430, "goal_positon")
    with pytest.raises(UsageError, match="`robotwalk servo info ID` lists them"):
        quantity.register_of(XL430, "xyzzy")
