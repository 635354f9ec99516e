"""The registers of SCS servos, how they move, and their protections, the shaft held in a vice or turning in MuJoCo."""

import math

import numpy as np
import pytest

from hal.register_map import ServoModel
from robotwalk.assembly import load_servo
from sim_backend.scs_firmware import ScsServo
from sim_backend.servo_physics import ServoPhysics

from .rig import MS, Hinge, Registers, Turning

SCS15, SCS0009 = load_servo("scs15"), load_servo("scs0009")
TICK = {"scs15": math.radians(215 / 1024), "scs0009": math.radians(300 / 1024)}
BOTH = pytest.mark.parametrize("model", [SCS15, SCS0009], ids=lambda model: model.name)
RPM = 60.0 / (2.0 * math.pi)
FREE = {"min_position_limit": 0, "max_position_limit": 0}


def scs15(**firmware: object) -> ServoModel:
    """Return the servo with some switches of its firmware changed."""
    return SCS15.model_copy(update={"firmware": SCS15.firmware.model_copy(update=firmware)})


class Bench(Registers):
    """One servo whose shaft is where the test holds it."""

    def __init__(self, model: ServoModel = SCS15, at: float = 512, **factory_settings: int) -> None:
        self.physics = ServoPhysics([model])
        self.now = 0
        self.tick = TICK[model.name]
        self.run(0, at=at)
        self.servo = ScsServo(self.physics, 0, **factory_settings)

    def run(self, ms: int, at: float | None = None) -> float:
        """Let time pass, the shaft held at a count; return the torque."""
        if at is not None:
            self.angle = (at - 512) * self.tick
        for _ in range(max(ms, 1)):
            self.now += MS if ms else 0
            torque = self.physics.step(np.array([self.angle]), np.zeros(1), self.now)
        return float(torque[0])

    def power_cycle(self) -> None:
        self.servo.reboot(self.now)
        self.run(300)
        assert self.servo.listens(self.now, 1_000_000)

    def heading(self, ms: int) -> list[float]:
        """Return where the firmware heads in each millisecond, as a position count."""
        goals = []
        for _ in range(ms):
            self.run(1)
            goals.append(512 + self.physics.trajectory(0)[0])
        return goals


class Rig(Turning, Registers):
    """One servo whose shaft MuJoCo moves."""

    def __init__(self, model: ServoModel, spring: float = 0.0, **factory_settings: int) -> None:
        self.physics = ServoPhysics([model])
        self.servo = ScsServo(self.physics, 0, **factory_settings)
        self.hinge = Hinge(self.physics, spring)
        self.now = 0


def holding(bench: Bench) -> Bench:
    bench.write(goal_position=512, torque_enable=1)
    return bench


class TestMemory:
    def test_a_new_servo_has_the_factory_values_high_bytes_first(self) -> None:
        bench = Bench(at=700)
        assert bench.run(1) == 0.0
        assert bench.servo.read(3, 10) == bytes.fromhex("05 0F 00 00 00 01 00 00 03 FF")
        assert bench.servo.read(13, 15) == bytes.fromhex("50 FA 32 03 FF 00 25 25 0F 00 00 00 00 02 02")
        assert bench.servo.read(40, 9) == bytes.fromhex("00 00 00 00 00 00 00 00 01"), "limp and locked"
        assert bench.servo.read(56, 2) == b"\x02\xbc"  # 700
        assert Bench(SCS0009).servo.read(3, 3) == bytes.fromhex("05 04 01")

    def test_it_must_be_an_scs_servo(self) -> None:
        with pytest.raises(ValueError, match="sts3215 is no SCS servo"):
            ScsServo(ServoPhysics([load_servo("sts3215")]), 0)

    def test_the_high_byte_lies_lower(self) -> None:
        bench = Bench()
        bench.servo.write(42, b"\x01\x23")
        assert bench.servo.table["goal_position"] == 0x0123
        bench.servo.write(43, b"\x04")
        assert bench.servo.table["goal_position"] == 0x0104
        bench.servo.write(46, b"\x80\x64")
        assert bench.servo.table["goal_velocity"] == -100

    @pytest.mark.parametrize(("lock", "kept"), [(0, 30), (1, 15)])
    def test_eeprom_outlives_power_only_if_it_is_unlocked(self, lock: int, kept: int) -> None:
        bench = Bench()
        bench.write(lock=lock)
        bench.write(position_p_gain=30)
        assert bench.read("position_p_gain") == 30
        bench.power_cycle()
        assert bench.read("position_p_gain") == kept
        assert bench.read("lock") == 1

    def test_the_factory_is_not_locked_out(self) -> None:
        bench = Bench(id=17)
        bench.power_cycle()
        assert bench.read("id") == 17

    @pytest.mark.parametrize(
        ("name", "value", "old"), [
            ("goal_position", 1024, 0), ("torque_enable", 2, 0), ("torque_enable", 128, 0), ("lock", 2, 1),
            ("max_position_limit", 1024, 1023), ("max_torque_limit", 1024, 1023), ("status_return_level", 2, 1)])
    def test_what_does_not_fit_is_not_taken(self, name: str, value: int, old: int) -> None:
        bench = Bench()
        bench.write(**{name: value})
        assert bench.read(name) == old

    def test_the_switch_for_torque_at_power_up_makes_the_servo_hold_where_it_is(self) -> None:
        bench = Bench(scs15(torque_at_power_up=True), at=300)
        assert (bench.read("torque_enable"), bench.read("goal_position")) == (1, 300)
        assert bench.run(1) == 0.0
        assert bench.run(1, at=290) > 0.0


class TestPosition:
    @pytest.mark.parametrize(("at", "reads"), [(0, 0), (1023, 1023), (-50, 0), (1100, 1023)])
    def test_outside_of_its_range_a_potentiometer_stays_at_the_end(self, at: int, reads: int) -> None:
        assert Bench(at=at).read("present_position") == reads

    @BOTH
    def test_a_count_is_the_data_sheets_angle(self, model: ServoModel) -> None:
        bench = Bench(model)
        bench.angle = math.radians({"scs15": 21.5, "scs0009": 30.0}[model.name])  # a tenth of the range
        bench.run(1)
        assert bench.read("present_position") == 512 + 102

    def test_the_loop_saturates_within_seventeen_steps(self) -> None:
        bench = holding(Bench())
        bench.run(1, at=502)
        assert bench.read("present_load") == 600  # 15 x 10 / 0.25
        assert bench.servo.read(60, 2) == b"\x02\x58"
        bench.run(1, at=522)
        assert bench.servo.read(60, 2) == b"\x06\x58", "the sign is bit 10"
        bench.run(1, at=495)
        assert bench.read("present_load") == 1000

    def test_goals_keep_to_the_limits(self) -> None:
        bench = holding(Bench(min_position_limit=200, max_position_limit=800))
        bench.write(goal_position=1000)
        assert bench.run(500, at=800) == pytest.approx(0.0, abs=1e-9)
        bench.write(goal_position=0)
        assert bench.run(800, at=200) == pytest.approx(0.0, abs=1e-9)

    def test_the_largest_torque_bounds_the_output_even_while_locked(self) -> None:
        bench = holding(Bench())
        bench.write(max_torque_limit=300)
        bench.run(1, at=400)
        assert bench.read("present_load") == 300
        bench.power_cycle()
        assert bench.read("max_torque_limit") == 1023

    def test_a_goal_time_is_how_long_it_takes(self) -> None:
        bench = holding(Bench())
        bench.servo.write(42, bytes.fromhex("02 64 00 C8"))  # to 612 in 200 ms
        way = bench.heading(250)
        assert way[49] == pytest.approx(537, abs=1)
        assert way[149] == pytest.approx(587, abs=1)
        assert way[-1] == 612

    def test_a_goal_velocity_is_in_steps_per_second(self) -> None:
        bench = holding(Bench())
        bench.servo.write(42, bytes.fromhex("02 64 00 00 00 FA"))  # to 612 at 250 step/s
        way = bench.heading(450)
        assert way[199] == pytest.approx(562, abs=1)
        assert way[379] == pytest.approx(607, abs=1)
        assert way[-1] == 612

    def test_a_time_takes_the_place_of_a_velocity(self) -> None:
        bench = holding(Bench())
        bench.write(goal_velocity=1, goal_time=100)
        bench.write(goal_position=612)
        assert bench.heading(101)[-1] == 612

    def test_no_time_is_so_short_that_it_exceeds_the_largest_speed(self) -> None:
        bench = holding(Bench())
        bench.write(goal_time=1)
        bench.write(goal_position=884)
        assert bench.heading(100)[-1] == pytest.approx(512 + 186, abs=1)  # 1860 step/s

    @pytest.mark.parametrize(("stops", "goes"), [(False, 612), (True, 512)])
    def test_whether_velocity_0_stops_is_a_switch(self, stops: bool, goes: int) -> None:
        bench = holding(Bench(scs15(speed_0_stops=stops)))
        bench.write(goal_position=612)
        assert bench.heading(100)[-1] == goes

    def test_a_turn_counter_s_reset_changes_nothing(self) -> None:
        bench = holding(Bench())
        bench.run(1, at=500)
        bench.servo.clear_turns()
        assert bench.read("present_position") == 500
        assert bench.read("goal_position") == 512


class TestPwm:
    @pytest.mark.parametrize(
        ("switch", "address", "data", "load"), [
            ("goal_time", 44, "01 2C", 300), ("goal_time", 44, "05 2C", -300),
            ("goal_velocity", 46, "01 2C", 300), ("goal_velocity", 46, "81 2C", -300)])
    def test_with_both_limits_0_one_register_drives_the_motor(
        self, switch: str, address: int, data: str, load: int
    ) -> None:
        bench = Bench(scs15(pwm_goal=switch), **FREE)
        bench.write(torque_enable=1)
        bench.servo.write(address, bytes.fromhex(data))
        bench.run(2, at=600)
        assert bench.read("present_load") == load

    def test_the_limits_back_it_holds_where_it_is(self) -> None:
        bench = Bench(at=300, **FREE)
        bench.write(torque_enable=1, goal_time=500)
        assert bench.run(2) > 0.0
        bench.write(goal_position=300, goal_time=0)
        bench.write(max_position_limit=1023)
        assert bench.run(10) == 0.0


class TestMotor:
    @pytest.mark.parametrize(("model", "rpm"), [(SCS15, 65.0), (SCS0009, 100.0)], ids=["scs15", "scs0009"])
    def test_no_load_speed_is_the_data_sheets(self, model: ServoModel, rpm: float) -> None:
        rig = Rig(model, unloading_condition=0, **FREE)
        rig.write(torque_enable=1, goal_time=1000)
        rig.run(1.0)
        assert rig.speed * RPM == pytest.approx(rpm, rel=0.02)

    @pytest.mark.parametrize(("model", "torque"), [(SCS15, 1.618), (SCS0009, 0.2256)], ids=["scs15", "scs0009"])
    def test_stall_torque_is_the_data_sheets(self, model: ServoModel, torque: float) -> None:
        bench = Bench(model, **FREE)
        bench.write(torque_enable=1, goal_time=1000)
        assert bench.run(2) - model.motor.friction.coulomb_nm == pytest.approx(torque, rel=0.002)

    @BOTH
    def test_a_goal_is_reached_up_to_friction(self, model: ServoModel) -> None:
        rig = Rig(model)
        rig.write(goal_position=512, torque_enable=1)
        rig.write(goal_position=700)
        rig.run(1.0)
        assert abs(rig.read("present_position") - 700) <= 1
        assert rig.read("moving") == 0


class TestProtection:
    def overload(self, bench: Bench) -> None:
        holding(bench).write(goal_position=700)
        bench.run(2300)

    def test_overload_leaves_a_fifth_of_the_output(self) -> None:
        bench = Bench()
        self.overload(bench)
        assert (bench.read("present_load"), bench.servo.error) == (200, 0x20)
        assert bench.read("hardware_error_status") == 0x20
        assert bench.read("torque_enable") == 1

    @pytest.mark.parametrize(("switch", "cleared"), [(True, True), (False, False)])
    def test_a_goal_the_other_way_may_clear_it(self, switch: bool, cleared: bool) -> None:
        bench = Bench(scs15(overload_clears_on_new_goal=switch))
        self.overload(bench)
        bench.write(goal_position=650)
        assert bench.servo.error == 0x20, "the same way"
        bench.write(goal_position=400)
        assert (bench.servo.error == 0) is cleared
        bench.write(torque_enable=0)
        assert bench.servo.error == 0, "torque off clears it in any case"

    def test_its_thresholds_are_registers(self) -> None:
        bench = holding(Bench(overload_torque=50, protection_time=50, protective_torque=10))
        bench.run(600, at=504)  # 0.48
        assert bench.servo.error == 0
        bench.run(600, at=503)  # 0.54
        assert (bench.servo.error, bench.read("present_load")) == (0x20, 100)

    def test_heat_lets_go_until_it_has_passed(self) -> None:
        bench = holding(Bench())
        bench.physics.temperature_c[0] = 80.0
        assert bench.run(10, at=505) > 0.0
        bench.physics.temperature_c[0] = 81.0
        assert bench.run(10) == 0.0
        assert (bench.servo.error, bench.read("present_temperature")) == (0x04, 81)
        bench.physics.temperature_c[0] = 60.0
        assert bench.run(50) > 0.0

    @pytest.mark.parametrize(("volts", "error"), [(4.9, 1), (5.0, 0), (25.0, 0), (25.1, 1)])
    def test_unlike_an_sts_it_lets_go_at_a_wrong_voltage(self, volts: float, error: int) -> None:
        bench = holding(Bench())
        bench.physics.supply_v[0] = volts
        assert (bench.run(10, at=505) > 0.0) is not error
        assert (bench.run(10, at=505) > 0.0) is (error == 0)
        assert bench.servo.error == error
