"""Every number in the AX-12A's file, from the e-Manual's page, copied here by hand.

The layout is also held against the definitions inside rustypot, which come from another hand.
"""

import pytest

from hal.protocols import protocol_of
from hal.register_map import AxFirmware, ComplianceLoop, Register
from robotwalk.assembly import load_servo

MODEL = load_servo("ax-12a")

# address, size, name, access, memory, bit of the sign, range, default, scale and unit; - for none
TABLE = """
 0 2 model_number          r  eeprom  - -             12 1
 2 1 firmware_version      r  eeprom  - -              - 1
 3 1 id                    rw eeprom  - 0..253         1 1
 4 1 baud_rate             rw eeprom  - 0..254         1 1
 5 1 return_delay_time     rw eeprom  - 0..254       250 2 us
 6 2 cw_angle_limit        rw eeprom  - 0..1023        0 1 step
 8 2 ccw_angle_limit       rw eeprom  - 0..1023     1023 1 step
11 1 temperature_limit     rw eeprom  - 0..150        70 1 degC
12 1 min_voltage_limit     rw eeprom  - 50..250       60 0.1 V
13 1 max_voltage_limit     rw eeprom  - 50..250      140 0.1 V
14 2 max_torque            rw eeprom  - 0..1023     1023 0.1 %
16 1 status_return_level   rw eeprom  - 0..2           2 1
17 1 alarm_led             rw eeprom  - 0..127        36 1
18 1 shutdown              rw eeprom  - 0..127        36 1
24 1 torque_enable         rw ram     - 0..1           0 1
25 1 led                   rw ram     - 0..1           0 1
26 1 cw_compliance_margin  rw ram     - 0..255         1 1 step
27 1 ccw_compliance_margin rw ram     - 0..255         1 1 step
28 1 cw_compliance_slope   rw ram     - 0..254        32 1 step
29 1 ccw_compliance_slope  rw ram     - 0..254        32 1 step
30 2 goal_position         rw ram     - 0..1023        - 1 step
32 2 moving_speed          rw ram    10 -1023..1023    0 0.111 rpm
34 2 torque_limit          rw ram     - 0..1023        - 0.1 %
36 2 present_position      r  ram     - -              - 1 step
38 2 present_speed         r  ram    10 -              - 0.111 rpm
40 2 present_load          r  ram    10 -              - 0.1 %
42 1 present_voltage       r  ram     - -              - 0.1 V
43 1 present_temperature   r  ram     - -              - 1 degC
44 1 registered            r  ram     - -              0 1
46 1 moving                r  ram     - -              0 1
47 1 eeprom_lock           rw ram     - 0..1           0 1
48 2 punch                 rw ram     - 32..1023      32 0.1 %
"""


def row_text(register: Register) -> str:
    """Return a row as it stands in the table above, but for the columns' widths."""
    allowed = "-" if register.range is None else f"{register.range[0]}..{register.range[1]}"
    fields = (
        register.address, register.size, register.name, register.access.value, register.memory.value,
        "-" if register.sign_bit is None else register.sign_bit, allowed,
        "-" if register.default is None else register.default, f"{register.scale:.8g}", register.unit)
    return " ".join(map(str, fields)).rstrip()


def test_every_register() -> None:
    expected = [" ".join(line.split()) for line in TABLE.strip().splitlines()]
    assert [row_text(row) for row in MODEL.registers] == expected
    assert not any(row.signed for row in MODEL.registers), "nothing here is in two's complement"
    assert {row.byte_order for row in MODEL.registers} == {"little"}


def test_flags_and_choices() -> None:
    faults = ("input voltage", "angle limit", "overheating", "range", "checksum", "overload", "instruction")
    assert {row.name: row.flags for row in MODEL.registers if row.flags} == {"alarm_led": faults, "shutdown": faults}
    assert {row.name: row.choices for row in MODEL.registers if row.choices} == {
        "baud_rate": (1, 3, 4, 7, 9, 16, 34, 103, 207)}


def test_baud_rates_are_two_million_by_one_more_than_the_value_but_for_their_names() -> None:
    assert dict(MODEL.baud_by_value) == {
        1: 1_000_000, 3: 500_000, 4: 400_000, 7: 250_000, 9: 200_000, 16: 115_200, 34: 57_600, 103: 19_200, 207: 9600}
    for value, rate in MODEL.baud_by_value.items():
        assert 2_000_000 / (value + 1) == pytest.approx(rate, rel=0.022)


def test_identity_encoder_and_data_sheet() -> None:
    sheet, rated = MODEL.specification, MODEL.specification.rated
    assert (MODEL.model_number, MODEL.sync_read, MODEL.fast_sync_read_firmware, MODEL.backup_firmware) == (
        12, False, None, None)
    assert (MODEL.encoder.ticks, MODEL.encoder.span_deg, MODEL.encoder.centre) == (1024, 300, 512)
    assert (rated.voltage_v, rated.stall_torque_nm, rated.stall_current_a, rated.no_load_rpm) == (12, 1.5, 1.5, 59)
    assert (sheet.others, sheet.mass_g, sheet.gear_ratio) == ((), 54.6, 254)
    assert protocol_of(MODEL) is not None


def test_what_the_exchange_uses() -> None:
    cyclic, telemetry, arming = MODEL.cyclic, MODEL.cyclic.telemetry, MODEL.arming
    assert (cyclic.goal, cyclic.effort, cyclic.velocity, cyclic.position, cyclic.torque_cap) == (
        "goal_position", "present_load", "present_speed", "present_position", "torque_limit")
    assert cyclic.effort_full_scale == 1023
    assert (telemetry.torque, telemetry.error, telemetry.voltage, telemetry.temperature, telemetry.current) == (
        "torque_enable", None, "present_voltage", "present_temperature", None)
    assert arming.require["status_return_level"] == 2
    for name, value in {**arming.set, **arming.explain}.items():
        assert value == MODEL[name].default
    assert arming.position_limits == ("cw_angle_limit", "ccw_angle_limit")
    assert MODEL.position_loop == ComplianceLoop(slope="cw_compliance_slope", pwm_full_scale=1023)


def test_what_is_assumed() -> None:
    """Each with its reason in the file."""
    assert isinstance(MODEL.firmware, AxFirmware)
    assert MODEL.firmware.model_dump(exclude={"kind"}) == {
        "version": 24, "goal_follows_present": False, "reboot": False, "answers_at_new_setting": False,
        "turnaround_us": 0.0, "dead_zone_reads": "nearest", "reboot_s": 0.3, "overload_duty": 0.8, "overload_s": 2.0,
        "temperature_c": 30.0}


def test_rustypot_lays_out_the_same() -> None:
    rustypot = pytest.importorskip("rustypot", reason="rustypot is not installed")
    renamed = {"baudrate": "baud_rate", "lock": "eeprom_lock"}
    theirs = {renamed.get(row.name, row.name): (row.addr, row.size) for row in rustypot.AxPyController.registers()}
    ours = {row.name: (row.address, row.size) for row in MODEL.registers}
    assert theirs == ours
