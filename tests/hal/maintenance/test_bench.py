"""Torque off, reboot and monitor on either brand."""

import numpy as np
import pytest

from hal.maintenance.monitor import Sample, sample
from robotwalk.errors import BusError, ServoError
from sim_backend.device import Reply

from .rig import MS, S, rig

BRANDS = pytest.mark.parametrize("name", ["xl430-w250", "sts3215"])


def torque(servos: list) -> list[int]:
    return [servo.table["torque_enable"] for servo in servos]


@BRANDS
def test_torque_goes_off_everywhere_at_once(name: str) -> None:
    built = rig(name, 1, 2, 3)
    for servo in built.bench.servos([1, 2, 3]):
        servo.write("torque_enable", 1)
    assert torque(built.servos) == [1, 1, 1]
    before, off_at = built.clock.now(), []
    built.device.tamper = lambda sent, replies: (
        off_at.append(built.clock.now()) if torque(built.servos) == [0, 0, 0] else None) or replies
    assert [servo.id for servo in built.bench.torque_off()] == [1, 2, 3]
    assert off_at[0] - before < 10 * MS


@BRANDS
def test_torque_goes_off_only_where_told(name: str) -> None:
    built = rig(name, 1, 2, 3)
    for servo in built.bench.servos([1, 2, 3]):
        servo.write("torque_enable", 1)
    built.bench.torque_off([2])
    assert torque(built.servos) == [1, 0, 1]


@BRANDS
def test_torque_that_stays_on_is_told(name: str) -> None:
    built = rig(name, 1, 2)
    for servo in built.bench.servos([1, 2]):
        servo.write("torque_enable", 1)
    built.servos[1].write = lambda address, data, **how: None
    with pytest.raises(ServoError, match=r"torque is still on: id 2"):
        built.bench.torque_off()


@BRANDS
def test_nobody_is_no_success(name: str) -> None:
    with pytest.raises(BusError, match="no servo answers at 1000000 baud"):
        rig(name, 1, baud_rate=2).bench.torque_off()


@BRANDS
def test_all_must_be_well_before_everybody_is_worked_on(name: str) -> None:
    built = rig(name, 1, 2)
    built.device.tamper = lambda sent, replies: [reply for reply in replies for _ in range(2)]
    with pytest.raises(BusError, match="two servos have that id"):
        built.bench.servos()


@BRANDS
def test_a_reboot_waits_for_the_servo(name: str) -> None:
    switch = {"reboot": True} if name == "sts3215" else {}
    built = rig(name, 1, firmware=switch | {"reboot_s": 0.4})
    servo = built.bench.servo(1)
    servo.write("torque_enable", 1)
    assert built.bench.reboot(servo) == pytest.approx(0.4, abs=0.05)
    assert torque(built.servos) == [0]
    assert servo.read("id") == 1


def test_a_feetech_servo_that_does_not_know_reboot_is_told() -> None:
    built = rig("sts3215", 1)
    with pytest.raises(ServoError, match=r"seems not to know the instruction\. Switch its power off and on"):
        built.bench.reboot(built.bench.servo(1))


def test_a_servo_that_does_not_come_back_is_told() -> None:
    built = rig("xl430-w250", 1, firmware={"reboot_s": 30.0})
    before = built.clock.now()
    with pytest.raises(BusError, match="told to reboot and does not answer again"):
        built.bench.reboot(built.bench.servo(1))
    assert built.clock.now() - before < 4 * S


@pytest.mark.parametrize(("name", "supply"), [("xl430-w250", 11.1), ("sts3215", 7.4)])
def test_a_sample_is_in_degrees(name: str, supply: float) -> None:
    built = rig(name, 1)
    servo = built.bench.servo(1)
    built.servos[0]._physics.step(np.array([np.pi / 4]), np.array([1.0]), built.clock.now())
    moment = sample(servo)
    assert isinstance(moment, Sample)
    assert moment.id == 1
    assert moment.position_deg == pytest.approx(45.0, abs=0.1)
    assert moment.velocity_deg_s == pytest.approx(57.3, abs=1.5)
    assert (moment.voltage_v, moment.temperature_c, moment.errors) == (pytest.approx(supply), 30.0, ())


@BRANDS
def test_a_sample_of_a_servo_that_has_gone_is_none(name: str) -> None:
    built = rig(name, 1)
    servo = built.bench.servo(1)
    built.device.tamper = lambda sent, replies: []
    assert sample(servo) is None
    built.device.tamper = lambda sent, replies: replies
    assert sample(servo) is not None


def test_a_line_that_is_gone_ends_the_monitor() -> None:
    built = rig("xl430-w250", 1)
    servo = built.bench.servo(1)

    def broken() -> bytes:
        raise BusError("/dev/ttyUSB0 is gone")

    built.port.read = broken
    with pytest.raises(BusError, match="is gone"):
        sample(servo)


@BRANDS
def test_a_servo_whose_first_answer_comes_late_is_found_all_the_same(name: str) -> None:
    built = rig(name, 1)
    late: list[bytes] = []

    def once(sent: bytes, replies: list[Reply]) -> list[Reply]:
        if replies and not late:
            late.append(sent)
            return [Reply(60 * MS, replies[0].data)]  # it comes into the next protocol's ping
        return replies

    built.device.tamper = once
    assert built.bench.servo(1).id == 1
