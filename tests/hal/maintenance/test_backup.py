"""An EEPROM into a file and back, through the vendors' SDKs."""

import json
from typing import Any

import pytest
import yaml

from hal.maintenance.backup import Backup, problems, to_json, to_yaml
from hal.maintenance.vendors import vendor_sdk
from robotwalk.errors import BusError, ServoError

from .rig import BAUD_57600, STS3215, XL430, Rig, rig

BRANDS = pytest.mark.parametrize("name", ["xl430-w250", "sts3215"])
TIME = "2026-11-22T10:00:00+00:00"
MAX_VOLTAGE = {"xl430-w250": 32, "sts3215": 14}  # addresses


def backup_of(built: Rig, servo_id: int) -> Backup:
    return built.bench.backup(built.bench.servo(servo_id), TIME)


def changed(done: Any) -> dict[str, tuple[int | None, int]]:
    return {change.register.name: (change.before, change.after) for change in done.changes}


@BRANDS
def test_it_holds_the_whole_eeprom_and_whose_it_is(name: str) -> None:
    built = rig(name, 3, max_voltage_limit=75)
    saved = backup_of(built, 3)
    model = {"xl430-w250": XL430, "sts3215": STS3215}[name]
    assert (saved.model, saved.model_number, saved.id, saved.baud, saved.time) == (
        name, model.model_number, 3, 1_000_000, TIME)
    assert saved.firmware == {"xl430-w250": "45", "sts3215": "3.7"}[name]
    assert list(saved.registers) == [row.name for row in model.registers if row.memory == "eeprom"]
    assert saved.registers["max_voltage_limit"] == 75


@BRANDS
def test_either_file_reads_back_as_it_was(name: str) -> None:
    saved = backup_of(rig(name, 3, max_voltage_limit=75), 3)
    text = to_yaml(saved, {"xl430-w250": XL430, "sts3215": STS3215}[name])
    assert Backup.model_validate(yaml.safe_load(text)) == saved
    assert "max_voltage_limit: 75  # 7.5 V\n" in text
    assert Backup.model_validate(json.loads(to_json(saved))) == saved


@BRANDS
def test_reading_goes_through_the_vendor_s_sdk(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    handler = type(vendor_sdk(servo.model, None).handler)
    through, read = [], handler.readTxRx
    monkeypatch.setattr(handler, "readTxRx", lambda *words: through.append(words) or read(*words))
    built.device.heard.clear()
    built.bench.backup(servo, TIME)
    assert len(through) == len(built.device.heard) > 0


@BRANDS
def test_only_what_differs_is_written(name: str) -> None:
    built = rig(name, 3)
    saved = backup_of(built, 3)
    before = built.servos[0].table["max_voltage_limit"]
    built.bench.servo(3).write("max_voltage_limit", 75)
    built.device.heard.clear()
    done = built.bench.restore(built.bench.servo(3), saved, with_id=False)
    assert changed(done) == {"max_voltage_limit": (75, before)}
    assert built.servos[0].table["max_voltage_limit"] == before
    written = [address for address in range(256) if built.writes_to(address)]
    assert written == {"xl430-w250": [32], "sts3215": [14, 55]}[name]  # 55 is the lock
    assert len(built.writes_to(MAX_VOLTAGE[name])) == 1
    again = built.bench.restore(built.bench.servo(3), saved, with_id=False)
    assert (again.changes, again.left) == ((), ())
    assert again.same == {"xl430-w250": 18, "sts3215": 36}[name]


@BRANDS
def test_what_is_restored_outlives_power(name: str) -> None:
    built = rig(name, 3)
    saved = backup_of(built, 3)
    before = built.servos[0].table["max_voltage_limit"]
    built.bench.servo(3).write("max_voltage_limit", 75)
    built.bench.restore(built.bench.servo(3), saved, with_id=False)
    built.servos[0].reboot(built.clock.now())
    assert built.servos[0].table["max_voltage_limit"] == before


@BRANDS
def test_another_servo_takes_over_but_for_id_and_baud_rate(name: str) -> None:
    old = rig(name, 3, max_voltage_limit=75)
    new = rig(name, 1, baud_rate=BAUD_57600[name])
    new.bench.tune(57600)
    done = new.bench.restore(new.bench.servo(1), backup_of(old, 3), with_id=False)
    assert list(changed(done)) == ["max_voltage_limit"]
    assert done.left == ("id", "baud_rate")
    assert (done.id, done.baud) == (1, 57600)


@BRANDS
def test_id_and_baud_rate_come_back_last_if_wanted(name: str) -> None:
    old = rig(name, 3, max_voltage_limit=75, secondary_id=7) if name[0] == "x" else rig(name, 3, max_voltage_limit=75)
    new = rig(name, 1, baud_rate=BAUD_57600[name])
    new.bench.tune(57600)
    done = new.bench.restore(new.bench.servo(1), backup_of(old, 3), with_id=True)
    assert list(changed(done))[-2:] == ["id", "baud_rate"]
    assert (done.id, done.baud) == (3, 1_000_000)
    assert new.bench.servo(3).read("max_voltage_limit") == 75


@BRANDS
def test_an_id_that_another_servo_has_is_not_taken_over(name: str) -> None:
    built = rig(name, 3, 4)
    saved = backup_of(built, 3)
    with pytest.raises(ServoError, match=r"id 3 is taken: another servo on this line .*\. Changed before that"):
        built.bench.restore(built.bench.servo(4), saved, with_id=True)
    assert [servo.table["id"] for servo in built.servos] == [3, 4]


def test_another_model_is_refused() -> None:
    saved = backup_of(rig("sts3215", 3), 3)
    built = rig("xl430-w250", 3)
    with pytest.raises(ServoError, match=r"^id 3 \(xl430-w250\) is no sts3215, of which the backup is$"):
        built.bench.restore(built.bench.servo(3), saved, with_id=False)


@BRANDS
def test_torque_must_be_off_and_is_left_as_it_is(name: str) -> None:
    built = rig(name, 3)
    saved = backup_of(built, 3)
    servo = built.bench.servo(3)
    servo.write("torque_enable", 1)
    with pytest.raises(ServoError, match="has its torque on: switch it off first, with `robotwalk servo torque-off 3`"):
        built.bench.restore(servo, saved, with_id=False)
    assert built.servos[0].table["torque_enable"] == 1


def test_what_was_changed_before_a_refusal_is_told() -> None:
    built = rig("xl430-w250", 3)
    saved = backup_of(built, 3)
    servo = built.bench.servo(3)
    servo.write("temperature_limit", 60)
    servo.write("shutdown", 4)
    write = built.servos[0].write
    built.servos[0].write = lambda address, data, **how: None if address == 63 else write(address, data, **how)
    with pytest.raises(ServoError, match=r"did not take shutdown = 52 .*\. Changed before that: temperature_limit$"):
        built.bench.restore(servo, saved, with_id=False)


@BRANDS
def test_a_servo_that_goes_silent_is_told(name: str) -> None:
    built = rig(name, 3)
    saved = backup_of(built, 3)
    servo = built.bench.servo(3)
    built.device.tamper = lambda sent, replies: []
    with pytest.raises(BusError, match="id 3: there is no status packet"):
        built.bench.restore(servo, saved, with_id=False)


def test_what_the_model_does_not_have_or_take_is_found_in_the_file() -> None:
    saved = backup_of(rig("xl430-w250", 3), 3)
    broken = saved.model_copy(update={"registers": {
        **saved.registers, "max_voltage_limit": 999, "torque_enable": 1, "shutdwn": 52, "model_number": 7}})
    assert [(problem.register, problem.what) for problem in problems(broken, XL430)] == [
        ("max_voltage_limit", "max_voltage_limit should be 6 V to 14 V, not 99.9 V (counts: 999)"),
        ("torque_enable", "xl430-w250 has no such register in its EEPROM"),
        ("shutdwn", "xl430-w250 has no such register in its EEPROM")]
