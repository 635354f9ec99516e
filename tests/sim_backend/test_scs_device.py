"""SCS servos seen from the wire, alone and beside STS servos: literal bytes, and Feetech's own SDK."""

from collections.abc import Iterator

import pytest
import scservo_sdk
from hypothesis import given
from hypothesis import strategies as st

from sim_backend.device import Reply

from .feetech_bus import MS, Bus, Port, frame

MODELS = pytest.mark.parametrize("model", ["scs15", "scs0009"])
BOTH_KINDS = ("scs15", "sts3215", "scs0009")

PING = bytes.fromhex("FF FF 01 02 01 FB")
OK = bytes.fromhex("FF FF 01 02 00 FC")
READ = bytes.fromhex("FF FF 01 04 02 38 02 BE")  # present position
WRITE = bytes.fromhex("FF FF 01 05 03 2A 02 BC 0E")  # goal position 700
REG_WRITE = bytes.fromhex("FF FF 01 05 04 2A 02 BC 0D")
ACTION = bytes.fromhex("FF FF 01 02 05 F7")
RECOVERY = bytes.fromhex("FF FF 01 02 06 F6")
REBOOT = bytes.fromhex("FF FF 01 02 08 F4")
RESET = bytes.fromhex("FF FF 01 02 0A F2")
CALIBRATE = bytes.fromhex("FF FF 01 02 0B F1")
SYNC_READ = bytes.fromhex("FF FF FE 06 82 38 02 01 02 3C")
SYNC_WRITE = bytes.fromhex("FF FF FE 0A 83 2A 02 01 02 BC 02 01 23 63")  # 1: 700, 2: 291


@MODELS
class TestEveryInstruction:
    def test_ping(self, model: str) -> None:
        assert Bus(1, models=(model,)).ask(PING) == [OK]
        assert Bus(2, models=(model,)).ask(PING) == []

    def test_a_broadcast_ping_is_not_answered(self, model: str) -> None:
        assert Bus(1, 2, models=(model,)).ask(frame(0xFE, b"\x01")) == []
        assert Bus(1, models=(model,), firmware={"broadcast_ping": True}).send(frame(0xFE, b"\x01")) == [
            Reply(3_000_000, OK)]

    def test_read(self, model: str) -> None:
        bus = Bus(1, models=(model,))
        bus.place(700)
        assert bus.ask(READ) == [bytes.fromhex("FF FF 01 04 00 02 BC 3C")]
        # The block of every cycle and what lies behind it: position, speed, load, voltage, 30 degC.
        volts = {"scs15": 74, "scs0009": 60}[model]
        assert bus.ask(frame(1, b"\x02\x38\x08")) == [
            frame(1, b"\x00\x02\xbc\x00\x00\x00\x00" + bytes([volts, 30]))]

    def test_write(self, model: str) -> None:
        bus = Bus(1, models=(model,))
        assert bus.ask(WRITE) == [OK]
        assert bus.table("goal_position") == [700]

    def test_a_registered_write_waits_for_its_action(self, model: str) -> None:
        bus = Bus(1, models=(model,))
        assert bus.ask(REG_WRITE) == [OK]
        assert bus.table("goal_position") == [0]
        assert bus.ask(frame(1, b"\x02\x40\x01")) == [frame(1, b"\x00\x01")]
        assert bus.ask(ACTION) == [OK]
        assert bus.table("goal_position") == [700]

    def test_recovery(self, model: str) -> None:
        bus = Bus(1, models=(model,), position_p_gain=40)
        assert bus.ask(RECOVERY) == [OK]
        assert bus.ask(PING) == []
        bus.now += 300 * MS
        assert bus.ask(PING) == [OK]
        assert bus.table("position_p_gain") == [15]

    def test_reboot_only_with_its_switch(self, model: str) -> None:
        assert Bus(1, models=(model,)).ask(REBOOT) == []
        bus = Bus(1, models=(model,), firmware={"reboot": True})
        bus.ask(WRITE)
        assert bus.ask(REBOOT) == [OK]
        assert bus.ask(PING) == []
        bus.now += 300 * MS
        assert bus.ask(PING) == [OK]
        assert bus.table("goal_position") == [0]

    def test_reset_is_acknowledged_and_calibration_not_known(self, model: str) -> None:
        bus = Bus(1, models=(model,))
        assert bus.ask(RESET) == [OK]
        assert bus.ask(CALIBRATE) == []

    def test_there_is_no_sync_read(self, model: str) -> None:
        assert Bus(1, 2, models=(model,)).ask(SYNC_READ) == []

    def test_sync_write(self, model: str) -> None:
        bus = Bus(1, 2, models=(model,))
        assert bus.ask(SYNC_WRITE) == []
        assert bus.table("goal_position") == [700, 291]

    def test_the_response_level_leaves_pings_and_reads(self, model: str) -> None:
        bus = Bus(1, models=(model,), status_return_level=0)
        answers = [len(bus.ask(each)) for each in (PING, READ, WRITE, REG_WRITE, ACTION, RESET)]
        assert answers == [1, 1, 0, 0, 0, 0]
        assert bus.table("goal_position") == [700]

    def test_the_return_delay_is_in_units_of_2_us(self, model: str) -> None:
        assert Bus(1, models=(model,), return_delay_time=254).send(PING) == [Reply(508_000, OK)]

    def test_the_error_byte_of_every_answer_is_the_status(self, model: str) -> None:
        bus = Bus(1, models=(model,))
        bus.physics.supply_v[0], bus.physics.temperature_c[0] = 3.0, 90.0
        bus.now += 5 * MS
        bus.place(512)
        assert [bus.ask(instruction)[0][4] for instruction in (PING, READ, WRITE)] == [5, 5, 5]


@pytest.mark.parametrize(
    "body", [b"\x00", b"\x07", b"\x7f", b"\x02", b"\x02\x38", b"\x03", b"\x04", b"\x92\x00\x02\x01\x38"])
def test_what_is_not_understood_is_met_with_silence(body: bytes) -> None:
    bus = Bus(1, models=("scs15",))
    assert bus.ask(frame(1, body)) == []
    assert bus.ask(PING) == [OK]


class TestBesideStsServos:
    def test_each_answers_in_its_byte_order(self) -> None:
        bus = Bus(1, 2, 3, models=BOTH_KINDS)
        bus.place(700, 700, 700)
        reads = [bus.ask(frame(servo_id, b"\x02\x38\x02"))[0][5:-1] for servo_id in (1, 2, 3)]
        assert reads == [b"\x02\xbc", b"\xbc\x02", b"\x02\xbc"]

    def test_one_sync_write_serves_all(self) -> None:
        bus = Bus(1, 2, 3, models=BOTH_KINDS)
        bus.ask(frame(0xFE, bytes.fromhex("83 2A 02 01 02 BC 02 BC 02 03 01 00")))
        assert bus.table("goal_position") == [700, 700, 256]

    def test_of_a_sync_read_they_hear_nothing_and_those_behind_them_wait_in_vain(self) -> None:
        bus = Bus(1, 2, 3, models=BOTH_KINDS)
        ask = b"\x82\x38\x02"
        assert [answer[2] for answer in bus.ask(frame(0xFE, ask + b"\x02\x01"))] == [2]
        assert bus.ask(frame(0xFE, ask + b"\x01\x02")) == []
        patient = Bus(1, 2, 3, models=BOTH_KINDS, firmware={"later_ids_answer": True})
        assert [answer[2] for answer in patient.ask(frame(0xFE, ask + b"\x01\x02"))] == [2]

    def test_the_lock_lies_elsewhere(self) -> None:
        bus = Bus(1, 2, models=("scs15", "sts3215"))
        bus.ask(frame(0xFE, b"\x03\x30\x00"))  # 48: the one's lock, half of the other's torque limit
        assert bus.table("lock") == [0, 0]
        bus.ask(frame(0xFE, b"\x03\x37\x01"))  # 55: nothing, and the other's lock
        assert bus.table("lock") == [0, 1]


@given(st.binary(max_size=60))
def test_after_any_noise_a_pause_brings_the_servo_back(noise: bytes) -> None:
    bus = Bus(9, models=("scs15",))
    bus.send(noise)
    bus.now += 2 * MS
    assert bus.ask(frame(9, b"\x01")) == [frame(9, b"\x00")]


@given(st.binary(min_size=1, max_size=40))
def test_any_instruction_is_answered_with_a_whole_frame_or_not_at_all(body: bytes) -> None:
    for answer in Bus(1, models=("scs0009",)).ask(frame(1, body)):
        assert answer == frame(1, answer[4:-1])


@MODELS
class TestFeetechsSdk:
    """feetech-servo-sdk 1.0.0, unchanged, as its examples use it for SCS servos."""

    @pytest.fixture
    def handler(self) -> Iterator[scservo_sdk.protocol_packet_handler]:
        """A big-endian handler. Its byte order is the whole process's, so it is put right again afterwards."""
        yield scservo_sdk.PacketHandler(1)
        scservo_sdk.PacketHandler(0)

    @pytest.fixture
    def port(self, model: str) -> Port:
        return Port(Bus(1, 2, 3, models=(model,)))

    def test_ping(self, port: Port, handler: scservo_sdk.protocol_packet_handler, model: str) -> None:
        assert handler.ping(port, 2) == ({"scs15": 1295, "scs0009": 1284}[model], 0, 0)
        assert handler.ping(port, 4)[1] == -6  # no status packet

    def test_reads(self, port: Port, handler: scservo_sdk.protocol_packet_handler, model: str) -> None:
        port.bus.place(100, 512, 1000)
        assert handler.read1ByteTxRx(port, 3, 62) == ({"scs15": 74, "scs0009": 60}[model], 0, 0)
        assert handler.read2ByteTxRx(port, 3, 56) == (1000, 0, 0)

    def test_writes(self, port: Port, handler: scservo_sdk.protocol_packet_handler, model: str) -> None:
        assert handler.write1ByteTxRx(port, 1, 40, 1) == (0, 0)
        assert handler.write2ByteTxRx(port, 1, 42, 700) == (0, 0)
        assert handler.regWriteTxRx(port, 3, 42, 2, [0x01, 0x23]) == (0, 0)
        assert handler.action(port, 3) == 0
        assert port.bus.table("torque_enable") == [1, 0, 0]
        assert port.bus.table("goal_position") == [700, 0, 291]

    def test_sync_write(self, port: Port, handler: scservo_sdk.protocol_packet_handler, model: str) -> None:
        group = scservo_sdk.GroupSyncWrite(port, handler, 42, 6)
        for servo_id in (1, 3):
            goal, time, speed = 700, 0, 1500
            words = [*goal.to_bytes(2), *time.to_bytes(2), *speed.to_bytes(2)]
            assert group.addParam(servo_id, words)
        assert group.txPacket() == 0
        assert port.bus.table("goal_position") == [700, 0, 700]
        assert port.bus.table("goal_velocity") == [1500, 0, 1500]

    def test_a_sync_read_fails(self, port: Port, handler: scservo_sdk.protocol_packet_handler, model: str) -> None:
        group = scservo_sdk.GroupSyncRead(port, handler, 56, 2)
        for servo_id in (1, 2):
            assert group.addParam(servo_id)
        assert group.txRxPacket() != 0
        assert not group.isAvailable(1, 56, 2)

    def test_the_error_byte(self, port: Port, handler: scservo_sdk.protocol_packet_handler, model: str) -> None:
        port.bus.physics.temperature_c[0] = 90.0
        port.bus.now += 5 * MS
        port.bus.place(512, 512, 512)
        assert handler.read1ByteTxRx(port, 1, 63) == (90, 0, 4)
