"""A robot's servos may be of any brand; a wire carries one protocol."""

import pytest

from robotwalk.assembly import load_servo
from sim_backend.brands import make_device, make_servo
from sim_backend.servo_physics import ServoPhysics

XL430, STS3215 = load_servo("xl430-w250"), load_servo("sts3215")


def test_servos_of_two_brands_answer_each_in_its_protocol() -> None:
    physics = ServoPhysics([XL430, STS3215])
    servos = [make_servo(physics, 0, id=1, baud_rate=3), make_servo(physics, 1, id=1)]
    dynamixel, feetech = make_device("left", servos[:1]), make_device("right", servos[1:])
    pings = bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E"), bytes.fromhex("FF FF 01 02 01 FB")
    assert dynamixel.receive(pings[0], 10**7, 1_000_000)[0].data[:8] == bytes.fromhex("FF FF FD 00 01 07 00 55")
    assert feetech.receive(pings[1], 10**7, 1_000_000)[0].data == bytes.fromhex("FF FF 01 02 00 FC")
    assert dynamixel.receive(pings[1], 10**8, 1_000_000) == []


@pytest.mark.parametrize(("count", "protocols"), [(2, "dynamixel-2.0 and feetech"), (0, "none")])
def test_a_wire_carries_one_protocol(count: int, protocols: str) -> None:
    physics = ServoPhysics([XL430, STS3215])
    servos = [make_servo(physics, index) for index in range(count)]
    with pytest.raises(ValueError, match=f"bus legs: one wire carries one protocol, not {protocols}"):
        make_device("legs", servos)
