"""Every number in the files of the bundled Feetech servos, from servo tables and data sheets copied here by hand.

The layout is also held against the definitions inside rustypot, which come from another hand.
"""

import pytest

from hal.protocols import protocol_of
from hal.register_map import Register
from robotwalk.assembly import load_servo

rustypot = pytest.importorskip("rustypot", reason="rustypot is not installed")

STS, SCS = ("sts3215", "sts3215-12v", "sts3250"), ("scs0009", "scs15")
MODELS = {name: load_servo(name) for name in STS + SCS}
EVERY = pytest.mark.parametrize("name", MODELS)

# address, size, name, access, memory, bit of the sign, range or choices, default, scale and unit; - for none
STS_TABLE = """
 0 1 firmware_major          r  eeprom  - -                 3  1
 1 1 firmware_minor          r  eeprom  - -                 7  1
 2 1 big_endian              r  eeprom  - -                 0  1
 3 2 model_number            r  eeprom  - -               777  1
 5 1 id                      rw eeprom  - 0..253            1  1
 6 1 baud_rate               rw eeprom  - 0..7              0  1
 7 1 return_delay_time       rw eeprom  - 0..254            0  2 us
 8 1 status_return_level     rw eeprom  - 0..1              1  1
 9 2 min_position_limit      rw eeprom  - 0..4095           0  1 step
11 2 max_position_limit      rw eeprom  - 0..4095        4095  1 step
13 1 max_temperature_limit   rw eeprom  - 0..100           70  1 degC
14 1 max_voltage_limit       rw eeprom  - 0..254           80  0.1 V
15 1 min_voltage_limit       rw eeprom  - 0..254           40  0.1 V
16 2 max_torque_limit        rw eeprom  - 0..1000        1000  0.1 %
18 1 phase                   rw eeprom  - 0..255           12  1
19 1 unloading_condition     rw eeprom  - 0..255           44  1
20 1 led_alarm_condition     rw eeprom  - 0..255           47  1
21 1 position_p_gain         rw eeprom  - 0..254           32  1
22 1 position_d_gain         rw eeprom  - 0..254           32  1
23 1 position_i_gain         rw eeprom  - 0..254            0  1
24 2 minimum_start_force     rw eeprom  - 0..1000          16  0.1 %
26 1 cw_dead_zone            rw eeprom  - 0..32             1  1 step
27 1 ccw_dead_zone           rw eeprom  - 0..32             1  1 step
28 2 protection_current      rw eeprom  - 0..511          500  6.5 mA
30 1 angular_resolution      rw eeprom  - 1..3              1  1
31 2 position_offset         rw eeprom 11 -2047..2047       0  1 step
33 1 operating_mode          rw eeprom  - 0..3              0  1
34 1 protective_torque       rw eeprom  - 0..100           20  1 %
35 1 protection_time         rw eeprom  - 0..254          200  10 ms
36 1 overload_torque         rw eeprom  - 0..100           80  1 %
37 1 velocity_p_gain         rw eeprom  - 0..254           10  1
38 1 over_current_time       rw eeprom  - 0..254          200  10 ms
39 1 velocity_i_gain         rw eeprom  - 0..254           10  0.1
40 1 torque_enable           rw ram     - 0|1|2|128         0  1
41 1 acceleration            rw ram     - 0..254            0  100 step/s^2
42 2 goal_position           rw ram    15 -30719..30719     0  1 step
44 2 goal_pwm                rw ram    10 -1000..1000       0  0.1 %
46 2 goal_velocity           rw ram    15 -3400..3400       0  0.00024414062 rev/s
48 2 torque_limit            rw ram     - 0..1000        1000  0.1 %
55 1 lock                    rw ram     - 0..1              0  1
56 2 present_position        r  ram    15 -                 -  1 step
58 2 present_velocity        r  ram    15 -                 -  0.00024414062 rev/s
60 2 present_load            r  ram    10 -                 -  0.1 %
62 1 present_input_voltage   r  ram     - -                 -  0.1 V
63 1 present_temperature     r  ram     - -                 -  1 degC
64 1 registered_instruction  r  ram     - -                 0  1
65 1 hardware_error_status   r  ram     - -                 0  1
66 1 moving                  r  ram     - -                 0  1
69 2 present_current         r  ram    15 -                 -  6.5 mA
71 2 goal_position_echo      r  ram    15 -                 -  1 step
80 1 moving_threshold        rw eeprom  - 0..254            1  1
81 1 dts_ms                  rw eeprom  - 0..254            0  1
82 1 velocity_unit           rw eeprom  - 0..254            0  1
83 1 hts_ns                  rw eeprom  - 0..254            0  1
84 1 max_velocity_limit      rw eeprom  - 0..254           68  0.012207031 rev/s
85 1 max_acceleration        rw eeprom  - 0..254          254  100 step/s^2
86 1 acceleration_multiplier rw eeprom  - 0..254            1  1
"""

SCS_TABLE = """
 0 1 firmware_major          r  eeprom  - -                 -  1
 1 1 firmware_minor          r  eeprom  - -                 -  1
 3 2 model_number            r  eeprom  - -              1295  1
 5 1 id                      rw eeprom  - 0..253            0  1
 6 1 baud_rate               rw eeprom  - 0..7              0  1
 7 1 return_delay_time       rw eeprom  - 0..254            0  2 us
 8 1 status_return_level     rw eeprom  - 0..1              1  1
 9 2 min_position_limit      rw eeprom  - 0..1023           0  1 step
11 2 max_position_limit      rw eeprom  - 0..1023        1023  1 step
13 1 max_temperature_limit   rw eeprom  - 0..100           80  1 degC
14 1 max_voltage_limit       rw eeprom  - 0..254          250  0.1 V
15 1 min_voltage_limit       rw eeprom  - 0..254           50  0.1 V
16 2 max_torque_limit        rw eeprom  - 0..1023        1023  0.1 %
18 1 phase                   rw eeprom  - 0..255            0  1
19 1 unloading_condition     rw eeprom  - 0..255           37  1
20 1 led_alarm_condition     rw eeprom  - 0..255           37  1
21 1 position_p_gain         rw eeprom  - 0..254           15  1
22 1 position_d_gain         rw eeprom  - 0..254            0  1
23 1 position_i_gain         rw eeprom  - 0..254            0  1
24 2 minimum_start_force     rw eeprom  - 0..1000           0  0.1 %
26 1 cw_dead_zone            rw eeprom  - 0..32             2  1 step
27 1 ccw_dead_zone           rw eeprom  - 0..32             2  1 step
37 1 protective_torque       rw eeprom  - 0..100           20  1 %
38 1 protection_time         rw eeprom  - 0..254          200  10 ms
39 1 overload_torque         rw eeprom  - 0..100           80  1 %
40 1 torque_enable           rw ram     - 0|1               0  1
42 2 goal_position           rw ram     - 0..1023           0  1 step
44 2 goal_time               rw ram     - -                 0  1 ms
46 2 goal_velocity           rw ram    15 -                 0  0.00058322483 rev/s
48 1 lock                    rw ram     - 0..1              1  1
56 2 present_position        r  ram     - -                 -  1 step
58 2 present_velocity        r  ram    15 -                 -  0.00058322483 rev/s
60 2 present_load            r  ram    10 -                 -  0.1 %
62 1 present_input_voltage   r  ram     - -                 -  0.1 V
63 1 present_temperature     r  ram     - -                 -  1 degC
64 1 registered_instruction  r  ram     - -                 0  1
65 1 hardware_error_status   r  ram     - -                 0  1
66 1 moving                  r  ram     - -                 0  1
"""

# What a model has otherwise than its series: default, scale.
DIFFERENT: dict[str, dict[str, tuple[int | None, float]]] = {
    "sts3215": {},
    "sts3215-12v": {"max_voltage_limit": (140, 0.1)},
    "sts3250": {
        "model_number": (2825, 1), "max_voltage_limit": (140, 0.1), "max_velocity_limit": (102, 0.01220703125)},
    "scs0009": {
        "model_number": (1284, 1), "id": (1, 1), "goal_velocity": (0, 8.1380208e-4),
        "present_velocity": (None, 8.1380208e-4)},
    "scs15": {},
}


def row_text(register: Register) -> str:
    """Return a row as it stands in the tables above, but for the columns' widths."""
    if register.range is not None:
        allowed = f"{register.range[0]}..{register.range[1]}"
    else:
        allowed = "|".join(map(str, register.choices or ())) or "-"
    fields = (
        register.address, register.size, register.name, register.access.value, register.memory.value,
        "-" if register.sign_bit is None else register.sign_bit, allowed,
        "-" if register.default is None else register.default, f"{register.scale:.8g}", register.unit)
    return " ".join(map(str, fields)).rstrip()


@EVERY
def test_every_register(name: str) -> None:
    expected = [" ".join(line.split()) for line in (STS_TABLE if name in STS else SCS_TABLE).strip().splitlines()]
    different = DIFFERENT[name]
    for index, line in enumerate(expected):
        register, fields = line.split()[2], line.split()
        if register in different:
            default, scale = different[register]
            fields[7:9] = ["-" if default is None else str(default), f"{scale:.8g}"]
            expected[index] = " ".join(fields)
    rows = sorted(MODELS[name].registers, key=lambda register: register.address)
    assert [row_text(row) for row in rows] == expected
    assert {row.byte_order for row in rows} == {"little" if name in STS else "big"}
    assert not any(row.signed for row in rows), "nothing here is in two's complement"


@EVERY
def test_the_bits_of_the_status(name: str) -> None:
    sts = ("voltage", "position sensor", "overheating", "overcurrent", None, "overload")
    scs = ("voltage", None, "overheating", None, None, "overload")
    rows = {row.name: row.flags for row in MODELS[name].registers if row.flags}
    named = ("unloading_condition", "led_alarm_condition", "hardware_error_status")
    assert rows == dict.fromkeys(named, sts if name in STS else scs)


@EVERY
def test_no_default_lies_outside_its_range(name: str) -> None:
    for row in MODELS[name].registers:
        if row.range is not None and row.default is not None:
            assert row.range[0] <= row.default <= row.range[1], row.name


@EVERY
def test_baud_rates_by_register_value(name: str) -> None:
    """From index 5 on, some lists lack 76800 and are off by one."""
    assert list(MODELS[name].baud_rates) == [1_000_000, 500_000, 250_000, 128_000, 115_200, 76_800, 57_600, 38_400]


@pytest.mark.parametrize(
    ("name", "number", "ticks", "span_deg", "centre"),
    [("sts3215", 777, 4096, 360, 2048), ("sts3215-12v", 777, 4096, 360, 2048), ("sts3250", 2825, 4096, 360, 2048),
     ("scs0009", 1284, 1024, 300, 512), ("scs15", 1295, 1024, 215, 512)])
def test_identity_and_encoder(name: str, number: int, ticks: int, span_deg: float, centre: int) -> None:
    model = MODELS[name]
    assert (model.model_number, model["model_number"].default) == (number, number)
    assert (model.encoder.ticks, model.encoder.span_deg, model.encoder.centre) == (ticks, span_deg, centre)
    assert model["present_velocity"].scale == pytest.approx(span_deg / 360.0 / ticks, rel=1e-7), "step/s"
    assert model["goal_velocity"].scale == model["present_velocity"].scale


@pytest.mark.parametrize(
    ("name", "points", "mass_g", "gear_ratio"), [
        ("sts3215", [(7.4, 1.91, None, 52)], 55, 345),
        ("sts3215-12v", [(12.0, 2.94, 2.7, 45)], 55, 345),
        ("sts3250", [(12.0, 4.903, 4.2, 75)], 75, 345),
        ("scs0009", [(6.0, 0.2256, None, 100)], 13, 275),
        ("scs15", [(7.4, 1.618, None, 65), (6.0, 1.471, None, 55), (8.4, 1.667, None, 73)], 56, 275)])
def test_specification(
    name: str, points: list[tuple[float, float, float | None, float]], mass_g: float, gear_ratio: float
) -> None:
    sheet = MODELS[name].specification
    assert [
        (point.voltage_v, point.stall_torque_nm, point.stall_current_a, point.no_load_rpm)
        for point in (sheet.rated, *sheet.others)] == points
    assert (sheet.mass_g, sheet.gear_ratio) == (mass_g, gear_ratio)


@pytest.mark.parametrize(
    ("name", "motor", "divisor"), [
        ("sts3215", (1.211641, 2.676166, 0.028403, 0.052393, 0.059085), 3.927),
        ("sts3215-12v", (2.1970, 8.5460, 0.028403, 0.052393, 0.059085), 3.927),
        ("sts3250", (1.0920, 2.5230, 0.0245, 0.1345, 0.1517), 3.927),
        ("scs0009", (0.3770, 9.7612, 0.00075, 0.00619, 0.00698), 0.25),
        ("scs15", (0.8353, 3.7182, 0.0097, 0.0444, 0.0501), 0.25)])
def test_motor(name: str, motor: tuple[float, ...], divisor: float) -> None:
    model, ours = MODELS[name], MODELS[name].motor
    assert motor == (
        ours.torque_constant_nm_per_a, ours.resistance_ohm, ours.armature_kgm2, ours.friction.coulomb_nm,
        ours.friction.viscous_nms)
    loop = model.position_loop
    assert (loop.proportional, loop.divisor, loop.pwm_full_scale) == ("position_p_gain", divisor, 1000)


# What no manual states, in every file, with its reason.
ASSUMED = {
    "integral_s": 0.01, "derivative_s": 0.001, "derivative_gain": False, "later_ids_answer": False,
    "answers_at_new_setting": False, "turnaround_us": 0, "eeprom_write_ms": 0, "reboot_s": 0.3,
    "torque_at_power_up": False, "reboot": False, "recovery_keeps_id": True, "overload_clears_on_new_goal": True,
    "torque_flag_in_status": False, "temperature_c": 30}
ASSUMED_OF_STS = {
    "largest_duty": 0.97, "velocity_divisor": 4000, "broadcast_ping": True, "damping": False, "calibrate": False,
    "centre_outlives_lock": False}
ASSUMED_OF_SCS = {"largest_duty": 1.0, "pwm_goal": "goal_time", "speed_0_stops": False, "broadcast_ping": False}
SLEW = {"sts3215": 3400, "sts3215-12v": 3400, "sts3250": 5100, "scs0009": 2050, "scs15": 1860}


@EVERY
def test_what_is_assumed(name: str) -> None:
    assert MODELS[name].firmware.model_dump(exclude={"kind"}) == {
        **ASSUMED, **(ASSUMED_OF_STS if name in STS else ASSUMED_OF_SCS), "goal_slew_steps_s": SLEW[name]}
    assert MODELS[name].backup_firmware is None


@EVERY
def test_what_the_exchange_uses(name: str) -> None:
    model = MODELS[name]
    cyclic = model.cyclic
    assert (model.feedback.address, model.feedback.size) == (56, 6)
    assert (cyclic.goal, cyclic.effort, cyclic.velocity, cyclic.position, cyclic.effort_full_scale) == (
        "goal_position", "present_load", "present_velocity", "present_position", 1000)
    telemetry = cyclic.telemetry
    assert (telemetry.torque, telemetry.error, telemetry.voltage, telemetry.temperature) == (
        "torque_enable", "hardware_error_status", "present_input_voltage", "present_temperature")
    if name in STS:
        assert (model.protocol, model.sync_read, cyclic.torque_cap, telemetry.current) == (
            "feetech-sts", True, "torque_limit", "present_current")
        assert model.arming.require == {"operating_mode": 0, "status_return_level": 1}
        assert model.arming.set == {"lock": 1, "acceleration": 0, "goal_velocity": 0}
    else:
        assert (model.protocol, model.sync_read, cyclic.torque_cap, telemetry.current) == (
            "feetech-scs", False, "max_torque_limit", None)
        assert model.arming.set == {
            "lock": 1, "goal_time": 0, "goal_velocity": 0}, "a limit is not to wear the EEPROM"
    assert model.arming.position_limits == ("min_position_limit", "max_position_limit")
    assert {"unloading_condition", "phase", "position_p_gain"} <= model.arming.explain.keys()
    for register, usual in model.arming.explain.items():
        assert usual == model[register].default
    assert model.watchdog is None
    assert model.fast_sync_read_firmware is None
    assert protocol_of(model) is not None


# Names in rustypot that differ from ours.
RENAMED = {
    "firmware_major_version": "firmware_major", "firmware_minor_version": "firmware_minor",
    "response_status_level": "status_return_level", "p_coefficient": "position_p_gain",
    "i_coefficient": "position_i_gain", "d_coefficient": "position_d_gain", "minimum_startup_force":
    "minimum_start_force", "homing_offset": "position_offset", "over_current_protection_time": "over_current_time",
    "speed_closed_loop_p_coefficient": "velocity_p_gain", "velocity_closed_loop_i_coefficient": "velocity_i_gain",
    "present_voltage": "present_input_voltage", "status": "hardware_error_status",
    "sync_write_flag": "registered_instruction", "moving_velocity_threshold": "moving_threshold", "dts": "dts_ms",
    "hts": "hts_ns", "velocity_unit_factor": "velocity_unit", "maximum_velocity_limit": "max_velocity_limit",
    "maximum_acceleration": "max_acceleration",
}


@pytest.mark.parametrize(
    ("name", "controller", "theirs_alone"), [
        # One name for 44 in either mode; present_current has no sign there.
        ("sts3215", "Sts3215PyController", {"goal_time"}),
        # In its source alone.
        ("scs0009", "Scs0009PyController", {
            "acceleration", "pwm_maximum_step", "moving_threshold", "dts_ms", "minimum_velocity_limit",
            "max_velocity_limit"})])
def test_rustypot_lays_out_the_same(name: str, controller: str, theirs_alone: set[str]) -> None:
    theirs = {}
    for row in getattr(rustypot, controller).registers():
        sign = row.sign_bit if row.encoding == "sign_magnitude" else None
        theirs[RENAMED.get(row.name, row.name)] = (row.addr, row.size, sign)
    model = MODELS[name]
    shared = [row for row in model.registers if row.name in theirs]
    assert {row.name: (row.address, row.size, row.sign_bit) for row in shared if row.name != "present_current"} == {
        row.name: theirs[row.name] for row in shared if row.name != "present_current"}
    aliases = {
        "model", "baudrate", "offset", "mode", "min_angle_limit", "max_angle_limit", "goal_speed", "present_speed",
        "hysteresis_loop"}
    assert set(theirs) - set(model.by_name) - aliases == theirs_alone
    ours_alone = {
        "sts3215": {"big_endian", "goal_pwm", "registered_instruction", "goal_position_echo"}, "scs0009": set()}
    assert set(model.by_name) - set(theirs) == ours_alone[name]
    assert getattr(rustypot, controller).word_order() == model.byte_order
