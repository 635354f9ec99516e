"""What a simulated AX-12A does with its motor, and how it protects itself."""

import math

import numpy as np
import pytest

from .ax_bus import MODEL, STEP, AxBus

OVERLOAD, OVERHEATING, VOLTAGE = 0x20, 0x04, 0x01


def joint(*, goal: int | None = None, **eeprom: int) -> AxBus:
    """Servo 1 with torque on."""
    bus = AxBus(1, **eeprom)
    assert bus.write(24, 1) == 0
    if goal is not None:
        assert bus.write_word(30, goal) == 0
    return bus


class TestJointMode:
    def test_it_goes_to_its_goal_counter_clockwise_positive(self) -> None:
        bus = joint(goal=712)
        bus.run(0.1)
        assert 0 < bus.word(38) < 1024, "bit 10 of the speed is 0 counter-clockwise"
        bus.run(0.9)
        assert math.degrees(bus.angle) == pytest.approx(200 * STEP, abs=2 * STEP)
        assert bus.word(36) == pytest.approx(712, abs=2)

    def test_the_other_way_speed_and_load_have_bit_10_set(self) -> None:
        bus = joint(goal=312)
        bus.run(0.1)
        assert bus.word(38) > 1024
        assert bus.word(40) == 1024 + 1023, "full duty, clockwise"

    def test_torque_comes_on_where_the_shaft_is(self) -> None:
        bus = joint()
        bus.run(0.2)
        assert bus.angle == pytest.approx(0.0, abs=math.radians(STEP))

    def test_limp_it_does_not_move(self) -> None:
        bus = AxBus(1)
        bus.write_word(30, 700)
        bus.run(0.2)
        assert bus.angle == 0.0

    def test_an_old_goal_pulls_when_torque_comes_on(self) -> None:
        bus = AxBus(1)
        bus.write_word(30, 700)
        bus.write(24, 1)
        bus.run(0.1)
        assert bus.angle > 0.1

    @pytest.mark.parametrize(("follows", "goal"), [(False, 512), (True, 552)])
    def test_whether_the_goal_follows_a_limp_shaft_is_a_switch(self, follows: bool, goal: int) -> None:
        bus = AxBus(1, firmware={"goal_follows_present": follows})
        bus.hinge.data.qpos[0] = math.radians(40 * STEP)
        bus.run(0.01)
        bus.write(24, 1)
        assert bus.word(30) == goal

    @pytest.mark.parametrize(("counts", "rpm"), [(200, 22.2), (300, 33.3)])
    def test_moving_speed_is_in_0_111_rpm(self, counts: int, rpm: float) -> None:
        bus = joint()
        bus.write_word(32, counts)
        bus.write_word(30, 912)
        bus.run(0.1)
        start = bus.angle
        bus.run(0.2)
        assert (bus.angle - start) / 0.2 * 60 / math.tau == pytest.approx(rpm, rel=0.05)
        assert bus.word(38) == pytest.approx(bus.speed * 60 / math.tau / 0.111, abs=1)
        assert bus.read(1, 46, 1) == b"\x01"

    def test_moving_speed_0_is_as_fast_as_it_can(self) -> None:
        bus = joint(goal=1023)
        bus.run(0.3)
        assert bus.speed * 60 / math.tau == pytest.approx(59, rel=0.1), "the data sheet's no-load speed"


class TestCompliance:
    """duty = punch / 1023 + (error - margin) / slope; the shaft is held where it is."""

    def duty(self, error: int, **settings: int) -> float:
        """Return the duty at so many steps of error."""
        bus = joint()
        for name, value in settings.items():
            register = MODEL[name]
            assert bus.write(register.address, *value.to_bytes(register.size, "little")) == 0
        bus.write_word(30, 512 + error)
        bus.physics.step(np.zeros(1), np.zeros(1), bus.now)
        return float(bus.physics.duty[0])

    @pytest.mark.parametrize("error", [-1, 0, 1])
    def test_within_the_margin_it_does_nothing(self, error: int) -> None:
        assert self.duty(error) == 0.0

    @pytest.mark.parametrize(("error", "duty"), [(2, 32 / 1023 + 1 / 32), (9, 32 / 1023 + 8 / 32), (40, 1.0)])
    def test_beyond_it_the_duty_rises_by_the_slope_from_the_punch_on(self, error: int, duty: float) -> None:
        assert self.duty(error) == pytest.approx(duty)
        assert self.duty(-error) == pytest.approx(-duty)

    def test_margin_slope_punch_and_torque_limit_are_obeyed(self) -> None:
        both = {"cw_compliance_margin": 5, "ccw_compliance_margin": 5}
        assert self.duty(5, **both) == 0.0
        assert self.duty(6, **both) == pytest.approx(32 / 1023 + 1 / 32)
        assert self.duty(2, punch=512) == pytest.approx(512 / 1023 + 1 / 32)
        assert self.duty(100, torque_limit=512) == pytest.approx(512 / 1023)

    @pytest.mark.parametrize(
        ("slope", "counts_as"), [(0, 2), (3, 2), (4, 4), (25, 16), (31, 16), (63, 32), (64, 64), (254, 128)])
    def test_a_slope_counts_as_its_highest_bit(self, slope: int, counts_as: int) -> None:
        both = {"cw_compliance_slope": slope, "ccw_compliance_slope": slope}
        assert self.duty(2, **both) == pytest.approx(32 / 1023 + 1 / counts_as)


class TestWheelMode:
    def wheel(self, speed: int) -> AxBus:
        bus = joint(cw_angle_limit=0, ccw_angle_limit=0)
        assert bus.write_word(32, speed) == 0
        return bus

    def test_it_turns_without_end_at_a_share_of_the_output(self) -> None:
        bus = self.wheel(1023)
        bus.run(1.5)
        assert bus.angle > math.tau
        assert bus.speed * 60 / math.tau == pytest.approx(59, rel=0.02)

    def test_bit_10_turns_it_clockwise(self) -> None:
        bus = self.wheel(1024 + 512)
        bus.run(0.3)
        assert bus.speed * 60 / math.tau == pytest.approx(-59 * 512 / 1023, rel=0.1)

    def test_it_becomes_a_joint_again_with_limits(self) -> None:
        bus = self.wheel(0)
        assert bus.write(6, 0, 0, 0xFF, 3) == 0
        assert bus.write_word(30, 612) == 0
        bus.run(0.8)
        assert math.degrees(bus.angle) == pytest.approx(100 * STEP, abs=2 * STEP)


class TestDeadZone:
    """Of a turn 300 degrees have a position, 0 to 1023."""

    @pytest.mark.parametrize(
        ("degrees", "reads"),
        [(0, 512), (149, 1021), (-149, 3), (151, 1023), (179, 1023), (181, 0), (-151, 0), (-179, 0), (360, 512),
         (-360 + 30, 614)],
    )
    def test_what_the_position_reads(self, degrees: float, reads: int) -> None:
        bus = AxBus(1)
        bus.hinge.data.qpos[0] = math.radians(degrees)
        bus.run(0.001)
        assert bus.word(36) == pytest.approx(reads, abs=1)

    @pytest.mark.parametrize("degrees", [151, -151])
    def test_what_it_reads_there_is_a_switch(self, degrees: float) -> None:
        bus = AxBus(1, firmware={"dead_zone_reads": "zero"})
        bus.hinge.data.qpos[0] = math.radians(degrees)
        bus.run(0.001)
        assert bus.word(36) == 0

    @pytest.mark.parametrize(("degrees", "back"), [(170, 140.0), (190, 220.0)])
    def test_out_of_it_a_joint_goes_by_the_nearer_end(self, degrees: float, back: float) -> None:
        bus = AxBus(1)
        bus.hinge.data.qpos[0] = math.radians(degrees)
        bus.run(0.001)
        bus.write(24, 1)
        bus.write_word(30, 512 + round((140 if back == 140 else -140) / STEP))
        bus.run(1.0)
        assert math.degrees(bus.angle) == pytest.approx(back, abs=2 * STEP)


class TestProtections:
    def strained(self, **eeprom: int) -> AxBus:
        """A servo that pushes against a stiff spring, with no hope of getting to its goal."""
        bus = joint(**eeprom)
        bus.write_word(30, 1000)
        bus.hinge._mujoco.jnt_stiffness[0] = 20.0
        return bus

    def test_overload_takes_the_torque_away_and_is_told_with_every_answer(self) -> None:
        bus = self.strained()
        bus.run(1.5)
        assert bus.write(25, 0) == 0, "not yet"
        bus.run(1.0)
        assert bus.word(34) == 0
        assert bus.send(1, 1)[4] == OVERLOAD
        assert bus.send(1, 2, 36, 6)[4] == OVERLOAD, "with valid data"
        assert bus.send(1, 0x77)[4] == OVERLOAD | 0x40, "beside a refusal"
        assert bus.read(1, 24, 1) == b"\x01"
        assert float(bus.physics.duty[0]) == 0.0

    def test_writing_the_torque_limit_brings_it_back(self) -> None:
        bus = self.strained()
        bus.run(2.5)
        bus.hinge._mujoco.jnt_stiffness[0] = 0.0
        assert bus.write_word(34, 1023) == OVERLOAD, "as it was before the write"
        assert bus.send(1, 1)[4] == 0
        bus.run(1.0)
        assert bus.word(36) == pytest.approx(1000, abs=2)

    def test_power_brings_the_torque_limit_back_to_max_torque(self) -> None:
        bus = self.strained(max_torque=900)
        bus.run(2.5)
        bus.servos[0].reboot(bus.now)
        bus.run(0.4)
        assert bus.word(34) == 900
        assert bus.send(1, 1)[4] == 0

    def test_without_the_bit_in_shutdown_it_goes_on_and_tells(self) -> None:
        bus = self.strained(shutdown=0)
        bus.run(2.5)
        assert bus.word(34) == 1023
        assert bus.send(1, 1)[4] == OVERLOAD

    @pytest.mark.parametrize(("degrees", "told"), [(70, 0), (71, OVERHEATING)])
    def test_heat(self, degrees: float, told: int) -> None:
        bus = joint()
        bus.physics.temperature_c[0] = degrees
        bus.run(0.02)
        assert bus.send(1, 1)[4] == told
        assert bus.word(34) == (0 if told else 1023)

    def test_heat_passes_and_the_torque_limit_stays_0(self) -> None:
        bus = joint()
        bus.physics.temperature_c[0] = 80
        bus.run(0.02)
        assert bus.write_word(34, 1023) == OVERHEATING
        bus.run(0.02)
        assert bus.word(34) == 0, "it is still hot"
        bus.physics.temperature_c[0] = 60
        bus.run(0.02)
        assert bus.send(1, 1)[4] == 0
        assert bus.word(34) == 0
        assert bus.write_word(34, 1023) == 0
        bus.run(0.02)
        assert bus.word(34) == 1023

    @pytest.mark.parametrize(("volts", "told"), [(5.8, VOLTAGE), (6.0, 0), (14.0, 0), (14.2, VOLTAGE)])
    def test_voltage_is_told_and_does_not_shut_down_by_default(self, volts: float, told: int) -> None:
        bus = joint()
        bus.physics.supply_v[0] = volts
        bus.run(0.02)
        answer = bus.send(1, 2, 42, 1)
        assert (answer[4], answer[5]) == (told, round(10 * volts))
        assert bus.word(34) == 1023
