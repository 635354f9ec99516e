"""What a servo file may not say, and how values become bytes."""

from copy import deepcopy
from typing import Any

import pytest
from pydantic import ValidationError

from hal.encoding import pack, unpack
from hal.register_map import Register, ServoModel
from robotwalk.assembly import load_servo
from robotwalk.config import library

SERVO = load_servo("xl430-w250")


def content() -> dict[str, Any]:
    """Return what the servo's file says, anew."""
    found: dict[str, Any] = deepcopy(library.open_document("servos", "xl430-w250").value(()))
    return found


@pytest.mark.parametrize("name", library.names("servos"))
def test_no_default_lies_outside_its_range(name: str) -> None:
    for row in load_servo(name).registers:
        if row.range is not None and row.default is not None:
            assert row.range[0] <= row.default <= row.range[1], row.name


class TestRefused:
    def change(self, **row: Any) -> dict[str, Any]:
        """Return the file's content with a row more."""
        changed = content()
        changed["registers"].append({"size": 1, "access": "rw", "memory": "ram", **row})
        return changed

    def test_overlap(self) -> None:
        changed = self.change(name="extra", address=119)
        with pytest.raises(ValidationError, match="registers goal_position and extra overlap at address 119"):
            ServoModel.model_validate(changed)

    def test_duplicate_name(self) -> None:
        changed = self.change(name="led", address=1000)
        with pytest.raises(ValidationError, match=r"register names must be unique: \['led'\]"):
            ServoModel.model_validate(changed)

    def test_unknown_key(self) -> None:
        changed = self.change(name="extra", address=1000, adress=1)
        with pytest.raises(ValidationError, match=r"registers\.\d+\.adress\n +Extra inputs are not"):
            ServoModel.model_validate(changed)

    @pytest.mark.parametrize("scale", [float("nan"), float("inf")])
    def test_not_a_number(self, scale: float) -> None:
        changed = self.change(name="extra", address=1000, scale=scale)
        with pytest.raises(ValidationError, match=r"registers\.\d+\.scale\n +Input should be a finite"):
            ServoModel.model_validate(changed)

    def test_cyclic_register_that_is_absent(self) -> None:
        changed = content()
        changed["cyclic"]["effort"] = "present_current"
        with pytest.raises(ValidationError, match="no register is named 'present_current'"):
            ServoModel.model_validate(changed)

    def test_older_firmware_with_a_register_in_the_way(self) -> None:
        changed = content()
        row = {"name": "extra", "address": 64, "size": 1, "access": "rw", "memory": "ram"}
        changed["older_firmware"] = [{"below": 40, "registers": [row]}]
        with pytest.raises(ValidationError, match=r"below firmware 40, registers torque_enable and extra overlap at"):
            ServoModel.model_validate(changed)


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
