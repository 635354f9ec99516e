"""Every Feetech model on the bench, alone and side by side on one wire."""

import pytest
import scservo_sdk.scservo_def

from hal.maintenance.backup import problems
from hal.maintenance.identity import Identity
from hal.maintenance.scan import Progress
from hal.maintenance.vendor_sdk import Keep

from .rig import BAUD_57600, MODELS, Rig, mixed, rig

KNOWN = {model.name: model for model in MODELS}
FEETECH = [name for name, model in KNOWN.items() if model.protocol.startswith("feetech")]
EVERY = pytest.mark.parametrize("name", FEETECH)
SCS = pytest.mark.parametrize("name", ["scs15", "scs0009"])
TIME = "2026-11-22T12:00:00+00:00"


def found(built: Rig) -> list[Identity]:
    findings = [finding for finding in built.bench.scan() if not isinstance(finding, Progress)]
    assert all(isinstance(finding, Identity) for finding in findings), findings
    return [finding for finding in findings if isinstance(finding, Identity)]


@pytest.mark.parametrize(
    ("name", "protocol", "number", "firmware", "volts"), [
        ("sts3215", "feetech-sts", 777, "3.7", 7.4), ("sts3215-12v", "feetech-sts", 777, "3.7", 12.0),
        ("sts3250", "feetech-sts", 2825, "3.7", 12.0), ("scs15", "feetech-scs", 1295, "0.0", 7.4),
        ("scs0009", "feetech-scs", 1284, "0.0", 6.0)])
def test_it_tells_who_it_is(name: str, protocol: str, number: int, firmware: str, volts: float) -> None:
    assert found(rig(name, 7)) == [
        Identity(7, protocol, 1_000_000, False, number, KNOWN[name], firmware, pytest.approx(volts), 30.0)]


def test_all_are_found_on_one_wire() -> None:
    built = mixed(FEETECH, *range(1, 6))
    assert [(one.id, one.name) for one in found(built)] == list(enumerate(FEETECH, start=1))
    built.bench.servo(4).write("torque_enable", 1)
    built.bench.servo(1).write("torque_enable", 1)
    assert [str(servo) for servo in built.bench.torque_off()] == [
        f"id {i} ({name})" for i, name in enumerate(FEETECH, start=1)]
    assert [servo.table["torque_enable"] for servo in built.servos] == [0] * 5


@pytest.mark.parametrize("name", ["sts3215", "sts3215-12v"])
def test_of_one_number_and_another_voltage_limit_it_may_be_either(name: str) -> None:
    built = rig(name, 3, max_voltage_limit=126)
    identity = built.bench.ping(3).identity
    assert identity.name == "sts3215 or sts3215-12v"
    assert all(identity.may_be(KNOWN[twin]) for twin in ("sts3215", "sts3215-12v"))
    assert not identity.may_be(KNOWN["sts3250"])
    assert str(built.bench.servo(3)) == "id 3 (sts3215 or sts3215-12v)"


def test_with_the_voltage_limit_of_the_factory_it_is_one() -> None:
    identity = rig("sts3215-12v", 3).bench.ping(3).identity
    assert identity.may_be(KNOWN["sts3215-12v"])
    assert not identity.may_be(KNOWN["sts3215"])


def test_an_unknown_number_is_told_low_byte_first() -> None:
    built = rig("scs15", 9)
    built.servos[0].table["model_number"] = 0x0521
    assert built.bench.ping(9).identity.name == f"unknown (model number {0x2105})"


@EVERY
def test_every_register_is_read(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    values = servo.read_all(servo.model.registers)
    assert values == {row.name: built.servos[0].table[row.name] for row in servo.model.registers}
    assert values["max_position_limit"] == {"feetech-sts": 4095, "feetech-scs": 1023}[servo.model.protocol]


@EVERY
def test_what_is_written_into_the_eeprom_outlives_power_and_the_lock_is_closed(name: str) -> None:
    built = rig(name, 3)
    lock = {"feetech-sts": 55, "feetech-scs": 48}[KNOWN[name].protocol]
    built.bench.servo(3).write("max_position_limit", 0x0203)
    assert built.writes_to(11) == [bytes.fromhex("03 02" if lock == 55 else "02 03")]
    assert built.writes_to(lock) == [b"\0", b"\1"]
    built.servos[0].reboot(built.clock.now())
    assert built.servos[0].table["max_position_limit"] == 0x0203


@EVERY
def test_backup_and_restore(name: str) -> None:
    built = rig(name, 3)
    saved = built.bench.backup(built.bench.servo(3), TIME)
    assert (saved.model, saved.model_number) == (name, KNOWN[name].model_number)
    assert list(problems(saved, KNOWN[name])) == []
    servo = built.bench.servo(3)
    servo.write("min_position_limit", 100)
    servo.write("position_p_gain", 99)
    done = built.bench.restore(built.bench.servo(3), saved, with_id=False)
    assert {change.register.name: (change.before, change.after) for change in done.changes} == {
        "min_position_limit": (100, 0), "position_p_gain": (99, KNOWN[name]["position_p_gain"].default)}
    built.servos[0].reboot(built.clock.now())
    assert built.servos[0].table["min_position_limit"] == 0


@EVERY
@pytest.mark.parametrize(("keeps", "servo_id"), [(True, 3), (False, None)])
def test_after_a_factory_reset_it_is_found_wherever_it_is(name: str, keeps: bool, servo_id: int | None) -> None:
    built = rig(name, 3, baud_rate=BAUD_57600[name], position_p_gain=99, firmware={"recovery_keeps_id": keeps})
    built.bench.tune(57_600)
    reset = built.bench.factory_reset(built.bench.servo(3), Keep.NOTHING)
    assert (reset.id, reset.baud) == (KNOWN[name]["id"].default if servo_id is None else servo_id, 1_000_000)
    assert built.bench.servo(reset.id).read("position_p_gain") == KNOWN[name]["position_p_gain"].default


@SCS
def test_the_sdk_s_byte_order_does_not_matter_and_stays_what_it_is(name: str) -> None:
    """The SDK keeps it in a global variable, which another program's part may have set."""
    for end in (0, 1):
        scservo_sdk.scservo_def.SCS_SETEND(end)
        try:
            built = rig(name, 3, max_position_limit=0x0203)
            saved = built.bench.backup(built.bench.servo(3), TIME)
            assert scservo_sdk.scservo_def.SCS_GETEND() == end
        finally:
            scservo_sdk.scservo_def.SCS_SETEND(0)
        assert saved.registers["max_position_limit"] == 0x0203


@SCS
def test_its_errors_in_words(name: str) -> None:
    built = rig(name, 3)
    built.servos[0].table["hardware_error_status"] = 0x25
    assert built.bench.servo(3).faults() == ["voltage", "overheating", "overload"]
