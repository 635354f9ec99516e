"""The registers of the STS3215 and its protections, the shaft held in a vice."""

import math

import numpy as np
import pytest

from hal.register_map import ServoModel
from robotwalk.assembly import load_servo
from sim_backend.servo_physics import ServoPhysics
from sim_backend.sts_firmware import StsServo

from .rig import MS, Registers

MODEL = load_servo("sts3215")
TICK = 2.0 * math.pi / 4096  # rad


def sts3215(**firmware: object) -> ServoModel:
    """Return the servo with some switches of its firmware changed."""
    return MODEL.model_copy(update={"firmware": MODEL.firmware.model_copy(update=firmware)})


class Bench(Registers):
    """One servo whose shaft is where the test holds it."""

    def __init__(self, model: ServoModel = MODEL, at: int = 2048, **factory_settings: int) -> None:
        self.physics = ServoPhysics([model])
        self.now = 0
        self.shaft = at - 2048
        self.run(0)
        self.servo = StsServo(self.physics, 0, **factory_settings)

    def run(self, ms: int, at: int | None = None, speed: float = 0.0) -> float:
        """Let time pass, the shaft held at a position as the factory counts it; return the torque."""
        if at is not None:
            self.shaft = at - 2048
        for _ in range(max(ms, 1)):
            self.now += MS if ms else 0
            torque = self.physics.step(np.array([self.shaft * TICK]), np.array([speed]), self.now)
        return float(torque[0])

    def power_cycle(self) -> None:
        self.servo.reboot(self.now)
        self.run(300)
        assert self.servo.listens(self.now, 1_000_000)

    def overload(self) -> None:
        """Hold the shaft 1000 steps from its goal until the servo gives in."""
        self.write(goal_position=2048, torque_enable=1)
        self.write(goal_position=3048)
        self.run(2300)


class TestMemory:
    def test_a_new_servo_is_limp_and_has_the_factory_values(self) -> None:
        bench = Bench(at=1234)
        assert bench.run(1) == 0.0
        assert bench.read("torque_enable") == 0
        assert bench.read("present_position") == 1234
        assert bench.read("goal_position") == 0
        assert bench.servo.read(0, 9) == bytes([3, 7, 0, 0x09, 0x03, 1, 0, 0, 1])
        assert bench.servo.read(16, 8) == bytes([0xE8, 0x03, 12, 44, 47, 32, 32, 0])

    def test_factory_settings_are_for_the_eeprom_alone(self) -> None:
        bench = Bench(id=17)
        bench.power_cycle()
        assert bench.read("id") == 17
        with pytest.raises(ValueError, match="lock is not kept"):
            Bench(lock=1)

    def test_it_must_be_an_sts_servo(self) -> None:
        with pytest.raises(ValueError, match="xl430-w250 is no STS servo"):
            StsServo(ServoPhysics([load_servo("xl430-w250")]), 0)

    def test_signs_are_bits_beside_the_magnitude(self) -> None:
        bench = Bench()
        bench.servo.write(31, bytes([0x64, 0x08]))
        assert bench.servo.table["position_offset"] == -100
        bench.servo.write(42, bytes([0x64, 0x80]))
        assert bench.servo.table["goal_position"] == -100
        bench.servo.write(44, bytes([0x64, 0x04]))
        assert bench.servo.table["goal_pwm"] == -100

    @pytest.mark.parametrize(("lock", "kept"), [(0, 16), (1, 32)])
    def test_eeprom_outlives_power_only_if_it_is_unlocked(self, lock: int, kept: int) -> None:
        bench = Bench()
        bench.write(lock=lock, position_p_gain=16)
        assert bench.read("position_p_gain") == 16
        bench.power_cycle()
        assert bench.read("position_p_gain") == kept

    def test_a_locked_write_acts_until_power_off(self) -> None:
        bench = Bench()
        bench.write(lock=1, id=9, baud_rate=1)
        assert bench.servo.id == 9
        assert bench.servo.listens(bench.now, 500_000)
        bench.power_cycle()
        assert bench.servo.id == 1

    def test_eeprom_is_written_with_torque_on(self) -> None:
        bench = Bench()
        bench.write(goal_position=2048, torque_enable=1, position_p_gain=16)
        bench.run(1, at=1948)
        assert bench.read("present_load") == 407  # 16 x 100 / 3.927

    def test_power_up_brings_ram_back_and_copies_the_torque_limit(self) -> None:
        bench = Bench()
        bench.write(max_torque_limit=500, acceleration=50, goal_position=2048, torque_enable=1, torque_limit=1000)
        assert bench.read("torque_limit") == 1000
        bench.servo.reboot(bench.now)
        assert bench.run(1) == 0.0
        assert not bench.servo.listens(bench.now, 1_000_000)
        bench.run(299)
        assert bench.servo.listens(bench.now, 1_000_000)
        assert [bench.read(name) for name in ("torque_enable", "acceleration", "goal_position")] == [0, 0, 0]
        assert bench.read("torque_limit") == 500

    def test_the_switch_for_torque_at_power_up_makes_the_servo_hold_where_it_is(self) -> None:
        bench = Bench(sts3215(torque_at_power_up=True), at=1234)
        assert (bench.read("torque_enable"), bench.read("goal_position")) == (1, 1234)
        assert bench.run(1) == 0.0
        assert bench.run(1, at=1224) > 0.0

    @pytest.mark.parametrize(
        ("name", "value", "old"), [
            ("id", 254, 1), ("baud_rate", 8, 0), ("status_return_level", 2, 1), ("operating_mode", 4, 0),
            ("torque_enable", 3, 0), ("goal_position", 30_720, 0), ("goal_position", -32_668, 0),
            ("torque_limit", 1001, 1000), ("lock", 2, 0), ("present_position", 5, 2048), ("model_number", 5, 777)])
    def test_what_does_not_fit_is_not_taken(self, name: str, value: int, old: int) -> None:
        bench = Bench()
        bench.write(**{name: value})
        assert bench.read(name) == old

    def test_of_a_block_each_register_is_taken_or_not(self) -> None:
        bench = Bench()
        bench.servo.write(41, bytes([50, 0xE8, 0x03, 0xFF, 0xFF, 100, 0]))  # PWM -1023 does not fit
        assert [bench.read(name) for name in ("acceleration", "goal_position", "goal_velocity")] == [50, 1000, 100]
        assert bench.read("goal_pwm") == 0

    def test_half_a_register_may_be_written(self) -> None:
        bench = Bench()
        bench.write(goal_position=0x0123)
        bench.servo.write(43, b"\x04")
        assert bench.read("goal_position") == 0x0423
        assert bench.read("goal_position_echo") == 0x0423

    def test_a_write_far_behind_the_table_goes_nowhere(self) -> None:
        bench = Bench()
        before = bytes(bench.servo.table.data)
        bench.servo.write(200, b"\1\2\3")
        bench.servo.write(86, b"\1\2\3")
        assert bytes(bench.servo.table.data) == before


class TestPosition:
    def test_the_offset_is_taken_off_the_position(self) -> None:
        bench = Bench(at=2148, position_offset=100)
        assert bench.read("present_position") == 2048
        bench.write(position_offset=-100)
        assert bench.read("present_position") == 2248

    @pytest.mark.parametrize("at", [1, 700, 2048, 4095])
    def test_torque_enable_128_makes_here_the_centre(self, at: int) -> None:
        bench = Bench(at=at)
        bench.write(torque_enable=128)
        assert bench.read("present_position") == 2048
        assert bench.read("position_offset") == at - 2048
        assert bench.read("torque_enable") == 0
        bench.power_cycle()
        assert bench.read("present_position") == 2048

    def test_the_new_centre_is_forgotten_if_the_eeprom_is_locked(self) -> None:
        bench = Bench(at=700)
        bench.write(lock=1, torque_enable=128)
        bench.power_cycle()
        assert bench.read("present_position") == 700

    @pytest.mark.parametrize(("at", "folded", "counted"), [(4100, 4, 4100), (-5, 4091, -5), (9000, 808, 9000)])
    def test_phase_bit_4_counts_turns(self, at: int, folded: int, counted: int) -> None:
        for phase, position in ((12, folded), (28, counted)):
            bench = Bench(phase=phase)
            bench.run(1, at=at)
            assert bench.read("present_position") == position

    def test_torque_on_holds_the_position_that_was_read_whatever_turn_it_is(self) -> None:
        bench = Bench()
        bench.run(1, at=5000)
        bench.write(goal_position=bench.read("present_position"), torque_enable=1)
        assert bench.run(1) == 0.0
        assert bench.run(1, at=4990) > 0.0

    def test_goals_keep_to_the_limits(self) -> None:
        bench = Bench(min_position_limit=1000, max_position_limit=3000)
        bench.write(goal_position=3500, torque_enable=1)
        assert bench.run(500, at=3000) == pytest.approx(0.0, abs=1e-9)
        assert bench.read("goal_position") == 3500
        bench.write(goal_position=-100)
        assert bench.run(1000, at=1000) == pytest.approx(0.0, abs=1e-9)

    def test_with_both_limits_0_goals_reach_over_many_turns(self) -> None:
        bench = Bench(min_position_limit=0, max_position_limit=0, phase=28)
        bench.write(goal_position=10_000, torque_enable=1)
        assert bench.run(3000, at=10_000) == pytest.approx(0.0, abs=1e-9)
        bench.write(goal_position=-10_000)
        assert bench.run(6500, at=-10_000) == pytest.approx(0.0, abs=1e-9)
        assert bench.read("present_position") == -10_000

    def test_the_loop_is_the_identified_one(self) -> None:
        bench = Bench()
        bench.write(goal_position=2048, torque_enable=1)
        # 50 steps are 0.0767 rad; x 0.166 x 32 = 0.4074 of 7.4 V; x 1.211641 / 2.676166
        assert bench.run(1, at=1998) == pytest.approx(1.3651, abs=1e-3)
        assert bench.read("present_load") == 407
        assert bench.run(1, at=2098) == pytest.approx(-1.3651, abs=1e-3)
        assert bench.servo.read(60, 2) == bytes([0x97, 0x05])  # 407 and the sign in bit 10
        bench.run(1, at=1000)
        assert bench.read("present_load") == 970

    def test_the_torque_limit_bounds_the_output(self) -> None:
        bench = Bench()
        bench.write(goal_position=2048, torque_enable=1, torque_limit=300)
        bench.run(1, at=1000)
        assert bench.read("present_load") == 300

    def test_the_derivative_gain_acts_only_with_its_switch(self) -> None:
        for acts, load in ((False, 0), (True, -5)):  # 32 x 0.6519 steps per ms / 3.927
            bench = Bench(sts3215(derivative_gain=acts))
            bench.write(goal_position=2048, torque_enable=1)
            bench.run(1, speed=1.0)
            assert bench.read("present_load") == load

    def test_the_integral_gain_adds_up(self) -> None:
        bench = Bench(position_i_gain=10)
        bench.write(goal_position=2048, torque_enable=1)
        bench.run(100, at=2047)
        assert bench.read("present_load") == pytest.approx(8 + 25, abs=1)  # 10 x 1 step x 0.1 s / 0.01 s / 3.927

    def test_damping_brakes_only_with_its_switch(self) -> None:
        for brakes, torque in ((False, 0.0), (True, -0.5486)):  # kt^2 / R
            bench = Bench(sts3215(damping=brakes))
            bench.write(torque_enable=2)
            assert bench.read("torque_enable") == 2
            assert bench.run(1, speed=1.0) == pytest.approx(torque, abs=1e-4)
            assert bench.run(1, at=1000) == 0.0


class TestProtection:
    def test_overload_leaves_a_fifth_of_the_output(self) -> None:
        bench = Bench()
        bench.write(goal_position=2048, torque_enable=1)
        bench.write(goal_position=3048)
        bench.run(1900)
        assert (bench.read("present_load"), bench.servo.error) == (970, 0)
        bench.run(300)
        assert (bench.read("present_load"), bench.servo.error) == (200, 0x20)
        assert bench.read("hardware_error_status") == 0x20
        assert bench.read("torque_enable") == 1
        bench.run(5000)
        assert bench.read("present_load") == 200, "it lasts"

    def test_its_thresholds_are_registers(self) -> None:
        bench = Bench(overload_torque=50, protection_time=50, protective_torque=10)
        bench.write(goal_position=2048, torque_enable=1)
        bench.run(600, at=2048 - 60)  # 0.489
        assert bench.servo.error == 0
        bench.run(600, at=2048 - 63)  # 0.513
        assert (bench.servo.error, bench.read("present_load")) == (0x20, 100)

    def test_a_short_effort_is_no_overload(self) -> None:
        bench = Bench()
        bench.write(goal_position=2048, torque_enable=1)
        for _ in range(3):
            bench.run(1900, at=1000)
            bench.run(10, at=2048)
        assert bench.servo.error == 0

    @pytest.mark.parametrize(("switch", "cleared"), [(True, True), (False, False)])
    def test_a_goal_the_other_way_may_clear_it(self, switch: bool, cleared: bool) -> None:
        bench = Bench(sts3215(overload_clears_on_new_goal=switch))
        bench.overload()
        bench.write(goal_position=2500)
        assert bench.servo.error == 0x20, "the same way"
        bench.write(goal_position=1500)
        assert (bench.servo.error == 0) is cleared
        bench.run(600)
        assert bench.read("present_load") == (-970 if cleared else -200)

    @pytest.mark.parametrize(("mode", "goal", "value"), [(1, "goal_velocity", 3000), (2, "goal_pwm", 1000)])
    def test_so_it_is_in_the_other_modes(self, mode: int, goal: str, value: int) -> None:
        bench = Bench(operating_mode=mode)
        bench.write(torque_enable=1, **{goal: value})
        bench.run(2100)
        assert (bench.servo.error, bench.read("present_load")) == (0x20, 200)
        bench.write(**{goal: value - 1})
        assert bench.servo.error == 0x20
        bench.write(**{goal: -value})
        assert bench.servo.error == 0

    def test_torque_off_and_on_clears_it_in_any_case(self) -> None:
        bench = Bench(sts3215(overload_clears_on_new_goal=False))
        bench.overload()
        bench.write(torque_enable=1)
        assert bench.servo.error == 0x20
        bench.write(torque_enable=0)
        assert bench.servo.error == 0
        bench.write(torque_enable=1)
        bench.run(300)
        assert bench.read("present_load") == 970

    def test_overload_that_is_not_masked_is_reported_while_it_lasts(self) -> None:
        bench = Bench(unloading_condition=0)
        bench.overload()
        assert (bench.servo.error, bench.read("present_load")) == (0x20, 970)
        bench.run(10, at=3048)
        assert bench.servo.error == 0

    def test_too_much_current_lets_go(self) -> None:
        bench = Bench(protection_current=200, over_current_time=10, overload_torque=100)  # 1.3 A, 0.1 s
        bench.write(goal_position=2048, torque_enable=1)
        bench.run(90, at=1000)
        assert bench.servo.read(69, 2) == bytes([0x9D, 0x01])  # 413 x 6.5 mA: 7.4 V x 0.97 / 2.676 ohm
        assert bench.servo.error == 0
        assert bench.run(30) == 0.0
        assert bench.servo.error == 0x08
        assert bench.run(500) == 0.0
        bench.write(goal_position=900)
        bench.run(50)
        assert (bench.servo.error, bench.read("present_load")) == (0, pytest.approx(-815, abs=1))

    def test_a_current_the_other_way_round_counts_too(self) -> None:
        bench = Bench(protection_current=200, over_current_time=10)
        bench.write(goal_position=2048, torque_enable=1)
        bench.run(20, at=3000)
        assert bench.servo.read(69, 2) == bytes([0x9D, 0x81])
        bench.run(100)
        assert bench.servo.error == 0x08

    def test_heat_lets_go_until_it_has_passed(self) -> None:
        bench = Bench()
        bench.write(goal_position=2048, torque_enable=1)
        bench.physics.temperature_c[0] = 70.0
        assert bench.run(10, at=2000) > 0.0
        bench.physics.temperature_c[0] = 71.0
        assert bench.run(10) == 0.0
        assert (bench.servo.error, bench.read("present_temperature")) == (0x04, 71)
        assert bench.read("torque_enable") == 1
        bench.physics.temperature_c[0] = 60.0
        assert bench.run(50) > 0.0
        assert bench.servo.error == 0

    @pytest.mark.parametrize(("volts", "counts", "error"), [(3.9, 39, 1), (4.0, 40, 0), (8.0, 80, 0), (8.1, 81, 1)])
    def test_voltage_lets_go_only_if_it_is_masked(self, volts: float, counts: int, error: int) -> None:
        for mask, holds in ((44, True), (45, not error)):
            bench = Bench(unloading_condition=mask)
            bench.write(goal_position=2048, torque_enable=1)
            bench.physics.supply_v[0] = volts
            assert (bench.run(10, at=2000) > 0.0) is holds
            assert bench.read("present_input_voltage") == counts
            assert bench.servo.error == error

    def test_power_up_forgets_an_overload(self) -> None:
        bench = Bench()
        bench.overload()
        bench.power_cycle()
        assert bench.servo.error == 0
        assert bench.read("hardware_error_status") == 0
