"""The cyclic exchange with fake servos on a simulated wire: what garbled and missing replies cost."""

import math

import pytest
from fastcrc import crc16

from sim_backend.device import Reply

from .bus_rig import COUNT, FAST, PERIOD, PLAIN, TICK, Tamper, armed


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
