"""The cyclic exchange with fake servos on a simulated wire: what garbled and missing replies cost."""

import math

import numpy as np
import pytest
from fastcrc import crc16

from robotwalk.errors import BusError
from robotwalk.types import ServoCondition, ServoLimits
from sim_backend.device import Reply

from .bus_rig import COUNT, FAST, PERIOD, PLAIN, TICK, Rig, Tamper, armed, next_tick, rig


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


def test_torque_that_cannot_be_confirmed_off_is_said() -> None:
    built = armed()
    built.device.lose = lambda data: b""
    assert built.bus.disarm() == ["j0", "j1", "j2", "j3", "j4"]
    built.device.lose = lambda data: data
    assert built.bus.disarm() == []
    assert [servo.table["torque_enable"] for servo in built.servos] == [0] * COUNT


def test_torque_goes_off_even_where_every_broadcast_is_lost() -> None:
    built = armed()
    built.device.lose = lambda data: b"" if data[4] == 0xFE else data
    assert built.bus.disarm() == []
    assert [servo.table["torque_enable"] for servo in built.servos] == [0] * COUNT


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


def test_a_tick_is_one_sync_write_and_one_fast_sync_read() -> None:
    built = armed()
    built.bus.exchange([0.1] * COUNT, PERIOD)
    assert len(built.device.heard) == 1
    sent = built.device.heard[0]
    write, read = sent[: 14 + 5 * COUNT], sent[14 + 5 * COUNT :]
    assert write[:7] == b"\xff\xff\xfd\x00\xfe" + (7 + 5 * COUNT).to_bytes(2, "little")
    assert write[7:12] == b"\x83\x74\x00\x04\x00"
    # round(0.1 rad / 0.00153398 rad) = 65 ticks; j1 the other way round; j2 counts from half a radian.
    goals = [int.from_bytes(write[13 + 5 * i : 17 + 5 * i], "little") for i in range(COUNT)]
    assert goals == [2113, 1983, 1787, 2113, 2113]
    assert read[7:12] == b"\x8a\x7e\x00\x0a\x00"
    assert read[12:-2] == bytes([1, 2, 3, 4, 5])


@pytest.mark.parametrize("firmware", [FAST, PLAIN])
def test_position_velocity_and_effort_come_back_in_si_units(firmware: int) -> None:
    built = armed(firmware)
    built.hold([10 * TICK, 10 * TICK, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0, 0.0])
    built.bus.exchange([10 * TICK, -10 * TICK, 0.5, 0.0, 0.0], PERIOD)
    built.hold([10 * TICK, 10 * TICK, 0.0, 0.0, -20 * TICK], [1.0, 1.0, 0.0, 0.0, 0.0])
    state = built.bus.exchange([0.0] * COUNT, PERIOD)
    assert state.position == pytest.approx((10 * TICK, -10 * TICK, 0.5, 0.0, -20 * TICK))
    # 1 rad/s is 41.7 counts of 0.229 rpm.
    assert state.velocity == pytest.approx((1.0, -1.0, 0.0, 0.0, 0.0), abs=0.012)
    # 20 ticks x 640 / 128 / 885 of full duty.
    assert state.effort[4] == pytest.approx(0.113, abs=0.001)
    assert state.age == (0.0,) * COUNT


def test_a_negative_load_before_a_speed_of_minus_three_counts_survives_byte_stuffing() -> None:
    built = armed(PLAIN)
    # Load -1 is FF FF, speed -3 is FD FF FF FF: a header in the middle of the data, unless stuffed.
    built.bus.exchange([0.0] * COUNT, PERIOD)
    built.hold([0.0, 0.0, 0.0, 0.0, 0.0], [-3 * 0.229 * 2 * math.pi / 60] * COUNT)
    built.physics.duty[:] = -0.001
    built.physics._present = None
    state = built.bus.exchange([0.0] * COUNT, PERIOD)
    assert state.valid == (True,) * COUNT
    assert state.effort[0] == pytest.approx(-0.001)
    assert state.velocity[0] == pytest.approx(-0.0719, abs=1e-3)


def test_nan_never_reaches_a_servo() -> None:
    built = armed()
    with pytest.raises(ValueError, match="nan"):
        built.bus.exchange([0.0, 0.0, math.nan, 0.0, 0.0], PERIOD)
    assert built.device.heard == []


def corrupt(byte: int) -> Tamper:
    def tamper(replies: list[Reply]) -> list[Reply]:
        first, *rest = replies
        data = bytearray(first.data)
        data[byte] ^= 0x40
        return [Reply(first.delay_ns, bytes(data)), *rest]

    return tamper


def cut(size: int) -> Tamper:
    return lambda replies: [Reply(replies[0].delay_ns, replies[0].data[:size])]


LATE = 8_000_000  # ns


@pytest.mark.parametrize(("firmware", "tamper", "heard"), [
    pytest.param(FAST, lambda replies: [], [], id="fast: nothing"),
    pytest.param(FAST, cut(8 + 2 * 14), [0, 1], id="fast: third servo silent"),
    pytest.param(FAST, cut(8 + 2 * 14 + 9), [0, 1], id="fast: cut in the third block"),
    pytest.param(FAST, corrupt(8 + 2 * 14 + 4), [0, 1], id="fast: a byte of the third block garbled"),
    pytest.param(FAST, corrupt(3), [], id="fast: the head garbled"),
    pytest.param(FAST, lambda r: [Reply(LATE, r[0].data)], [], id="fast: late"),
    pytest.param(PLAIN, lambda replies: [], [], id="plain: nothing"),
    pytest.param(PLAIN, lambda r: r[:2] + r[3:], [0, 1, 3, 4], id="plain: third servo silent, the others answer"),
    pytest.param(PLAIN, lambda r: r[:2], [0, 1], id="plain: silent from the third on"),
    pytest.param(PLAIN, corrupt(12), [1, 2, 3, 4], id="plain: a byte of the first status garbled"),
    pytest.param(PLAIN, lambda r: [r[0], Reply(0, r[1].data[:9]), *r[2:]], [0, 2, 3, 4], id="plain: a short status"),
    pytest.param(PLAIN, lambda r: [*r[:4], Reply(LATE, r[4].data)], [0, 1, 2, 3], id="plain: the last one late"),
    pytest.param(PLAIN, lambda r: [Reply(0, b"\xff\xff\xfd\x00\x12"), *r], [0, 1, 2, 3, 4], id="plain: noise before"),
])
def test_a_bad_reply_costs_its_own_joints_one_sample(firmware: int, tamper: Tamper, heard: list[int]) -> None:
    built = armed(firmware)
    good = built.bus.exchange([0.0] * COUNT, PERIOD)
    lost_before = built.bus.statistics()["legs"].lost_replies
    built.clock.wait((), built.clock.now() + PERIOD)
    built.hold([50 * TICK] * COUNT)
    built.device.tamper = tamper
    state = built.bus.exchange([0.0] * COUNT, PERIOD)
    assert [i for i in range(COUNT) if state.valid[i]] == heard
    for i in range(COUNT):
        if i in heard:
            assert state.age[i] == 0.0
            assert state.position[i] != good.position[i]
        else:
            assert state.position[i] == good.position[i], "a failed read is never data"
            assert 0.010 <= state.age[i] <= 0.020
    statistics = built.bus.statistics()["legs"]
    assert statistics.lost_replies - lost_before == COUNT - len(heard)
    # What was late or left over does not spoil the next tick.
    built.device.tamper = lambda replies: replies
    built.clock.wait((), built.clock.now() + PERIOD)
    built.hold([80 * TICK] * COUNT)
    after = built.bus.exchange([0.0] * COUNT, PERIOD)
    assert after.valid == (True,) * COUNT
    assert after.position[3] == pytest.approx(80 * TICK)
    assert built.bus.statistics()["legs"].max_age == max(state.age)


def test_a_servo_that_refuses_the_read_has_no_sample() -> None:
    """It answers with an error number and zeros; a zero is a position like any other."""

    def refuse(replies: list[Reply]) -> list[Reply]:
        data = bytearray(replies[0].data)
        for block in range(COUNT):
            start = 8 + 14 * block
            if block == 2:
                data[start] = 7
                data[start + 2 : start + 12] = bytes(10)
            data[start + 12 : start + 14] = crc16.umts(bytes(data[: start + 12])).to_bytes(2, "little")
        return [Reply(replies[0].delay_ns, bytes(data))]

    built = armed()
    built.device.tamper = refuse
    state = built.bus.exchange([0.0] * COUNT, PERIOD)
    assert state.valid == (True, True, False, True, True)
    assert state.position[2] == pytest.approx(0.5), "where it was before"


@pytest.mark.parametrize("firmware", [FAST, PLAIN])
def test_a_silent_bus_takes_no_longer_than_the_wire_time_and_two_milliseconds(firmware: int) -> None:
    built = armed(firmware)
    built.device.tamper = lambda replies: []
    before = built.clock.now()
    built.bus.exchange([0.0] * COUNT, PERIOD)
    wire = (14 + 5 * COUNT) + (14 + COUNT) + (8 + 14 * COUNT if firmware == FAST else 21 * COUNT)
    assert built.clock.now() - before == wire * 10_000 + 1_700_000


def test_an_exchange_never_outlasts_its_tick() -> None:
    built = armed(PLAIN)
    built.device.tamper = lambda replies: []
    before = built.clock.now()
    built.bus.exchange([0.0] * COUNT, 2_000_000)
    assert built.clock.now() - before == 1_800_000


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


def test_an_overheated_servo_raises_its_alert_in_the_cycle_and_its_data_still_counts() -> None:
    built = armed()
    built.physics.temperature_c[2] = 90.0
    built.physics.step(np.zeros(COUNT), np.zeros(COUNT), built.clock.now() + 20_000_000)
    state = built.bus.exchange([0.0] * COUNT, PERIOD)
    assert built.bus.alerts == {"j2": "reports overload, heat or a wrong voltage"}
    assert state.valid == (True,) * COUNT
    next_tick(built)
    assert built.bus.alerts == {"j2": "reports overheating"}, "it was asked what is wrong at once"


def test_every_servos_condition_is_read_in_turn_with_its_time() -> None:
    built = armed()
    limits = ServoLimits(hottest=72.0, lowest_voltage=6.0, highest_voltage=14.0)  # as the servo itself has them
    assert set(built.bus.conditions().values()) == {ServoCondition(None, None, None, None, (), limits)}
    built.physics.supply_v[:] = 11.4
    built.physics.temperature_c[3] = 41.0
    built.physics.step(np.zeros(COUNT), np.zeros(COUNT), built.clock.now() + 1_000_000)
    for _ in range(COUNT + 1):
        next_tick(built)
    conditions = built.bus.conditions()
    assert list(conditions) == [f"j{i}" for i in range(COUNT)]
    for joint, told in conditions.items():
        assert told.voltage is not None
        assert told.temperature is not None
        assert told.voltage.value == pytest.approx(11.4)
        assert told.temperature.value == (41.0 if joint == "j3" else 30.0)
        assert 0 <= built.clock.now() - told.voltage.heard <= (COUNT + 1) * 12_000_000
        assert told.holds
        assert told.current is None, "which this servo does not measure"
    next_tick(built)
    after = built.bus.conditions()
    anew = [joint for joint, told in conditions.items() if after[joint] is not told]
    assert len(anew) == 1, "a condition stays the same object until its servo is read again"


def test_a_condition_is_one_short_read_of_gathered_registers() -> None:
    built = armed()
    built.bus.exchange([0.0] * COUNT, PERIOD)
    next_tick(built)
    reads = [data[4:-2] for data in built.device.heard if data[7] == 0x02]
    assert reads == [bytes((1, 7, 0, 2, 224, 0, 6, 0))], "torque, error, voltage, temperature, watchdog from data 1"


def test_whoever_has_another_map_is_read_where_the_registers_lie() -> None:
    built = rig()
    built.servos[0].write(168, (65).to_bytes(2, "little"))  # not ours, and not a start's
    built.bus.arm(PERIOD)
    built.device.heard.clear()
    for _ in range(COUNT + 3):
        next_tick(built)
    reads = {(data[4], data[8]) for data in built.device.heard if data[7] == 0x02}
    assert reads == {(1, 64), (1, 98), (1, 144), *((i, 224) for i in range(2, COUNT + 1))}
    assert all(told.holds for told in built.bus.conditions().values())


def test_a_servo_that_restarted_unnoticed_is_found_by_its_torque() -> None:
    built = armed()
    for _ in range(COUNT + 1):
        next_tick(built)
    assert built.bus.alerts == {}
    built.servos[3].write(64, b"\0")
    for _ in range(COUNT + 1):
        next_tick(built)
    assert built.bus.alerts == {"j3": "has let go: its torque is off, and nobody switched it off"}


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


def test_disarming_reaches_everyone_and_never_raises() -> None:
    built = armed()
    built.bus.disarm()
    assert [servo.table["torque_enable"] for servo in built.servos] == [0] * COUNT

    def broken(data: bytes) -> None:
        raise OSError("the cable is out")

    built.line.port.write = broken  # type: ignore[method-assign]
    assert built.bus.disarm() == ["j0", "j1", "j2", "j3", "j4"]
    built.bus.close()
