from collections.abc import Mapping

import numpy as np
import pytest

from hal.register_map import ServoModel
from robotwalk.config import library
from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.dynamixel_table import StatusError
from sim_backend.servo_physics import ServoPhysics

ROWS = library.open_document("servos", "xl430-w250").value(())
MS = 1_000_000
TICK = 2.0 * np.pi / 4096  # rad


class Bench:
    """One servo whose shaft is where the test holds it."""

    def __init__(self, at: int = 2048, firmware: Mapping[str, object] = {}, **factory_settings: int) -> None:
        self.model = ServoModel.model_validate(ROWS | {"firmware": {**ROWS["firmware"], **firmware}})
        self.physics = ServoPhysics([self.model])
        self.now = 0
        self.shaft = at - 2048
        self.run(0)
        self.servo = DynamixelServo(self.physics, 0, **factory_settings)

    def run(self, ms: int, at: int | None = None) -> float:
        """Let time pass, the shaft held at a position as the factory counts it; return the torque."""
        if at is not None:
            self.shaft = at - 2048
        for _ in range(max(ms, 1)):
            self.now += MS if ms else 0
            torque = self.physics.step(np.array([self.shaft * TICK]), np.zeros(1), self.now)
        return float(torque[0])

    def write(self, name: str, value: int) -> None:
        register = self.model[name]
        data = value.to_bytes(register.size, "little", signed=register.signed)
        self.servo.hear(self.now)
        self.servo.write(register.address, data)

    def read(self, name: str) -> int:
        register = self.model[name]
        data = self.servo.read(register.address, register.size, self.now)
        return int.from_bytes(data, "little", signed=register.signed)

    def refusal(self, name: str, value: int) -> int:
        with pytest.raises(StatusError) as caught:
            self.write(name, value)
        return caught.value.number

    def overload(self) -> None:
        """Hold the shaft 1000 ticks from its goal until the servo gives up."""
        self.write("torque_enable", 1)
        self.write("goal_position", 3048)
        self.run(2020)


def test_a_new_servo_is_limp_and_its_goal_is_where_it_stands() -> None:
    bench = Bench(at=1234)
    assert bench.run(1) == 0.0
    assert bench.read("torque_enable") == 0
    assert bench.read("goal_position") == 1234
    assert bench.read("goal_pwm") == 885
    assert bench.read("firmware_version") == 45


def test_factory_settings_are_for_the_eeprom_alone() -> None:
    assert Bench(id=17).read("id") == 17
    with pytest.raises(ValueError, match="led is not kept"):
        Bench(led=1)


def test_torque_pulls_towards_the_goal() -> None:
    bench = Bench()
    bench.write("torque_enable", 1)
    bench.write("goal_position", 2058)
    # 10 ticks x 640 / 128 = 50 PWM counts of 885, 11.1 V: 0.627 V; x 1.7462 N m/A / 13.46 ohm
    assert bench.run(1) == pytest.approx(0.0814, abs=1e-4)
    assert bench.read("present_pwm") == 50
    assert bench.read("present_load") == 56
    bench.write("torque_enable", 0)
    assert bench.run(1) == 0.0
    assert bench.read("present_load") == 0


def test_torque_on_heads_for_an_old_goal() -> None:
    bench = Bench()
    bench.write("goal_position", 2500)
    bench.write("torque_enable", 1)
    assert bench.read("goal_position") == 2500
    assert bench.run(1) > 1.0


def test_with_the_switch_set_the_goal_follows_the_present_position_at_torque_on() -> None:
    bench = Bench(firmware={"goal_follows_present": True})
    bench.write("goal_position", 2500)
    bench.run(1, at=2100)
    bench.write("torque_enable", 1)
    assert bench.read("goal_position") == 2100
    assert bench.run(1) == 0.0


def test_torque_on_by_goal_update() -> None:
    bench = Bench(drive_mode=8)
    bench.write("goal_position", 2500)
    assert bench.read("torque_enable") == 1
    assert bench.run(1) > 1.0


def test_startup_configuration_switches_torque_on() -> None:
    assert Bench(startup_configuration=1).read("torque_enable") == 1


def test_realtime_tick_counts_milliseconds_and_wraps() -> None:
    bench = Bench()
    bench.run(123)
    assert bench.read("realtime_tick") == 123
    bench.now = 32_769 * MS
    assert bench.read("realtime_tick") == 1


def test_a_reboot_restores_ram_and_folds_the_position() -> None:
    bench = Bench(operating_mode=4)
    bench.write("torque_enable", 1)
    bench.write("position_p_gain", 100)
    bench.write("status_return_level", 0)
    bench.write("goal_position", 10_000)
    bench.run(1, at=9192)
    assert bench.read("present_position") == 9192
    bench.servo.reboot(bench.now)
    assert bench.run(1) == 0.0
    assert not bench.servo.listens(bench.now, 57_600)
    bench.run(298)
    assert not bench.servo.listens(bench.now, 57_600)
    bench.run(1)
    assert bench.servo.listens(bench.now, 57_600)
    assert bench.read("torque_enable") == 0
    assert bench.read("position_p_gain") == 640
    assert bench.read("status_return_level") == 2
    assert bench.read("operating_mode") == 4
    assert bench.read("present_position") == 1000
    assert bench.read("goal_position") == 1000


def test_a_rebooting_servo_wakes_by_itself() -> None:
    bench = Bench(startup_configuration=1)
    bench.servo.reboot(bench.now)
    bench.run(310)
    bench.run(1, at=2000)
    assert bench.run(1) > 0.0


def test_position_mode_folds_at_torque_on_and_counts_on_without_torque() -> None:
    bench = Bench()
    bench.run(1, at=5000)
    assert bench.read("present_position") == 5000
    bench.write("torque_enable", 1)
    assert bench.read("present_position") == 904
    bench.run(1, at=5001)
    assert bench.read("present_position") == 905


def test_changing_the_mode_resets_gains_profile_and_goal_pwm() -> None:
    bench = Bench()
    for name in ("position_p_gain", "velocity_i_gain", "profile_velocity", "profile_acceleration"):
        bench.write(name, 7)
    bench.write("goal_pwm", 7)
    bench.write("operating_mode", 3)  # no change
    assert bench.read("position_p_gain") == 7
    bench.write("operating_mode", 1)
    assert bench.read("position_p_gain") == 640
    assert bench.read("velocity_i_gain") == 1000
    assert bench.read("profile_velocity") == 0
    assert bench.read("profile_acceleration") == 0
    assert bench.read("goal_pwm") == 885
    bench.write("operating_mode", 16)
    assert bench.read("goal_pwm") == 0


def test_the_bus_watchdog_stops_the_servo_where_it_is() -> None:
    bench = Bench()
    bench.write("torque_enable", 1)
    bench.write("bus_watchdog", 5)  # 100 ms
    bench.write("goal_position", 2100)
    assert bench.run(99) > 0.0
    assert bench.read("bus_watchdog") == 5
    assert bench.run(10) == 0.0
    assert bench.read("bus_watchdog") == 0xFF
    assert bench.read("goal_position") == 2048
    assert bench.read("torque_enable") == 1
    assert bench.run(1, at=2038) > 0.0, "it must hold, not let go"


def test_after_a_trip_goals_are_refused_until_the_watchdog_is_cleared() -> None:
    bench = Bench()
    bench.write("torque_enable", 1)
    bench.write("bus_watchdog", 1)
    bench.run(30)
    for name in ("goal_position", "goal_velocity", "goal_pwm"):
        assert bench.refusal(name, 0) == 4
    bench.write("led", 1)
    assert bench.refusal("bus_watchdog", 1) == 4
    bench.write("bus_watchdog", 0)
    bench.write("goal_position", 2100)
    bench.write("bus_watchdog", 1)
    assert bench.run(10) > 0.0


def test_a_late_instruction_finds_the_watchdog_tripped() -> None:
    bench = Bench()
    bench.write("torque_enable", 1)
    bench.write("bus_watchdog", 1)
    bench.now += 20 * MS
    bench.write("goal_position", 2050)
    bench.now += 20 * MS + 1
    assert bench.refusal("goal_position", 2051) == 4


def test_any_instruction_on_the_bus_feeds_the_watchdog_and_it_sleeps_without_torque() -> None:
    bench = Bench()
    bench.write("bus_watchdog", 1)
    bench.run(200)
    bench.write("torque_enable", 1)
    for _ in range(20):
        bench.run(15)
        bench.servo.hear(bench.now)
    assert bench.read("bus_watchdog") == 1


@pytest.mark.parametrize(("mode", "goal", "value"), [(1, "goal_velocity", 100), (16, "goal_pwm", 400)])
def test_the_watchdog_stops_a_turning_servo(mode: int, goal: str, value: int) -> None:
    bench = Bench(operating_mode=mode)
    bench.write("torque_enable", 1)
    bench.write("bus_watchdog", 1)
    bench.write(goal, value)
    assert bench.run(10) > 0.1
    assert bench.run(20) == 0.0
    assert bench.read(goal) == 0


def test_overload_shuts_the_servo_down_until_it_reboots() -> None:
    bench = Bench()
    bench.overload()
    assert bench.read("hardware_error_status") == 0x20
    assert bench.servo.alert == 0x80
    assert bench.read("torque_enable") == 0
    assert bench.run(1) == 0.0
    bench.write("goal_position", 2048)  # taken without effect
    bench.write("torque_enable", 1)
    assert bench.read("torque_enable") == 0
    assert bench.run(1, at=2000) == 0.0
    assert bench.servo.alert == 0x80
    bench.servo.reboot(bench.now)
    bench.run(300)
    assert bench.servo.listens(bench.now, 57_600)
    assert bench.servo.alert == 0
    assert bench.read("hardware_error_status") == 0
    bench.write("torque_enable", 1)
    assert bench.read("torque_enable") == 1


def test_a_short_or_moderate_effort_is_no_overload() -> None:
    bench = Bench()
    bench.write("torque_enable", 1)
    bench.write("goal_position", 3048)
    bench.run(1900)
    bench.run(10, at=3000)
    bench.run(1900, at=2048)
    bench.run(3000, at=3048 - 141)  # 141 ticks x 5 / 885 = 0.797
    assert bench.read("hardware_error_status") == 0


def test_an_overload_that_is_not_masked_only_alerts() -> None:
    bench = Bench(shutdown=0x04)
    bench.overload()
    assert bench.read("hardware_error_status") == 0x20
    assert bench.read("torque_enable") == 1
    assert bench.run(1) > 1.0


def test_overheating_shuts_down_and_stays_latched() -> None:
    bench = Bench()
    bench.write("torque_enable", 1)
    bench.physics.temperature_c[0] = 72.0
    bench.run(5)
    assert bench.read("present_temperature") == 72
    assert bench.read("hardware_error_status") == 0
    bench.physics.temperature_c[0] = 73.0
    bench.run(5)
    bench.physics.temperature_c[0] = 30.0
    bench.run(5)
    assert bench.read("hardware_error_status") == 0x04
    assert bench.read("torque_enable") == 0


@pytest.mark.parametrize(
    ("volts", "counts", "error"), [(5.9, 59, 1), (6.0, 60, 0), (14.0, 140, 0), (14.1, 141, 1)])
def test_input_voltage_alerts_but_does_not_shut_down(volts: float, counts: int, error: int) -> None:
    bench = Bench()
    bench.write("torque_enable", 1)
    bench.physics.supply_v[0] = volts
    bench.run(5)
    assert bench.read("present_input_voltage") == counts
    assert bench.read("hardware_error_status") == error
    assert bench.read("torque_enable") == 1


def test_moving_and_moving_status() -> None:
    bench = Bench()
    bench.write("torque_enable", 1)
    bench.run(1)
    assert (bench.read("moving"), bench.read("moving_status")) == (0, 0x01)
    bench.write("profile_velocity", 10)
    bench.write("profile_acceleration", 10)
    bench.write("goal_position", 2248)
    bench.run(1)
    assert (bench.read("moving"), bench.read("moving_status")) == (1, 0x32)
    bench.write("profile_velocity", 265)
    bench.write("goal_position", 2058)
    bench.run(1)
    assert bench.read("moving_status") == 0x22
    bench.write("profile_acceleration", 0)
    bench.write("goal_position", 2248)
    bench.run(1)
    assert bench.read("moving_status") == 0x12
    bench.run(400)
    assert (bench.read("moving"), bench.read("moving_status")) == (0, 0x18), "the shaft is held, a following error"
    bench.run(1, at=2243)
    assert bench.read("moving_status") == 0x11


def test_fast_movement_is_moving_even_without_a_profile() -> None:
    bench = Bench()
    bench.now += MS
    bench.physics.step(np.zeros(1), np.array([0.24]), bench.now)  # 10.008 counts of 0.229 rpm, threshold 10
    assert bench.read("moving") == 0
    bench.now += MS
    bench.physics.step(np.zeros(1), np.array([0.26]), bench.now)
    assert bench.read("moving") == 1
    assert bench.read("present_velocity") == 11
