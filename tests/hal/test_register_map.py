"""The bundled XL430-W250 against the control table that ROBOTIS ships, and what a servo file may not say."""

import re
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import ValidationError

from hal.encoding import pack, unpack
from hal.register_map import Register, ServoModel

TEXT = (Path(__file__).parents[2] / "configs/servos/xl430-w250.yaml").read_text(encoding="utf-8")
SERVO = ServoModel.model_validate(yaml.safe_load(TEXT))

# Names in dynamixel_easy_sdk's table that differ from the e-Manual's, which we follow.
RENAMED = {
    "secondary_shadow_id": "secondary_id",
    # Where that package's own indirect helpers begin: another name for the first row of either block.
    "indirect_address_write": "indirect_address_1",
    "indirect_data_write": "indirect_data_1",
    "indirect_address_read": "indirect_address_29",
    "indirect_data_read": "indirect_data_29",
}


def sdk_sections() -> dict[str, list[list[str]]]:
    """Return the rows under each `[heading]` of the SDK's file, split at tabs."""
    text = files("dynamixel_easy_sdk").joinpath("control_table/xl430_w250.model").read_text(encoding="utf-8")
    sections: dict[str, list[list[str]]] = {}
    for line in filter(None, map(str.strip, text.splitlines())):
        if line.startswith("["):
            rows = sections.setdefault(line.strip("[]"), [])
        else:
            rows.append(line.split("\t"))
    return sections


def our_name(sdk_name: str) -> str:
    name = re.sub(r"[^a-z0-9]+", "_", sdk_name.lower()).strip("_")
    return RENAMED.get(name, name)


SDK = sdk_sections()
SDK_ROWS = [(our_name(name), int(address), int(size)) for address, size, name in SDK["control table"][1:]]


class TestAgainstTheSdksTable:
    @pytest.mark.parametrize(("name", "address", "size"), SDK_ROWS)
    def test_address_and_size(self, name: str, address: int, size: int) -> None:
        assert (SERVO[name].address, SERVO[name].size) == (address, size)

    def test_we_have_more_only_where_its_table_is_short(self) -> None:
        """Two registers of firmware 45 and later; of the indirect blocks it names the first rows only."""
        ours = {name for name in SERVO.by_name if not name.startswith("indirect_")}
        assert ours - {name for name, _, _ in SDK_ROWS} == {"startup_configuration", "backup_ready"}

    def test_centre(self) -> None:
        [centre] = [row[1] for row in SDK["type info"] if row[0] == "value_of_zero_radian_position"]
        assert SERVO.encoder.centre == int(centre)

    @pytest.mark.parametrize(("name", "value", "unit", "sign"), SDK["unit info"][1:])
    def test_velocity_unit(self, name: str, value: str, unit: str, sign: str) -> None:
        """It has 0.22889 rpm where the e-Manual, and we, have 0.229."""
        register = SERVO[our_name(name)]
        assert (unit, register.unit) == ("rad/s", "rpm")
        assert register.scale * 2 * 3.14159265 / 60 == pytest.approx(float(value), rel=1e-3)
        assert register.signed == (sign == "signed")


@pytest.mark.parametrize(
    ("name", "address", "size", "signed", "unit", "scale"),
    [
        ("model_number", 0, 2, False, "", 1),
        ("return_delay_time", 9, 1, False, "us", 2),
        ("homing_offset", 20, 4, True, "pulse", 1),
        ("torque_enable", 64, 1, False, "", 1),
        ("hardware_error_status", 70, 1, False, "", 1),
        ("bus_watchdog", 98, 1, False, "ms", 20),
        ("goal_pwm", 100, 2, True, "%", 0.113),
        ("profile_acceleration", 108, 4, False, "rev/min^2", 214.577),
        ("goal_position", 116, 4, True, "pulse", 1),
        ("present_load", 126, 2, True, "%", 0.1),
        ("present_velocity", 128, 4, True, "rpm", 0.229),
        ("present_position", 132, 4, True, "pulse", 1),
        ("present_input_voltage", 144, 2, False, "V", 0.1),
        ("present_temperature", 146, 1, False, "degC", 1),
        ("indirect_address_28", 222, 2, False, "", 1),
        ("indirect_data_28", 251, 1, False, "", 1),
        ("indirect_address_56", 632, 2, False, "", 1),
        ("indirect_data_56", 661, 1, False, "", 1),
    ],
)
def test_row_of_the_manual(name: str, address: int, size: int, signed: bool, unit: str, scale: float) -> None:
    row = SERVO[name]
    assert (row.address, row.size, row.signed, row.unit, row.scale) == (address, size, signed, unit, scale)


def test_identity_and_encoder() -> None:
    assert SERVO.model_number == SERVO["model_number"].default == 1060
    assert SERVO.fast_sync_read_firmware == 45
    assert SERVO.encoder.ticks == 4096
    assert SERVO.encoder.radians_per_tick == pytest.approx(0.0015339808)


def test_no_default_lies_outside_its_range() -> None:
    for row in SERVO.registers:
        if row.range is not None and row.default is not None:
            assert row.range[0] <= row.default <= row.range[1], row.name


class TestRefused:
    def change(self, **row: Any) -> dict[str, Any]:
        """Return the file's content with a row more."""
        content: dict[str, Any] = yaml.safe_load(TEXT)
        content["registers"].append({"size": 1, "access": "rw", "memory": "ram", **row})
        return content

    def test_overlap(self) -> None:
        content = self.change(name="extra", address=119)
        with pytest.raises(ValidationError, match="registers goal_position and extra overlap at address 119"):
            ServoModel.model_validate(content)

    def test_duplicate_name(self) -> None:
        content = self.change(name="led", address=1000)
        with pytest.raises(ValidationError, match=r"register names must be unique: \['led'\]"):
            ServoModel.model_validate(content)

    def test_unknown_key(self) -> None:
        content = self.change(name="extra", address=1000, adress=1)
        with pytest.raises(ValidationError, match=r"registers\.\d+\.adress\n +Extra inputs are not"):
            ServoModel.model_validate(content)

    @pytest.mark.parametrize("scale", [float("nan"), float("inf")])
    def test_not_a_number(self, scale: float) -> None:
        content = self.change(name="extra", address=1000, scale=scale)
        with pytest.raises(ValidationError, match=r"registers\.\d+\.scale\n +Input should be a finite"):
            ServoModel.model_validate(content)

    def test_cyclic_register_that_is_absent(self) -> None:
        content = yaml.safe_load(TEXT)
        content["cyclic"]["effort"] = "present_current"
        with pytest.raises(ValidationError, match="no register is named 'present_current'"):
            ServoModel.model_validate(content)


class TestEncoding:
    @pytest.mark.parametrize(
        ("name", "value", "data"),
        [
            ("goal_position", 2048, "00 08 00 00"),
            ("goal_position", -1, "FF FF FF FF"),
            ("present_load", -1000, "18 FC"),
            ("present_load", 1000, "E8 03"),
            ("model_number", 65535, "FF FF"),
            ("id", 252, "FC"),
        ],
    )
    def test_bytes_on_the_wire(self, name: str, value: int, data: str) -> None:
        assert pack(SERVO[name], value) == bytes.fromhex(data)
        assert unpack(SERVO[name], bytes.fromhex(data)) == value

    def test_signed_single_byte(self) -> None:
        row = Register.model_validate(
            {"name": "small", "address": 0, "size": 1, "access": "rw", "memory": "ram", "signed": True}
        )
        assert unpack(row, b"\x80") == -128
        assert pack(row, -1) == b"\xff"

    @pytest.mark.parametrize(
        ("name", "value", "complaint"),
        [
            ("id", 256, "id: 256 does not fit into 8 bits, unsigned"),
            ("id", -1, "id: -1 does not fit into 8 bits, unsigned"),
            ("present_load", 32768, "present_load: 32768 does not fit into 16 bits, signed"),
        ],
    )
    def test_refuses_what_does_not_fit(self, name: str, value: int, complaint: str) -> None:
        with pytest.raises(ValueError, match=complaint):
            pack(SERVO[name], value)

    def test_refuses_another_length(self) -> None:
        with pytest.raises(ValueError, match="goal_position: expected 4 bytes, got 2"):
            unpack(SERVO["goal_position"], b"\x00\x08")
