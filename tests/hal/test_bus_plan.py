"""Wire times against the worked table for return delay 0: bytes x 10 bits / baud."""

import pytest

from hal import bus_plan, dynamixel_protocol
from robotwalk.assembly import load_servo

XL430 = load_servo("xl430-w250")


@pytest.mark.parametrize(("servos", "baud", "write_ms", "plain_ms", "fast_ms"), [
    (12, 57_600, 12.85, 48.26, 35.07),
    (12, 1_000_000, 0.74, 2.78, 2.02),
    (18, 1_000_000, 1.04, 4.10, 2.92),
    (18, 4_000_000, 0.26, 1.02, 0.73),
    (24, 3_000_000, 0.45, 1.81, 1.27),
])
def test_worked_table(servos: int, baud: int, write_ms: float, plain_ms: float, fast_ms: float) -> None:
    for fast, read_ms in ((False, plain_ms), (True, fast_ms)):
        plan = bus_plan.cyclic(dynamixel_protocol, [XL430] * servos, fast=fast)
        assert 1e3 * bus_plan.wire_seconds(plan, baud) == pytest.approx(write_ms + read_ms, abs=0.011)


def test_return_delay_is_paid_once_by_a_fast_read_and_by_each_servo_otherwise() -> None:
    for fast, waits in ((False, 18), (True, 1)):
        plan = bus_plan.cyclic(dynamixel_protocol, [XL430] * 18, fast=fast)
        more = bus_plan.wire_seconds(plan, 1_000_000, return_delay=250) - bus_plan.wire_seconds(plan, 1_000_000)
        assert more == pytest.approx(waits * 0.5e-3)


def test_the_plan_of_eighteen_xl430() -> None:
    plan = bus_plan.cyclic(dynamixel_protocol, [XL430] * 18, fast=True)
    assert plan == bus_plan.Exchange(tx_bytes=104 + 32, rx_bytes=260, return_delays=1)
