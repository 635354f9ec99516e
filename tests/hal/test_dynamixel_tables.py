"""Every number in the tables of the bundled Dynamixels with Protocol 2.0.

Against the files that ROBOTIS ships in dynamixel_easy_sdk, and against the e-Manual's pages, copied here by hand.
"""

import itertools
import re
from collections.abc import Iterator
from importlib.resources import files
from typing import NamedTuple

import pytest

from hal.register_map import OperatingPoint, Register, ServoModel
from robotwalk.assembly import load_servo
from robotwalk.config import library

X330 = ("xl330-m288", "xl330-m077", "xc330-m288")
X430 = ("xl430-w250", "xm430-w350", "mx-28")
MODELS = {name: load_servo(name) for name in X330 + X430}

# Names in ROBOTIS's files that differ from the e-Manual's, which we follow.
RENAMED = {
    "secondary_shadow_id": "secondary_id",
    # Where that package's own indirect helpers begin: another name for a row.
    "indirect_address_write": "indirect_address_1",
    "indirect_data_write": "indirect_data_1",
}
READ_FROM = {"xl330": 7, "xc330": 7, "xl430": 29, "xm430": 29, "mx": 29}  # the row that their reads begin with


class Theirs(NamedTuple):
    """One of ROBOTIS's files, and what we hold against it."""

    file: str
    model: ServoModel
    sections: dict[str, list[list[str]]]  # by heading, the rows split at tabs

    @property
    def rows(self) -> list[tuple[str, int, int]]:
        return [(self.our_name(name), int(at), int(size)) for at, size, name in self.sections["control table"][1:]]

    def our_name(self, name: str) -> str:
        name = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
        first = READ_FROM[self.file.split("_")[0]]
        return RENAMED.get(name) or re.sub(r"^indirect_(address|data)_read$", rf"indirect_\1_{first}", name)


def theirs() -> Iterator[Theirs]:
    """Return the files of our models; of the X330 there are two, `_fw52` for that firmware and later."""
    folder = files("dynamixel_easy_sdk").joinpath("control_table")
    for name, model in MODELS.items():
        stem = name.replace("-", "_")
        for file, ours in [(stem, model.at_firmware(51)), (f"{stem}_fw52", model.at_firmware(52))]:
            path = folder.joinpath(f"{file}.model")
            if not path.is_file():
                assert name in X430, f"{file} should be there"
                continue
            sections: dict[str, list[list[str]]] = {}
            for line in filter(None, map(str.strip, path.read_text(encoding="utf-8").splitlines())):
                if line.startswith("["):
                    rows = sections.setdefault(line.strip("[]"), [])
                else:
                    rows.append(line.split("\t"))
            yield Theirs(file, ours, sections)


THEIRS = list(theirs())


@pytest.mark.parametrize("table", THEIRS, ids=[table.file for table in THEIRS])
class TestAgainstRobotisFiles:
    def test_addresses_and_sizes(self, table: Theirs) -> None:
        assert {(name, table.model[name].address, table.model[name].size) for name, *_ in table.rows} == set(table.rows)

    def test_we_have_more_only_where_its_table_is_short(self, table: Theirs) -> None:
        """Registers of later firmware; of the indirect blocks it names the first rows only."""
        ours = {name for name in table.model.by_name if not name.startswith("indirect_")}
        later = set() if table.file == "mx_28" else {"startup_configuration", "backup_ready"}
        assert ours - {name for name, *_ in table.rows} == later

    def test_centre(self, table: Theirs) -> None:
        values = {row[0]: row[1] for row in table.sections["type info"]}
        assert table.model.encoder.centre == int(values["value_of_zero_radian_position"])
        assert table.model.encoder.ticks == int(values["value_of_max_radian_position"]) + 1

    def test_signs_and_units(self, table: Theirs) -> None:
        """It has 0.22889 rpm where the e-Manual, and we, have 0.229; a current is raw there."""
        for name, value, unit, sign in table.sections["unit info"][1:]:
            register = table.model[table.our_name(name)]
            assert register.signed == (sign == "signed")
            assert register.unit == {"rad/s": "rpm", "raw": "mA"}[unit]
            if unit == "rad/s":
                assert register.si_scale == pytest.approx(float(value), rel=1e-3)


def test_robotis_has_a_file_for_each_model_and_two_for_the_x330() -> None:
    assert len(THEIRS) == 9


# Each row of the manuals: address, size, r or rw, eeprom or ram, u(nsigned) or s(igned), name, unit of one count; then
# for the X330s, XL430, XM430 and MX-28: default@lowest..highest, only what there is of it; = as to the left; . absent.
MANUAL = """
  0 2 r  eeprom u model_number           -                 *              1060        1020         30
  2 4 r  eeprom u model_information      -                 0              =           =            =
  6 1 r  eeprom u firmware_version       -                 -              =           =            =
  7 1 rw eeprom u id                     -                 1@0..252       =           =            =
  8 1 rw eeprom u baud_rate              -                 1@0..6         1@0..7      =            =
  9 1 rw eeprom u return_delay_time      2_us              250@0..254     =           =            =
 10 1 rw eeprom u drive_mode             -                 0@0..13        =           =            0@0..5
 11 1 rw eeprom u operating_mode         -                 3@0..16        3@1..16     3@0..16      3@1..16
 12 1 rw eeprom u secondary_id           -                 255@0..255     =           =            =
 13 1 rw eeprom u protocol_type          -                 2@2..22        2@1..2      =            =
 20 4 rw eeprom s homing_offset          1_pulse           0@-1044479..1044479 =           =            =
 24 4 rw eeprom u moving_threshold       0.229_rpm         10@0..1023     =           =            =
 31 1 rw eeprom u temperature_limit      1_degC            70@0..100      72@0..100   80@0..100    =
 32 2 rw eeprom u max_voltage_limit      0.1_V             70@31..70      140@60..140 160@95..160  =
 34 2 rw eeprom u min_voltage_limit      0.1_V             35@31..70      60@60..140  95@95..160   =
 36 2 rw eeprom u pwm_limit              0.113_%           885@0..885     =           =            =
 38 2 rw eeprom u current_limit          1_mA|2.69_mA      1750@0..1750   .           1193@0..1193 .
 40 4 rw eeprom u acceleration_limit     214.577_rev/min^2 .              .           .            32767@0..32767
 44 4 rw eeprom u velocity_limit         0.229_rpm         445@0..2047    265@0..1023 200@0..1023  230@0..1023
 48 4 rw eeprom u max_position_limit     1_pulse           4095@0..4095   =           =            =
 52 4 rw eeprom u min_position_limit     1_pulse           0@0..4095      =           =            =
 60 1 rw eeprom u startup_configuration  -                 0@0..3         =           =            .
 62 1 rw eeprom u pwm_slope              1.977_mV/ms       140@1..255     .           .            .
 63 1 rw eeprom u shutdown               -                 53@0..255      52@0..255   =            =
 64 1 rw ram    u torque_enable          -                 0@0..1         =           =            =
 65 1 rw ram    u led                    -                 0@0..1         =           =            =
 68 1 rw ram    u status_return_level    -                 2@0..2         =           =            =
 69 1 r  ram    u registered_instruction -                 0              =           =            =
 70 1 r  ram    u hardware_error_status  -                 0              =           =            =
 76 2 rw ram    u velocity_i_gain        -                 1600@0..16383  1000@0..16383 1920@0..16383 =
 78 2 rw ram    u velocity_p_gain        -                 180@0..16383   100@0..16383 =            =
 80 2 rw ram    u position_d_gain        -                 0@0..16383     4000@0..16383 0@0..16383   =
 82 2 rw ram    u position_i_gain        -                 0@0..16383     =           =            =
 84 2 rw ram    u position_p_gain        -                 400@0..16383   640@0..16383 800@0..16383 850@0..16383
 88 2 rw ram    u feedforward_2nd_gain   -                 0@0..16383     =           =            =
 90 2 rw ram    u feedforward_1st_gain   -                 0@0..16383     =           =            =
 98 1 rw ram    u bus_watchdog           20_ms             0@0..127       =           =            =
100 2 rw ram    s goal_pwm               0.113_%           -@-885..885    =           =            =
102 2 rw ram    s goal_current           1_mA|2.69_mA      -@-1750..1750  .           -@-1193..1193 .
104 4 rw ram    s goal_velocity          0.229_rpm         -@-2047..2047  -@-1023..1023 =            =
108 4 rw ram    u profile_acceleration   214.577_rev/min^2 0@0..32767     =           =            =
112 4 rw ram    u profile_velocity       0.229_rpm         0@0..32767     =           =            =
116 4 rw ram    s goal_position          1_pulse           -@-1048575..1048575 =           =            =
120 2 r  ram    u realtime_tick          1_ms              -              =           =            =
122 1 r  ram    u moving                 -                 0              =           =            =
123 1 r  ram    u moving_status          -                 0              =           =            =
124 2 r  ram    s present_pwm            0.113_%           -              =           =            =
126 2 r  ram    s present_current        1_mA|2.69_mA      -              .           -            .
126 2 r  ram    s present_load           0.1_%             .              -           .            -
128 4 r  ram    s present_velocity       0.229_rpm         -              =           =            =
132 4 r  ram    s present_position       1_pulse           -              =           =            =
136 4 r  ram    s velocity_trajectory    0.229_rpm         -              =           =            =
140 4 r  ram    s position_trajectory    1_pulse           -              =           =            =
144 2 r  ram    u present_input_voltage  0.1_V             -              =           =            =
146 1 r  ram    u present_temperature    1_degC            -              =           =            =
147 1 r  ram    u backup_ready           -                 0              =           =            .
"""
COLUMNS = {**dict.fromkeys(X330, 0), "xl430-w250": 1, "xm430-w350": 2, "mx-28": 3}
NUMBERS = {"xl330-m288": 1200, "xl330-m077": 1190, "xc330-m288": 1240, "xl430-w250": 1060, "xm430-w350": 1020,
           "mx-28": 30}


def manual(name: str) -> set[str]:
    """Return what the manual says of each register of a model, in the words of `ours`."""
    rows = set()
    for line in MANUAL.strip().splitlines():
        *what, register, unit, first, second, third, fourth = line.split()
        cells = [first]
        for cell in (second, third, fourth):
            cells.append(cells[-1] if cell == "=" else cell)
        cell = cells[COLUMNS[name]].replace("*", str(NUMBERS[name]))
        if cell != ".":
            if "|" in unit:
                unit = unit.split("|")[COLUMNS[name] != 0]
            rows.add(" ".join((*what, register, unit, cell)))
    return rows


def ours(register: Register) -> str:
    plain = not register.unit and register.scale == 1.0
    unit = "-" if plain else f"{register.scale:.9g}_{register.unit}"
    cell = "-" if register.default is None else str(register.default)
    if register.range is not None:
        cell += f"@{register.range[0]}..{register.range[1]}"
    sign = "s" if register.signed else "u"
    return " ".join(map(str, (
        register.address, register.size, register.access, register.memory, sign, register.name, unit, cell)))


@pytest.mark.parametrize("name", MODELS)
class TestAgainstTheManual:
    def test_every_register(self, name: str) -> None:
        rows = {ours(row) for row in MODELS[name].registers if not row.name.startswith("indirect_")}
        assert rows == manual(name)
        assert {row.sign_bit for row in MODELS[name].registers} == {None}, "two's complement throughout"

    def test_indirect_access(self, name: str) -> None:
        """Every address starts as that of the data byte of its number."""
        x330 = [(1, 20, 168, 208)], (64, 227)
        x430 = [(1, 28, 168, 224), (29, 56, 578, 634)], (64, 661)
        self.check_indirect(MODELS[name], *(x330 if name in X330 else x430))

    def test_indirect_access_of_older_firmware(self, name: str) -> None:
        if name in X330:
            self.check_indirect(MODELS[name].at_firmware(51), [(1, 28, 168, 224)], (64, 251))
            assert MODELS[name].at_firmware(52) is MODELS[name]
        else:
            self.check_indirect(MODELS[name].at_firmware(0), [(1, 28, 168, 224), (29, 56, 578, 634)], (64, 661))

    def test_what_came_with_later_firmware(self, name: str) -> None:
        model = MODELS[name]
        if name == "mx-28":
            assert model.at_firmware(0) is model
            return
        first = 46 if name in X330 else 45
        before = model.at_firmware(first - 1)
        absent = {"backup_ready"} if name in X330 else {"backup_ready", "startup_configuration"}
        assert model.at_firmware(first).by_name.keys() - before.by_name.keys() == absent
        assert before["drive_mode"].choices == (0, 1, 4, 5)
        assert ours(before["drive_mode"]) == "10 1 rw eeprom u drive_mode - 0@0..5"
        if name in X330:  # no backup to start from
            assert ours(before["startup_configuration"]) == "60 1 rw eeprom u startup_configuration - 0@0..1"
        assert "bus_watchdog" in model.at_firmware(38).by_name
        assert ("bus_watchdog" in model.at_firmware(37).by_name) == (name in X330)

    def check_indirect(
        self, model: ServoModel, blocks: list[tuple[int, int, int, int]], reach: tuple[int, int]
    ) -> None:
        expected = set()
        for first, last, addresses, data in blocks:
            for number in range(first, last + 1):
                at = data + number - first
                expected.add(
                    f"{addresses + 2 * (number - first)} 2 rw ram u indirect_address_{number} - "
                    f"{at}@{reach[0]}..{reach[1]}")
                expected.add(f"{at} 1 rw ram u indirect_data_{number} - 0")
        assert {ours(row) for row in model.registers if row.name.startswith("indirect_")} == expected

    def test_identity(self, name: str) -> None:
        model = MODELS[name]
        assert (model.name, model.model_number) == (name, NUMBERS[name])
        bauds = [9600, 57600, 115200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000]
        assert list(model.baud_rates) == bauds[:7 if name in X330 else 8]
        first = 46 if name in X330 else None if name == "mx-28" else 45
        assert (model.fast_sync_read_firmware, model.backup_firmware) == (first, first)
        assert (model.encoder.ticks, model.encoder.centre) == (4096, 2048)
        assert model.encoder.radians_per_tick == pytest.approx(0.0015339808)
        assert (model.byte_order, model.sync_read) == ("little", True)

    def test_firmware(self, name: str) -> None:
        """Of the version the manual speaks; the other switches are assumptions, which its file explains."""
        assert MODELS[name].firmware.model_dump(exclude={"kind"}) == {
            "version": 52 if name in X330 else 45, "time_base_hz": 1000, "velocity_p_divisor": 128,
            "velocity_i_divisor": 65536, "derivative_gain": False,
            "goal_follows_present": False, "later_ids_answer": False, "answers_at_new_setting": False,
            "turnaround_us": 0.0, "watchdog_holds": True, "watchdog_forgets_offset": False,
            "shock_at_power_up": False, "following_error_ticks": 100, "reboot_s": 0.3, "overload_duty": 0.8,
            "overload_s": 2.0, "temperature_c": 30.0}

    def test_choices(self, name: str) -> None:
        model = MODELS[name]
        currents = "current_limit" in model.by_name
        assert model["operating_mode"].choices == ((0, 1, 3, 4, 5, 16) if currents else (1, 3, 4, 16))
        assert model["drive_mode"].choices == ((0, 1, 4, 5) if name == "mx-28" else (0, 1, 4, 5, 8, 9, 12, 13))
        assert model["protocol_type"].choices == ((2, 20, 21, 22) if name in X330 else None)

    def test_flags(self, name: str) -> None:
        faults = ("input voltage", None, "overheating", "motor encoder", "electrical shock", "overload")
        assert {row.name: row.flags for row in MODELS[name].registers if row.flags} == {
            "shutdown": faults, "hardware_error_status": faults}

    def test_what_is_read_and_written_in_every_tick(self, name: str) -> None:
        model = MODELS[name]
        cyclic, telemetry = model.cyclic, model.cyclic.telemetry
        effort = "present_current" if "current_limit" in model.by_name else "present_load"
        full = {"xl430-w250": 1000, "mx-28": 1000, "xm430-w350": 1193}.get(name, 1750)
        assert (cyclic.goal, cyclic.torque_cap) == ("goal_position", "goal_pwm")
        assert (cyclic.effort, cyclic.effort_full_scale) == (effort, full)
        assert (model.feedback.address, model.feedback.size) == (126, 10)
        assert model.arming.require == {"operating_mode": 3, "drive_mode": 0, "homing_offset": 0}
        assert model.arming.set == {
            "status_return_level": 2, "profile_velocity": 0, "profile_acceleration": 0,
            **{gain: model[gain].default for gain in GAINS}}
        assert model.watchdog == (model["bus_watchdog"], 10), "200 ms"
        assert model.arming.explain == {name: model[name].default for name in ("shutdown", "pwm_limit")}
        assert model.arming.position_limits == ("min_position_limit", "max_position_limit")
        assert model.arming.restart_clears == ("overload",)
        assert telemetry.names == (
            "torque_enable", "hardware_error_status", "present_input_voltage", "present_temperature",
            *(["present_current"] if effort == "present_current" else []))
        loop = model.position_loop
        assert (loop.proportional, loop.divisor) == ("position_p_gain", 256 if name in X330 else 128)
        assert loop.pwm_full_scale == 885


GAINS = (
    "position_p_gain", "position_i_gain", "position_d_gain", "feedforward_1st_gain", "feedforward_2nd_gain")

# Volts, N m, A, rpm at the rated voltage and beside it; grams; gear. From the e-Manual's specifications.
SHEETS = {
    "xl330-m288": ([(5, .52, 1.47, 103), (3.7, .42, 1.11, 76), (6, .60, 1.74, 123)], 18, 288.4),
    "xl330-m077": ([(5, .215, None, 383), (3.7, .180, None, 278), (6, .228, None, 456)], 18, 77.5),
    "xc330-m288": ([(5, .93, 1.80, 81), (3.7, .69, 1.34, 59), (6, 1.10, 2.15, 97)], 23, 288.35),
    "xl430-w250": ([(11.1, 1.4, 1.3, 57), (9, 1.0, 1.0, 47), (12, 1.5, 1.4, 61)], 57.2, 258.5),
    "xm430-w350": ([(12, 4.1, 2.3, 46), (11.1, 3.8, 2.1, 43), (14.8, 4.8, 2.7, 57)], 82, 353.5),
    "mx-28": ([(12, 2.5, None, 55), (11.1, 2.3, None, 50), (14.8, 3.1, None, 67)], 72, 193),
}


@pytest.mark.parametrize("name", MODELS)
class TestAgainstTheDataSheet:
    def test_specification(self, name: str) -> None:
        sheet = MODELS[name].specification
        points = [self.figures(point) for point in (sheet.rated, *sheet.others)]
        assert (points, sheet.mass_g, sheet.gear_ratio) == SHEETS[name]

    def figures(self, point: OperatingPoint) -> tuple[float | None, ...]:
        return point.voltage_v, point.stall_torque_nm, point.stall_current_a, point.no_load_rpm


def test_the_fit_is_the_published_one() -> None:
    motor = MODELS["xl330-m288"].motor
    assert (motor.torque_constant_nm_per_a, motor.resistance_ohm, motor.armature_kgm2) == (0.386171, 3.402573, 0.001895)
    assert list(motor.friction.model_dump().values()) == [
        "M4", 0.008759, 0.004621, 0.068034, 0, 0.073812, 2.557702, 0.760116]


def test_models_that_share_a_number_can_be_told_apart() -> None:
    models = [load_servo(name) for name in library.names("servos")]
    for one, other in itertools.combinations(models, 2):
        if one.model_number == other.model_number and one.frames == other.frames:
            assert one["max_voltage_limit"].default != other["max_voltage_limit"].default
