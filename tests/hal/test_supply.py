"""What a servo's effort comes to at the voltage that it gets."""

import pytest

from hal.calibration import Calibration
from hal.supply import SupplyShares
from hal.wired import Wired
from robotwalk.assembly import load_servo


def _wired(model: str, slot: int) -> Wired:
    calibration = Calibration(1, 0.0, 2048, 0.0015)
    return Wired(f"joint_{slot}", "leg", slot, slot + 1, load_servo(model), calibration, -1.0, 1.0)


def test_a_duty_cycle_is_reckoned_at_the_voltage_that_its_servo_told_and_a_current_as_it_is() -> None:
    shares = SupplyShares()
    shares.note(_wired("xl430-w250", 0), 8.9)  # rated 11.1 V
    shares.note(_wired("xl430-w250", 1), 0.1)  # it could not have answered
    shares.note(_wired("xl330-m288", 2), 3.7)  # tells its current
    assert shares.by_slot == {0: pytest.approx(8.9 / 11.1), 1: 0.5}
    shares.forget(0)
    assert 0 not in shares.by_slot
