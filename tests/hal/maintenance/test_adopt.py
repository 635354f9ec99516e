"""A factory-fresh servo takes a joint's place; one that is not it never does."""

from typing import Any

import pytest

from hal.maintenance import backup
from hal.maintenance.adopt import Vacancy
from hal.maintenance.identity import Identity
from hal.maintenance.place import Place
from robotwalk.errors import BusError, ServoError, UsageError

from .rig import BAUD_57600, MODELS, STS3215, XL430, Rig, rig

BRANDS = pytest.mark.parametrize("name", ["xl430-w250", "sts3215"])
MODEL = {model.name: model for model in MODELS}


def line(name: str, *robots: int, fresh: int = 1, fresh_baud: int = 57_600) -> Rig:
    """The robot's servos at 1 Mbaud, and a new one, the last."""
    built = rig(name, *robots, fresh)
    table = built.servos[-1].table
    table["return_delay_time"] = 100
    table["baud_rate"] = {57_600: BAUD_57600[name]}.get(fresh_baud, table["baud_rate"])
    built.servos[-1]._configure_line()
    return built


def vacancy(name: str, servo_id: int = 5, others: tuple[int, ...] = (1, 2)) -> Vacancy:
    return Vacancy(
        "knee", Place(1_000_000, servo_id), MODEL[name], [Place(1_000_000, other) for other in others])


def scan(built: Rig) -> list[Identity]:
    found = []
    for baud in (1_000_000, 57_600):
        built.bench.tune(baud)
        found += [one for one in built.bench.scan() if isinstance(one, Identity)]
    return found


@BRANDS
def test_the_one_that_is_none_of_the_robots_takes_the_place(name: str) -> None:
    built = line(name, 1, 2)
    place = vacancy(name)
    new = place.newcomer(scan(built), None)
    assert (new.id, new.baud) == (1, 57_600)
    built.bench.tune(new.baud)
    servo = built.bench.servo(new.id)
    changes = place.fill(servo, place.settings(None))
    assert [change.register.name for change in changes] == ["return_delay_time", "id", "baud_rate"]
    assert (servo.id, built.port.baud) == (5, 1_000_000)
    fresh = built.servos[-1].table
    assert (fresh["id"], fresh["return_delay_time"]) == (5, 0)
    assert [fake.table["id"] for fake in built.servos[:-1]] == [1, 2]
    built.servos[-1].reboot(built.clock.now())
    assert built.servos[-1].table["id"] == 5, "it outlives power"


@BRANDS
def test_a_setting_that_walking_needs_is_put_right(name: str) -> None:
    built = line(name)
    built.servos[-1].table["operating_mode"] = 1
    place = vacancy(name)
    built.bench.tune(57_600)
    place.fill(built.bench.servo(1), place.settings(None))
    assert built.servos[-1].table["operating_mode"] == {"xl430-w250": 3, "sts3215": 0}[name]


@BRANDS
def test_the_old_ones_settings_come_over_but_not_its_offset_nor_its_place(name: str) -> None:
    old = rig(name, 7).bench.servo(7)
    offset = {"xl430-w250": "homing_offset", "sts3215": "position_offset"}[name]
    old.write("max_voltage_limit", 75)
    old.write("return_delay_time", 50)
    old.write(offset, 300)
    saved = backup.take(old, "now")
    settings = vacancy(name).settings(saved)
    assert settings["max_voltage_limit"] == 75
    assert settings["return_delay_time"] == 0
    assert settings.get(offset, 0) == 0
    assert {"id", "baud_rate"}.isdisjoint(settings)
    with pytest.raises(UsageError, match="the backup is of an "):
        vacancy({"xl430-w250": "sts3215", "sts3215": "xl430-w250"}[name]).settings(saved)


def found(**changes: Any) -> Identity:
    fields = {"id": 1, "protocol": "feetech-sts", "baud": 57_600, "alert": False, "model_number": 777,
              "model": STS3215, "firmware": "3.7", "voltage_v": 7.4, "temperature_c": 30.0}
    return Identity(**{**fields, **changes})


@pytest.mark.parametrize(("answers", "servo_id", "error", "why"), [
    ([], None, BusError, "no servo answers but the robot's"),
    ([found(baud=1_000_000)], None, BusError, "If the new one has the id of a joint, connect it alone and say --id"),
    ([found(), found(id=9)], None, ServoError, r"which is the new one\? id 1 at 57600 baud .*, id 9 at 57600 baud"),
    ([found(), found(baud=1_000_000)], 1, ServoError, "which is the new one"),
    ([found()], 9, BusError, "no servo answers as id 9"),
    ([found(model=XL430)], None, ServoError, "a servo of another model, xl430-w250; knee needs an sts3215"),
    ([found(model=None)], None, ServoError, r"of another model, unknown \(model number 777\); knee needs"),
])
def test_who_is_not_the_new_one(answers: list[Identity], servo_id: int | None, error: type, why: str) -> None:
    with pytest.raises(error, match=why):
        vacancy("sts3215").newcomer(answers, servo_id)


def test_one_with_the_id_of_a_joint_is_taken_if_it_is_named() -> None:
    new = found(baud=1_000_000)
    assert vacancy("sts3215").newcomer([new], 1) is new


@BRANDS
def test_nothing_is_written_while_the_old_servo_answers(name: str) -> None:
    built = line(name, 5)
    place = vacancy(name)
    built.bench.tune(57_600)
    built.device.heard.clear()
    with pytest.raises(ServoError, match=r"^id 5 at 1000000 baud is taken: the servo that knee has"):
        place.fill(built.bench.servo(1), place.settings(None))
    assert [fake.table["id"] for fake in built.servos] == [5, 1]
    assert built.servos[-1].table["return_delay_time"] == 100


@BRANDS
def test_nothing_is_written_while_torque_is_on(name: str) -> None:
    built = line(name)
    built.bench.tune(57_600)
    servo = built.bench.servo(1)
    servo.write("torque_enable", 1)
    with pytest.raises(ServoError, match="has its torque on"):
        vacancy(name).fill(servo, vacancy(name).settings(None))
    assert built.servos[-1].table["return_delay_time"] == 100


@BRANDS
def test_what_was_changed_before_it_failed_is_said(name: str) -> None:
    built = line(name, 5)
    built.servos[0].table["baud_rate"] = BAUD_57600[name]
    built.servos[0]._configure_line()  # in the way: the new id at the old baud rate
    built.bench.tune(57_600)
    place = vacancy(name)
    with pytest.raises(ServoError, match=r"^id 5 is taken: .* Changed before that: return_delay_time$"):
        place.fill(built.bench.servo(1), place.settings(None))
