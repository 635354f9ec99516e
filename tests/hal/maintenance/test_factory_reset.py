"""Back to the factory's settings, through the vendors' SDKs: where the servo is afterwards."""

import pytest

from hal.maintenance.vendor_sdk import Keep
from robotwalk.errors import BusError, ServoError, UsageError

from .rig import BAUD_57600, rig

CHANGED = {"max_voltage_limit": 75}


@pytest.mark.parametrize(("keep", "servo_id", "baud", "changed"), [
    (Keep.NOTHING, 1, 57600, 4), (Keep.ID, 3, 57600, 3), (Keep.ID_AND_BAUD, 3, 1_000_000, 2)])
def test_a_dynamixel_keeps_what_it_is_told_to(keep: Keep, servo_id: int, baud: int, changed: int) -> None:
    built = rig("xl430-w250", 3, **CHANGED)
    reset = built.bench.factory_reset(built.bench.servo(3), keep)
    assert reset == (servo_id, baud, changed)  # return delay and voltage limit, baud rate, id
    assert built.port.baud == baud
    assert built.bench.servo(servo_id).read("max_voltage_limit") == 140


def test_a_feetech_servo_is_found_wherever_it_is() -> None:
    built = rig("sts3215", 3, baud_rate=BAUD_57600["sts3215"], **CHANGED)
    built.bench.tune(57600)
    reset = built.bench.factory_reset(built.bench.servo(3), Keep.NOTHING)
    assert (reset.id, reset.baud) == (3, 1_000_000)  # this fake keeps its id
    assert built.bench.servo(3).read("max_voltage_limit") == 80


def test_a_feetech_servo_cannot_be_told_what_to_keep() -> None:
    built = rig("sts3215", 3, **CHANGED)
    with pytest.raises(UsageError, match="cannot be told to keep its id and baud: back it up"):
        built.bench.factory_reset(built.bench.servo(3), Keep.ID_AND_BAUD)
    assert built.servos[0].table["max_voltage_limit"] == 75


def test_two_servos_never_end_up_with_one_id() -> None:
    built = rig("xl430-w250", 3, 1, **CHANGED)
    built.bench.factory_reset(built.bench.servo(1), Keep.NOTHING)
    built.bench.tune(1_000_000)
    with pytest.raises(ServoError, match=r"after the reset id 3 \(xl430-w250\) would be id 1 at 57600 baud, where"):
        built.bench.factory_reset(built.bench.servo(3), Keep.NOTHING)
    assert built.port.baud == 1_000_000
    assert built.servos[0].table["max_voltage_limit"] == 75


def test_a_feetech_servo_beside_another_with_the_factory_s_id_is_not_reset() -> None:
    built = rig("sts3215", 3, 1, **CHANGED)
    with pytest.raises(ServoError, match="would be id 1 at 1000000 baud"):
        built.bench.factory_reset(built.bench.servo(3), Keep.NOTHING)
    assert built.servos[0].table["max_voltage_limit"] == 75


@pytest.mark.parametrize("name", ["xl430-w250", "sts3215"])
def test_a_servo_that_does_not_come_back_is_told(name: str) -> None:
    built = rig(name, 3, firmware={"reboot_s": 60.0})
    with pytest.raises(BusError, match="was told to reset and does not answer again as id"):
        built.bench.factory_reset(built.bench.servo(3), Keep.NOTHING)
