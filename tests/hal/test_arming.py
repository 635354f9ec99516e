"""How a bus of Dynamixel fakes comes to power: what is found, mended, told and refused."""

import numpy as np
import pytest

from robotwalk.errors import BusError
from sim_backend.device import Reply

from .bus_rig import COUNT, FAST, PERIOD, PLAIN, TICK, Rig, armed, rig


@pytest.mark.parametrize("firmware", [FAST, PLAIN])
def test_arming_holds_where_the_shafts_are_and_switches_torque_on(firmware: int) -> None:
    built = rig(firmware)
    built.hold([100 * TICK, -200 * TICK, 0.0, 0.0, 0.0])
    state = built.bus.arm(PERIOD)
    assert state.valid == (True,) * COUNT
    # j1 turns the other way round, j2 reads its centre at half a radian.
    assert state.position == pytest.approx((100 * TICK, 200 * TICK, 0.5, 0.0, 0.0))
    assert [servo.table["goal_position"] for servo in built.servos] == [2148, 1848, 2048, 2048, 2048]
    assert [servo.table["torque_enable"] for servo in built.servos] == [1] * COUNT


INDIRECT, WATCHDOG = b"\xa8\x00", b"\x62\x00"


def writes(built: Rig) -> list[bytes]:
    """The writes and sync writes that were sent, from the instruction on, without CRC; of goals, caps and torque."""
    frames = [data[7:] for data in built.device.heard]
    return [frame[:-2] for frame in frames if frame[0] in (0x03, 0x83) and frame[1:3] not in (INDIRECT, WATCHDOG)]


def test_torque_comes_gently_limb_by_limb_after_the_goals() -> None:
    built = rig()
    built.hold([100 * TICK] * COUNT)
    built.bus.arm(PERIOD)
    # A fifth of the largest PWM of 885 counts to everybody, then the goals, then torque, then more and more.
    cap, goals, *torque = writes(built)[: 2 + COUNT]
    assert cap == b"\x83\x64\x00\x02\x00" + b"".join(bytes((i, 177, 0)) for i in (1, 2, 3, 4, 5))
    assert goals[:9] == b"\x83\x74\x00\x04\x00\x01\x64\x08\x00"
    assert torque == [b"\x03\x40\x00\x01"] * COUNT
    caps = [int.from_bytes(frame[6:8], "little") for frame in writes(built)[2 + COUNT :]]
    assert caps == [354, 531, 708, 885]
    assert [servo.table["goal_pwm"] for servo in built.servos] == [885] * COUNT


def test_no_torque_where_the_goals_were_lost_on_the_wire() -> None:
    built = rig()
    built.hold([100 * TICK] * COUNT)
    goals = 14 + 5 * COUNT  # bytes of the sync write, which nobody acknowledges
    built.device.lose = lambda data: data[goals:] if data[7:10] == b"\x83\x74\x00" else data
    with pytest.raises(BusError, match=r"j0 \(id 1\) on bus legs did not take its position as goal: it holds 2048"):
        built.bus.arm(PERIOD)
    assert [servo.table["torque_enable"] for servo in built.servos] == [0] * COUNT


def test_a_share_of_torque_stays_a_share() -> None:
    built = rig()
    built.bus.arm(PERIOD, torque=0.35)
    assert [servo.table["goal_pwm"] for servo in built.servos] == [310] * COUNT


def test_a_robot_that_stands_on_its_torque_keeps_it() -> None:
    built = armed()
    built.hold([30 * TICK] * COUNT)
    built.bus.arm(PERIOD)
    assert all(frame[:3] != b"\x03\x40\x00" for frame in writes(built)), "torque was never touched"
    caps = [frame[6:8] for frame in writes(built) if frame[:3] == b"\x83\x64\x00"]
    assert caps == [(885).to_bytes(2, "little")], "nor made weak"
    assert [servo.table["goal_position"] for servo in built.servos] == [2078] * COUNT


def test_a_robot_that_stands_is_not_dropped_by_a_failed_arming() -> None:
    built = armed()
    for frames in (3, 30, 44):  # lost from there on: while it is identified, and while it is taken over
        built.device.heard.clear()
        built.device.tamper = lambda replies, frames=frames: replies if len(built.device.heard) < frames else []
        with pytest.raises(BusError):
            built.bus.arm(PERIOD)
    assert [servo.table["torque_enable"] for servo in built.servos] == [1] * COUNT


def test_a_servo_in_another_mode_is_refused_with_the_cure() -> None:
    """In PWM mode the bound of the output would itself be the goal, and the joint would run."""
    built = rig()
    built.servos[1].write(11, b"\x10")
    cure = r"j1 \(id 2\) on bus legs has operating_mode = 16; .* servo write 2 operating_mode=3 --raw"
    with pytest.raises(BusError, match=cure):
        built.bus.arm(PERIOD)
    assert [servo.table["torque_enable"] for servo in built.servos] == [0] * COUNT


def test_a_profile_that_somebody_left_in_ram_is_taken_out() -> None:
    built = rig()
    built.servos[1].write(112, (30).to_bytes(4, "little"))
    built.bus.arm(PERIOD)
    assert built.servos[1].table["profile_velocity"] == 0


def test_gains_that_somebody_left_in_ram_are_the_factorys_again() -> None:
    built = rig()
    built.servos[1].write(84, (100).to_bytes(2, "little"))
    built.bus.arm(PERIOD)
    assert built.servos[1].table["position_p_gain"] == 640


def test_a_joint_outside_its_limits_is_not_armed() -> None:
    built = rig()
    built.hold([0.0, 0.0, 0.0, 1.2, 0.0])
    with pytest.raises(BusError, match=r"j3 \(id 4\) on bus legs stands at 69 deg, outside the joint's -57 to 57 deg"):
        built.bus.arm(PERIOD)
    assert [servo.table["torque_enable"] for servo in built.servos] == [0] * COUNT


def test_an_adapter_that_holds_replies_back_is_told_with_the_rate_that_it_allows() -> None:
    built = rig()
    built.device.tamper = lambda replies: [Reply(reply.delay_ns + 16_000_000, reply.data) for reply in replies]
    with pytest.raises(BusError, match=r"cannot be read at 100 Hz: .* 16 ms .*latency_timer.*--rate 51 is the most"):
        built.bus.arm(PERIOD)
    assert built.bus.arm(1_000_000_000 // 50).valid == (True,) * COUNT


def test_a_missing_servo_is_named_and_nothing_is_armed() -> None:
    built = rig()
    built.servos[3].table["id"] = 77
    built.servos[3].write(65, b"\x00")  # any write makes the firmware look at its settings
    with pytest.raises(BusError, match=r"no answer on bus legs from j3 \(id 4\)\.$"):
        built.bus.arm(PERIOD)
    assert [servo.table["torque_enable"] for servo in built.servos] == [0] * COUNT


def test_a_servo_with_a_hardware_error_is_not_armed() -> None:
    built = rig()
    built.physics.temperature_c[2] = 90.0
    built.physics.step(np.zeros(COUNT), np.zeros(COUNT), 20_000_000)
    with pytest.raises(BusError, match=r"j2 \(id 3\) on bus legs reports a hardware error"):
        built.bus.arm(PERIOD)
    assert [servo.table["torque_enable"] for servo in built.servos] == [0] * COUNT


def test_a_return_delay_is_taken_out_and_told() -> None:
    built = rig()
    built.servos[1].write(9, b"\xfa")
    built.bus.arm(PERIOD)
    assert built.servos[1].table["return_delay_time"] == 0
    assert built.bus.notes == ("return_delay_time set to 0; it was 500 us: j1 (id 2)",)


def test_a_servo_that_only_was_overloaded_is_restarted_and_that_is_told() -> None:
    built = armed()
    built.bus.pause()
    built.physics.strained.add(1)
    for _ in range(30):
        built.clock.wait((), built.clock.now() + 100_000_000)
        built.hold([0.0] * COUNT)
    assert built.servos[1].table["hardware_error_status"] == 0x20
    assert built.servos[1].table["torque_enable"] == 0
    built.physics.strained.clear()
    built.bus.arm(PERIOD)
    assert built.servos[1].table["torque_enable"] == 1
    assert built.bus.notes == ("had shut down for overload, and was restarted: j1 (id 2)",)
    assert built.bus.alerts == {}


def test_limits_that_keep_a_joint_from_its_range_are_told_with_the_cure() -> None:
    built = rig()
    built.servos[1].write(52, (1500).to_bytes(4, "little"))
    with pytest.raises(BusError, match=(
        r"j1 \(id 2\) on bus legs is limited to counts 1500 to 4095, its joint needs 1396 to 2700: "
        r"robotwalk servo write 2 min_position_limit=1396 max_position_limit=2700 --raw")):
        built.bus.arm(PERIOD)


def test_what_is_unusual_but_harmless_is_told() -> None:
    built = rig()
    built.servos[2].write(63, b"\x04")
    built.bus.arm(PERIOD)
    assert built.bus.notes == ("shutdown is 4; the factory's is 52: j2 (id 3)",)
