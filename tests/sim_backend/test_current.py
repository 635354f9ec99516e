"""What the servos with a current sensor make of their currents: registers 38, 102 and 126."""

import pytest

from robotwalk.assembly import load_servo
from sim_backend.dynamixel_table import ErrorNumber, StatusError

from .rig import Rig

XL330, XC330, XM430 = (load_servo(name) for name in ("xl330-m288", "xc330-m288", "xm430-w350"))
STALL_A = 5.0 / XL330.motor.resistance_ohm


def test_present_current_is_what_flows_and_not_the_load() -> None:
    rig = Rig(XL330, spring=20.0, operating_mode=16)
    rig.write(torque_enable=1, goal_pwm=-885)
    rig.run(0.3)
    assert rig.read("present_current") == pytest.approx(-1000 * STALL_A, rel=0.01)
    rig = Rig(XL330, operating_mode=16)
    rig.write(torque_enable=1, goal_pwm=885)
    rig.run(1.0)
    assert rig.read("present_pwm") == 885
    assert 0 < rig.read("present_current") < 200  # running free, it takes what friction takes


@pytest.mark.parametrize("reverse", [0, 1])
def test_in_current_mode_the_goal_current_flows_whatever_the_speed(reverse: int) -> None:
    rig = Rig(XM430, spring=0.5, operating_mode=0, drive_mode=reverse)
    rig.write(torque_enable=1)
    rig.run(0.1)
    assert rig.angle == 0.0
    rig.write(goal_current=60)
    for _ in range(5):
        rig.run(0.05)
        assert rig.read("present_current") == pytest.approx(60, abs=1)
    assert rig.angle > 0.1 if not reverse else rig.angle < -0.1


def test_current_based_position_gives_way_where_position_mode_does_not() -> None:
    def deflection(mode: int) -> float:
        rig = Rig(XC330, spring=1.0, operating_mode=mode)
        rig.write(torque_enable=1, goal_current=300, goal_position=4000)
        rig.run(2.0)
        return rig.angle

    kt = XC330.motor.torque_constant_nm_per_a
    assert deflection(5) == pytest.approx(0.3 * kt, rel=0.16)  # friction helps the spring or the motor
    assert deflection(3) > 2.0 * deflection(5)


def test_a_goal_current_beyond_the_current_limit_is_refused() -> None:
    rig = Rig(XL330, operating_mode=5, current_limit=500)
    assert rig.read("goal_current") == 500
    with pytest.raises(StatusError) as error:
        rig.write(goal_current=-501)
    assert error.value.number is ErrorNumber.DATA_LIMIT
    rig.write(operating_mode=0)
    assert rig.read("goal_current") == 0


def test_the_watchdog_ends_a_goal_current() -> None:
    rig = Rig(XM430, operating_mode=0)
    rig.write(torque_enable=1, bus_watchdog=5, goal_current=100)
    rig.run(0.2)
    assert rig.read("goal_current") == 0
    assert rig.read("present_current") == 0
