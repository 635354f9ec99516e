import copy
import itertools
import math
from collections.abc import Mapping

import numpy as np
import pytest

from hal.register_map import Register, ServoModel
from robotwalk.config import library
from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.servo_physics import Drive, Scales, ServoPhysics

from .rig import MS, Hinge, Registers, Turning

ROWS = library.open_document("servos", "xl430-w250").value(())
TICK = 2.0 * math.pi / 4096  # rad
RPM = 60.0 / (2.0 * math.pi)


def servo_model(**sections: Mapping[str, object]) -> ServoModel:
    """Return the XL430 with some entries of its sections changed."""
    rows = copy.deepcopy(ROWS)
    for section, entries in sections.items():
        rows[section].update(entries)
    return ServoModel.model_validate(rows)


MODEL = servo_model()


class Bench(Registers):
    """One servo, without a body: the test moves the shaft."""

    def __init__(self, model: ServoModel = MODEL, **factory_settings: int) -> None:
        self.physics = ServoPhysics([model])
        self.servo = DynamixelServo(self.physics, 0, **factory_settings)
        self.now = 0

    def read_bytes(self, register: Register) -> bytes:
        return self.servo.read(register.address, register.size, self.now)

    def step(self, angle: float = 0.0, speed: float = 0.0) -> float:
        """Let one millisecond pass; return the torque."""
        self.now += MS
        return float(self.physics.step(np.array([angle]), np.array([speed]), self.now)[0])

    def trajectory(self, ms: int) -> tuple[list[int], list[int]]:
        """Return the positions and velocities that the firmware aims at in each millisecond."""
        rows = []
        for _ in range(ms):
            self.step()
            rows.append((self.read("position_trajectory"), self.read("velocity_trajectory")))
        return [row[0] for row in rows], [row[1] for row in rows]


class Rig(Turning, Bench):
    """One servo whose shaft MuJoCo moves."""

    def __init__(self, model: ServoModel = MODEL, spring: float = 0.0, **factory_settings: int) -> None:
        super().__init__(model, **factory_settings)
        self.hinge = Hinge(self.physics, spring)


def test_stall_torque_is_the_data_sheets() -> None:
    # A spring so soft that the shaft creeps up to the stall and friction opposes it to the end.
    rig = Rig(spring=1.0, operating_mode=16)
    rig.write(torque_enable=1, goal_pwm=885)
    rig.run(0.5)
    while rig.speed > 0.01:  # below, MuJoCo's friction is no longer whole
        rig.run(0.01)
    assert rig.read("present_pwm") == 885
    assert 1.0 * rig.angle == pytest.approx(1.4, rel=0.03)


def test_no_load_speed_is_the_data_sheets() -> None:
    rig = Rig(operating_mode=16)
    rig.write(torque_enable=1, goal_pwm=885)
    rig.run(1.5)
    assert rig.speed * RPM == pytest.approx(57.0, rel=0.03)
    assert rig.read("present_velocity") == pytest.approx(57.0 / 0.229, rel=0.03)


@pytest.mark.parametrize(("volts", "rpm"), [(9.0, 47.0), (12.0, 61.0)])
def test_no_load_speed_follows_the_supply(volts: float, rpm: float) -> None:
    rig = Rig(operating_mode=16)
    rig.physics.supply_v[0] = volts
    rig.write(torque_enable=1, goal_pwm=885)
    rig.run(1.5)
    assert rig.speed * RPM == pytest.approx(rpm, rel=0.05)


def test_without_torque_the_shaft_turns_freely_and_with_it_the_motor_brakes() -> None:
    bench = Bench(operating_mode=16)
    assert bench.step(speed=1.0) == 0.0
    bench.write(torque_enable=1)
    assert bench.step(speed=1.0) == pytest.approx(-0.2265, abs=1e-4)  # kt^2 / R


def test_a_position_goal_is_reached_up_to_friction() -> None:
    rig = Rig()
    rig.write(torque_enable=1, goal_position=2548)
    rig.run(1.0)
    # 0.04 N m of friction is 0.308 V: 24.6 PWM counts, which 5 ticks of error make.
    assert abs(rig.read("present_position") - 2548) <= 5
    assert rig.angle == pytest.approx(500 * TICK, abs=5 * TICK)


def test_the_loop_sees_whole_ticks() -> None:
    bench = Bench()
    bench.write(torque_enable=1)
    assert bench.step(angle=0.49 * TICK) == 0.0
    assert bench.step(angle=0.51 * TICK) == pytest.approx(-0.00814, abs=1e-5)
    assert bench.read("present_pwm") == -5


def test_goal_pwm_and_pwm_limit_bound_the_position_loop() -> None:
    bench = Bench(pwm_limit=300)
    bench.write(torque_enable=1, goal_position=3048)
    bench.step()
    assert bench.read("present_pwm") == 300
    bench.write(goal_pwm=200)
    bench.step()
    assert (bench.read("present_pwm"), bench.read("present_load")) == (200, 226)


def test_the_pwm_limit_bounds_an_older_goal_in_pwm_mode() -> None:
    bench = Bench(operating_mode=16)
    bench.write(goal_pwm=-800, pwm_limit=300, torque_enable=1)
    bench.step()
    assert bench.read("present_pwm") == -300


def test_integral_gain_carries_a_steady_load() -> None:
    rig = Rig(spring=0.5)
    rig.write(torque_enable=1, goal_position=2548)
    rig.run(1.0)
    without = 2548 - rig.read("present_position")
    rig.write(position_i_gain=300)
    rig.run(3.0)
    assert without > 40
    assert abs(2548 - rig.read("present_position")) <= 5  # what friction holds


def test_the_integral_does_not_wind_up() -> None:
    bench = Bench()
    bench.write(position_i_gain=16383, torque_enable=1, goal_position=2148)
    for _ in range(1000):
        bench.step()
    for _ in range(20):
        bench.step(angle=300 * TICK)
    assert bench.read("present_pwm") < 0


def test_the_factorys_derivative_gain_acts_only_if_the_switch_is_set() -> None:
    for acts, pwm in ((False, 0), (True, -163)):  # 4000 / 16 x 0.6519 ticks per ms
        bench = Bench(servo_model(firmware={"derivative_gain": acts}))
        bench.write(torque_enable=1)
        bench.step(speed=1.0)
        assert bench.read("present_pwm") == pwm


def test_feed_forward_gains_act_on_the_profile() -> None:
    bench = Bench()
    bench.write(
        torque_enable=1, position_p_gain=0, feedforward_1st_gain=100, feedforward_2nd_gain=16383,
        profile_velocity=100, profile_acceleration=20, goal_position=3048)
    bench.step()
    assert bench.read("present_pwm") == 20  # 16383 / 4 x 0.004883 ticks per ms^2
    for _ in range(500):
        bench.step()
    assert bench.read("present_pwm") == 39  # 100 / 4 x 1.563 ticks per ms


def test_velocity_mode_reaches_its_goal() -> None:
    rig = Rig(operating_mode=1)
    rig.write(torque_enable=1, goal_velocity=-100)
    rig.run(3.0)
    assert rig.speed * RPM == pytest.approx(-22.9, rel=0.02)


def test_velocity_mode_ramps_with_the_profiles_acceleration() -> None:
    bench = Bench(operating_mode=1)
    bench.write(torque_enable=1, profile_acceleration=20, goal_velocity=100)
    _, velocity = bench.trajectory(400)
    assert velocity[159] == 50  # 320 ms to 100
    assert velocity[321:] == [100] * 79
    bench.write(goal_velocity=0)
    _, velocity = bench.trajectory(330)
    assert velocity[159] == 50
    assert velocity[-1] == 0


def test_extended_position_mode_turns_more_than_once() -> None:
    rig = Rig(operating_mode=4)
    rig.write(torque_enable=1, goal_position=-3072)
    rig.run(1.9)
    assert rig.angle == pytest.approx(-2.5 * math.pi, abs=0.01)
    assert abs(rig.read("present_position") + 3072) <= 5


def test_reverse_mode_turns_every_sign() -> None:
    rig = Rig(drive_mode=1)
    rig.write(torque_enable=1, goal_position=2548)
    rig.run(0.1)
    assert rig.speed < 0.0
    assert rig.read("present_velocity") > 0
    assert rig.read("present_load") > 0
    rig.run(1.0)
    assert rig.angle == pytest.approx(-500 * TICK, abs=5 * TICK)
    assert abs(rig.read("present_position") - 2548) <= 5


@pytest.mark.parametrize(("mode", "goal"), [(1, "goal_velocity"), (16, "goal_pwm")])
def test_reverse_mode_turns_velocity_and_pwm_goals_too(mode: int, goal: str) -> None:
    rig = Rig(drive_mode=1, operating_mode=mode)
    rig.write(torque_enable=1, **{goal: 200})
    rig.run(1.0)
    assert rig.speed < -0.5
    assert rig.read("present_pwm") > 0


def test_the_homing_offset_shifts_position_and_goal() -> None:
    rig = Rig(homing_offset=100)
    assert rig.read("present_position") == 2148
    rig.write(torque_enable=1, goal_position=2248)
    rig.run(1.0)
    assert rig.angle == pytest.approx(100 * TICK, abs=5 * TICK)


def test_a_large_homing_offset_is_ignored_in_position_mode_alone() -> None:
    assert Bench(homing_offset=-1024).read("present_position") == 1024
    assert Bench(homing_offset=-1025).read("present_position") == 2048
    assert Bench(homing_offset=-1025, operating_mode=4).read("present_position") == 1023


def test_without_a_profile_the_goal_is_a_step() -> None:
    bench = Bench()
    bench.write(torque_enable=1, profile_acceleration=20, goal_position=3000)
    assert bench.trajectory(1) == ([3000], [0])


def test_a_trapezoidal_profile() -> None:
    bench = Bench()
    bench.write(torque_enable=1, profile_velocity=100, profile_acceleration=20, goal_position=4095)
    position, velocity = bench.trajectory(1700)
    # 100 counts are 1563.3 ticks/s, reached in 320.2 ms; 2047 / 1563.3 + 0.3202 = 1.6296 s
    assert max(velocity) == 100
    assert next(ms + 1 for ms, v in enumerate(velocity) if v == 100) == pytest.approx(319, abs=2)
    assert next(ms + 1 for ms, p in enumerate(position) if p == 4095) == pytest.approx(1614, abs=4)
    assert next(ms + 1 for ms, v in enumerate(velocity) if ms > 400 and v == 0) == pytest.approx(1629, abs=2)
    assert max(position) == 4095


def test_a_triangular_profile() -> None:
    bench = Bench()
    bench.write(torque_enable=1, profile_velocity=100, profile_acceleration=20, goal_position=1948)
    position, velocity = bench.trajectory(300)
    assert min(velocity) == -45  # sqrt(4883 x 100) = 698.8 ticks/s
    assert velocity.index(-45) == pytest.approx(142, abs=1)
    assert velocity[285:] == [0] * 15  # 286 ms
    assert min(position) == position[-1] == 1948


def test_a_rectangular_profile() -> None:
    bench = Bench()
    bench.write(torque_enable=1, profile_velocity=100, goal_position=3048)
    position, velocity = bench.trajectory(650)
    assert velocity[:639] == [100] * 639  # 1000 / 1563.3 = 639.7 ms
    assert velocity[640:] == [0] * 10
    assert position[319] == 2048 + 500
    assert position[640] == 3048


def test_a_time_based_profile_takes_the_time_it_is_given() -> None:
    bench = Bench(drive_mode=4)
    bench.write(torque_enable=1, profile_velocity=800, profile_acceleration=200, goal_position=2648)
    position, velocity = bench.trajectory(850)
    assert max(velocity) == 64  # 600 ticks / 0.6 s = 1000 ticks/s
    assert position[199] == 2148  # 100 ticks in the ramp
    assert position[399] == 2348
    assert velocity[797] > 0
    assert velocity[799:] == [0] * 51
    assert position[-1] == 2648


def test_a_goal_changed_in_motion_is_reached_without_a_jolt() -> None:
    bench = Bench()
    bench.write(torque_enable=1, profile_velocity=100, profile_acceleration=20, goal_position=3048)
    before = bench.trajectory(500)
    bench.write(goal_position=2048)
    after = bench.trajectory(1200)
    velocity = before[1] + after[1]
    # On for v^2 / 2a = 250 ticks, then back all 782 of them: 0.320 + 0.820 s.
    assert max(after[0]) == pytest.approx(2830, abs=2)
    assert max(abs(b - a) for a, b in itertools.pairwise(velocity)) <= 1
    assert after[1][1137] < 0
    assert after[1][1142:] == [0] * 58
    assert after[0][-1] == 2048


def test_a_profile_begins_where_the_shaft_is() -> None:
    bench = Bench()
    bench.step(angle=500 * TICK)
    bench.write(profile_velocity=100, torque_enable=1)
    bench.step(angle=500 * TICK)
    assert bench.read("position_trajectory") == 2546  # a millisecond on its way to 2048
    assert bench.read("velocity_trajectory") == -100


def test_a_profile_ends_when_torque_goes() -> None:
    bench = Bench()
    bench.write(torque_enable=1, profile_velocity=10, goal_position=3048)
    bench.step()
    assert bench.read("moving") == 1
    bench.write(torque_enable=0)
    bench.step()
    assert (bench.read("moving"), bench.read("velocity_trajectory")) == (0, 0)


def test_profile_registers_count_from_the_next_goal_on() -> None:
    bench = Bench()
    bench.write(torque_enable=1, profile_velocity=100, goal_position=3048)
    bench.trajectory(100)
    bench.write(profile_velocity=10)
    assert bench.trajectory(1)[1] == [100]
    bench.write(goal_position=3047)
    assert bench.trajectory(1)[1] == [10]


def test_a_real_shaft_follows_a_profile() -> None:
    rig = Rig()
    rig.write(torque_enable=1, profile_velocity=100, profile_acceleration=20, goal_position=3072)
    rig.run(0.5)
    assert rig.speed * RPM == pytest.approx(22.9, rel=0.03)
    rig.run(0.8)
    assert abs(rig.read("present_position") - 3072) <= 5


def test_energy_and_current_of_a_stalled_motor() -> None:
    bench = Bench(operating_mode=16)
    bench.step()
    bench.write(torque_enable=1, goal_pwm=-885)
    for _ in range(1001):
        bench.step()
    assert bench.physics.current[0] == pytest.approx(-0.8247, abs=1e-4)  # 11.1 V / 13.46 ohm
    assert bench.physics.energy[0] == pytest.approx(9.154, abs=0.001)  # 11.1 V x 0.8247 A x 1 s


def test_a_driven_motor_gives_no_energy_back() -> None:
    bench = Bench(operating_mode=16)
    bench.write(torque_enable=1, goal_pwm=100)
    for _ in range(10):
        bench.step(speed=5.0)
    assert bench.physics.energy[0] == 0.0


def test_servos_of_one_robot_do_not_mix() -> None:
    strong = servo_model(motor={"torque_constant_nm_per_a": 3.4924})
    physics = ServoPhysics([MODEL, strong, MODEL])
    servos = [DynamixelServo(physics, index, id=index + 1, operating_mode=16) for index in range(3)]
    for servo, pwm in zip(servos, (885, 885, -442), strict=True):
        servo.write(64, b"\1")
        servo.write(100, pwm.to_bytes(2, "little", signed=True))
    torque = physics.step(np.array([0.0, 0.1, 0.2]), np.zeros(3), MS)
    assert torque.tolist() == pytest.approx([1.4400, 2.8801, -0.7192], abs=1e-4)
    assert [int.from_bytes(servo.read(132, 4, MS), "little") for servo in servos] == [2048, 2113, 2178]


def test_one_servo_with_a_profile_leaves_the_others_as_they_are() -> None:
    def torque(profile_velocity: int) -> float:
        physics = ServoPhysics([MODEL] * 2)
        servos = [DynamixelServo(physics, index, id=index + 1) for index in range(2)]
        for servo in servos:
            servo.write(64, b"\1")
        servos[0].write(112, profile_velocity.to_bytes(4, "little"))
        for servo in servos:
            servo.write(116, (2100).to_bytes(4, "little"))
        return float(physics.step(np.array([0.0, 0.01]), np.array([0.0, 0.3]), MS)[1])

    assert torque(50) == pytest.approx(torque(0), abs=1e-12)


def stalled(count: int, **supply: float) -> ServoPhysics:
    """Servos driven with all they have against a stop."""
    physics = ServoPhysics([MODEL] * count, **supply)
    for index in range(count):
        physics.load(index, Drive(on=True, largest_duty=1.0, duty=1.0), NOTHING)
    return physics


NOTHING = Scales(1, 0.0, 0.0, 0.0, 0.0, 0.0, 10.0, 0.0)


def run(physics: ServoPhysics, seconds: float, speed: float = 0.0) -> None:
    count = len(physics.models)
    for _ in range(round(seconds * 200)):
        physics.step(np.zeros(count), np.full(count, speed), physics._now + 5_000_000)


def test_a_battery_sags_under_load_and_the_servos_read_it() -> None:
    physics = stalled(10, supply_v=12.0, internal_resistance=0.1)
    run(physics, 0.5)
    # Ten times V / R at a supply that itself falls: V = 12 / (1 + 10 x 0.1 / 13.46).
    assert physics.terminal_v == pytest.approx(12.0 / (1 + 1 / 13.46), rel=1e-3)
    assert [row[-2] for row in physics.present()] == [round(10 * physics.terminal_v[0])] * 10
    assert physics.torque == pytest.approx(1.7462 / 13.46 * physics.terminal_v, rel=1e-3)


def test_without_internal_resistance_nothing_sags() -> None:
    physics = stalled(10, supply_v=12.0)
    run(physics, 0.1)
    assert physics.terminal_v == pytest.approx(12.0)


def test_a_stalled_winding_warms_by_its_loss_with_its_time_constant() -> None:
    physics = stalled(1)
    start, loss = float(physics.temperature_c[0]), 11.1**2 / 13.46
    run(physics, 30.0)
    assert physics.temperature_c[0] - start == pytest.approx(10.0 * loss * (1 - np.exp(-30 / 300)), rel=0.02)
    physics.load(0, Drive(on=False), NOTHING)
    hot = float(physics.temperature_c[0])
    run(physics, 30.0)
    assert physics.temperature_c[0] - start == pytest.approx((hot - start) * np.exp(-30 / 300), rel=0.02)


@pytest.mark.parametrize(("speed", "strained"), [(0.0, True), (5.9, False)])
def test_full_duty_strains_a_motor_only_under_load(speed: float, strained: bool) -> None:
    """5.97 rad/s is its speed without load, at which hardly any current flows."""
    physics, told = stalled(1), []
    physics.attach(0, lambda now, duty, current, volts, degrees: told.append(duty))
    run(physics, 0.5, speed)
    assert (max(told) > 0.8) is strained
