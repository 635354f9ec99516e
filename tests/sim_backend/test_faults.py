"""What each fault of a script does: to the bytes that a host reads, to servos, to the body."""

import math
from collections.abc import Mapping
from typing import Any

import pytest

from robotwalk import assembly
from robotwalk.assembly import simulated_robot

MS = 1_000_000
S = 1_000_000_000

HEXAPOD, QUADRUPED = assembly.load("hexapod"), assembly.load("quadruped")
BRANDS = pytest.mark.parametrize("robot", [HEXAPOD, QUADRUPED], ids=["dynamixel", "feetech"])

PING = bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E")
PONG = bytes.fromhex("FF FF FD 00 01 07 00 55 00 24 04 2D F4 DF")  # XL430-W250, firmware 45
PING_OF_2 = bytes.fromhex("FF FF FD 00 02 03 00 01 19 72")
PONG_OF_2 = bytes.fromhex("FF FF FD 00 02 07 00 55 00 24 04 2D FE EF")


class Bench:
    """A simulated robot on which somebody types bytes."""

    def __init__(self, *faults: Mapping[str, Any], robot: assembly.Blueprint = HEXAPOD, seed: int = 0) -> None:
        self.robot = simulated_robot(robot, 100, seed, faults=faults)
        self.port = next(iter(self.robot.ports.values()))
        self.clock = self.robot.clock

    def run(self, seconds: float) -> None:
        self.clock.wait((), self.clock.now() + round(seconds * S))

    def hear(self, ms: float = 5.0) -> bytes:
        self.run(ms * 1e-3)
        return self.port.read()

    def ask(self, instruction: bytes, ms: float = 5.0) -> bytes:
        self.port.read()
        self.port.write(instruction)
        return self.hear(ms)

    def registers(self, name: str) -> list[int]:
        return [servo.table[name] for servo in self.robot.servos]

    def drive(self, joint: int, goal: int) -> None:
        """Switch a Dynamixel's torque on, and send it to a place."""
        servo: Any = self.robot.servos[joint]
        servo.write(64, b"\1")
        servo.write(116, goal.to_bytes(4, "little"))


def fault(name: str, at: float = 0.0, **keys: Any) -> dict[str, Any]:
    return {"at": at, "fault": name, **keys}


def lasting(name: str, at: float, seconds: float, **keys: Any) -> dict[str, Any]:
    return fault(name, at, **keys) | {"for": seconds}


def test_without_faults_it_answers() -> None:
    bench = Bench()
    assert bench.ask(PING) == PONG
    assert bench.ask(PING_OF_2) == PONG_OF_2


def test_a_share_of_replies_is_dropped_from_the_first_byte_on_and_equal_seeds_drop_the_same() -> None:
    def answered(seed: int) -> list[bool]:
        bench = Bench(fault("drop_reply", rate=0.25), seed=seed)
        return [bench.ask(PING, 1.0) == PONG for _ in range(200)]

    first = answered(7)
    assert 120 < sum(first) < 180
    assert answered(7) == first
    assert answered(8) != first


def test_only_the_joint_named_is_befallen_and_only_for_its_time() -> None:
    bench = Bench(lasting("drop_reply", 0.010, 0.030, joint="lf_coxa"))
    assert bench.ask(PING, 10.0) == PONG
    assert bench.ask(PING, 10.0) == b""
    assert bench.ask(PING_OF_2, 21.0) == PONG_OF_2
    assert bench.ask(PING) == PONG


def test_one_byte_of_a_frame_is_another() -> None:
    bench = Bench(fault("corrupt_frame", bus="legs"))
    heard = [bench.ask(PING) for _ in range(50)]
    assert {len(frame) for frame in heard} == {len(PONG)}
    wrong = [[at for at in range(len(PONG)) if frame[at] != PONG[at]] for frame in heard]
    assert {len(places) for places in wrong} == {1}
    assert len({places[0] for places in wrong}) > 8, "any byte may be hit"


def test_a_reply_is_late() -> None:
    bench = Bench(fault("delay_reply", delay_ms=3.0))
    assert bench.ask(PING, 3.1) == b"", "10 bytes there, 3 ms"
    assert bench.hear(0.14) == PONG


def test_two_servos_with_one_id_obey_both_and_are_garbage_to_hear() -> None:
    bench = Bench(lasting("duplicate_id", 0.0, 0.1, joint="lf_femur", id_of="lf_coxa"))
    garbage = bench.ask(PING)
    assert garbage
    assert PONG not in garbage
    assert bench.ask(PING_OF_2) == b""
    bench.ask(bytes.fromhex("FF FF FD 00 01 06 00 03 41 00 01 CC E6"))  # LED
    assert bench.registers("led")[:3] == [1, 1, 0]
    bench.run(0.1)
    assert bench.ask(PING) == PONG
    assert bench.ask(PING_OF_2) == PONG_OF_2


def test_noise_comes_unasked_and_costs_no_instruction() -> None:
    bench = Bench(lasting("noise", 0.05, 0.1, largest=4, every_ms=2.0))
    assert bench.hear(49.0) == b""
    heard = bench.hear(20.0)
    assert 9 <= len(heard) <= 4 * 11
    for _ in range(20):
        assert PONG in bench.ask(PING, 3.0)
    bench.run(0.1)
    assert bench.ask(PING) == PONG, "it is over"


def test_noise_goes_by_the_seed() -> None:
    def heard(seed: int) -> bytes:
        return Bench(fault("noise"), seed=seed).hear(50.0)

    assert heard(1) == heard(1) != heard(2)


def test_an_unplugged_bus_is_silent_and_deaf_and_its_servos_keep_what_they_have() -> None:
    led_on = bytes.fromhex("FF FF FD 00 01 06 00 03 41 00 01 CC E6")
    bench = Bench(lasting("unplug", 0.02, 0.05, bus="legs"), lasting("unplug", 0.03, 0.01, bus="legs"))
    bench.drive(0, 2048)
    bench.run(0.02)
    assert bench.ask(PING) == b""
    bench.run(0.02)
    assert bench.ask(led_on) == b"", "the other cut is still there"
    assert bench.registers("led")[0] == 0
    assert bench.registers("torque_enable")[0] == 1
    bench.run(0.03)
    assert bench.ask(PING) == PONG


@BRANDS
def test_a_brown_out_resets_servos_and_they_are_away_for_a_while(robot: assembly.Blueprint) -> None:
    bench = Bench(fault("brown_out", at=0.02), robot=robot)
    for servo in bench.robot.servos:
        servo.table["torque_enable"] = 1
    bench.run(0.021)
    assert not any(bench.registers("torque_enable"))
    back = 0.02 + 0.05 + robot.servos[bench.robot.servos[0].model.name].firmware.reboot_s
    assert not any(servo.listens(round((back - 0.001) * S), 1_000_000) for servo in bench.robot.servos)
    assert all(servo.listens(round((back + 0.001) * S), 1_000_000) for servo in bench.robot.servos)


@BRANDS
def test_a_dead_servo_is_silent_and_limp_and_may_come_back(robot: assembly.Blueprint) -> None:
    joint = robot.model.joint_names[0]
    bench = Bench(lasting("dead_servo", 0.0, 10.0, joint=joint), robot=robot)
    dead, alive = bench.robot.servos[:2]
    assert not dead.listens(9 * S, 1_000_000)
    assert alive.listens(9 * S, 1_000_000)
    bench.run(10.001)
    assert dead.table["torque_enable"] == 0
    assert not dead.listens(bench.clock.now(), 1_000_000), "it has to start first"
    assert dead.listens(bench.clock.now() + S, 1_000_000)


@BRANDS
def test_an_overload_trips_the_servos_own_protection(robot: assembly.Blueprint) -> None:
    bench = Bench(fault("overload", joint=robot.model.joint_names[1]), robot=robot)
    bench.run(0.5)
    assert not any(bench.registers("hardware_error_status")), "not at once"
    bench.run(4.0)
    assert bench.registers("hardware_error_status")[:3] == [0, 32, 0]


@BRANDS
def test_an_overheated_servo_measures_it_and_says_so(robot: assembly.Blueprint) -> None:
    bench = Bench(lasting("overheat", 0.01, 0.1, joint=robot.model.joint_names[2], temperature_c=99), robot=robot)
    bench.run(0.05)
    assert bench.robot.servos[2].table["hardware_error_status"] == 4
    assert [read(bench, joint, "present_temperature") > 90 for joint in (1, 2)] == [False, True]
    bench.run(0.1)
    assert read(bench, 2, "present_temperature") < 40


@BRANDS
def test_a_drop_in_voltage_is_measured_and_weakens_the_motors(robot: assembly.Blueprint) -> None:
    bench = Bench(lasting("voltage_drop", 0.01, 0.1, supply_v=5.0), robot=robot)
    before = read(bench, 0, "present_input_voltage")
    bench.run(0.05)
    assert {read(bench, joint, "present_input_voltage") for joint in range(12)} == {50}
    bench.run(0.1)
    assert read(bench, 0, "present_input_voltage") == before > 50


def read(bench: Bench, joint: int, register: str) -> int:
    """Return what a servo itself reads in a register."""
    servo = bench.robot.servos[joint]
    servo._sense()
    return servo.table[register]


def test_older_firmware_tells_its_version_and_has_no_fast_sync_read() -> None:
    bench = Bench(fault("wrong_firmware", joint="lf_femur", version=44))
    assert bench.ask(PING) == PONG
    assert bench.ask(PING_OF_2) == bytes.fromhex("FF FF FD 00 02 07 00 55 00 24 04 2C FB 6F")
    reply = bench.ask(bytes.fromhex("FF FF FD 00 FE 0A 00 8A 84 00 04 00 01 02 03 1A EC"))
    assert len(reply) == 8 + 8, "the first servo's block only"


def test_the_first_part_of_a_feetech_version_changes() -> None:
    bench = Bench(fault("wrong_firmware", joint="lf_hip", version=2), robot=QUADRUPED)
    assert (bench.registers("firmware_major")[0], bench.registers("firmware_major")[1]) == (2, 3)


def test_a_stuck_joint_stays_where_it_is_whatever_its_motor_does() -> None:
    def turned(*faults: Mapping[str, Any]) -> float:
        bench = Bench(*faults)
        before = bench.robot.truth().joints[0]
        bench.drive(0, 2448)  # 35 deg from the middle
        bench.run(1.0)
        return abs(bench.robot.truth().joints[0] - before)

    assert turned() > math.radians(15)
    assert turned(fault("stuck_joint", joint="lf_coxa")) < math.radians(0.5)
    assert turned(lasting("stuck_joint", 0.0, 0.3, joint="lf_coxa")) > math.radians(15)


@pytest.mark.parametrize(("direction", "axis", "sign"), [(0, "x", 1), (180, "x", -1), (90, "y", 1)])
def test_a_push_moves_the_body_that_way(direction: float, axis: str, sign: int) -> None:
    bench = Bench(lasting("push", 0.1, 0.2, force_n=60.0, direction_deg=direction))
    bench.run(0.099)
    before = bench.robot.truth().base
    bench.run(0.2)
    pushed = bench.robot.truth().base
    assert sign * (getattr(pushed, axis) - getattr(before, axis)) > 0.02
    bench.run(2.0)
    assert not bench.robot.world.data.xfrc_applied.any()
