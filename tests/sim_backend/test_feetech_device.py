"""The STS3215 seen from the wire: literal bytes, and Feetech's own SDK."""

import pytest
import scservo_sdk
from hypothesis import given
from hypothesis import strategies as st

from sim_backend.device import Reply

from .feetech_bus import BAUD, MS, Bus, Port, frame

PING = bytes.fromhex("FF FF 01 02 01 FB")
OK = bytes.fromhex("FF FF 01 02 00 FC")
READ = bytes.fromhex("FF FF 01 04 02 38 02 BE")  # present position
READ_STATUS = bytes.fromhex("FF FF 01 04 00 00 08 F2")  # 2048
WRITE = bytes.fromhex("FF FF 01 05 03 2A E8 03 E1")  # goal position 1000
REG_WRITE = bytes.fromhex("FF FF 01 05 04 2A E8 03 E0")
ACTION = bytes.fromhex("FF FF 01 02 05 F7")
RECOVERY = bytes.fromhex("FF FF 01 02 06 F6")
REBOOT = bytes.fromhex("FF FF 01 02 08 F4")
RESET = bytes.fromhex("FF FF 01 02 0A F2")
CALIBRATE = bytes.fromhex("FF FF 01 02 0B F1")
SYNC_READ = bytes.fromhex("FF FF FE 06 82 38 02 01 02 3C")
SYNC_WRITE = bytes.fromhex("FF FF FE 0A 83 2A 02 01 E8 03 02 D0 07 83")  # 1: 1000, 2: 2000


def test_a_ping_tells_nothing_but_that_the_servo_is_there() -> None:
    assert Bus(1).ask(PING) == [OK]
    assert Bus(2).ask(PING) == []


def test_the_model_number_is_at_address_3() -> None:
    assert Bus(1).ask(frame(1, b"\x02\x03\x02")) == [frame(1, b"\x00\x09\x03")]  # 777


def test_read_and_write() -> None:
    bus = Bus(1)
    assert bus.ask(READ) == [READ_STATUS]
    assert bus.ask(WRITE) == [OK]
    assert bus.table("goal_position") == [1000]


def test_the_block_read_in_every_cycle() -> None:
    bus = Bus(1)
    bus.place(1000)
    # position 1000, speed 0, load 0, 7.4 V, 30 degC, three flags, two empty bytes, current 0
    assert bus.ask(frame(1, b"\x02\x38\x0f")) == [
        frame(1, b"\x00" + bytes.fromhex("E8 03 00 00 00 00 4A 1E 00 00 00 00 00 00 00"))]


def test_what_is_not_there_reads_as_zero() -> None:
    bus = Bus(1)
    assert bus.ask(frame(1, b"\x02\x32\x02")) == [frame(1, b"\x00\x00\x00")]
    assert bus.ask(frame(1, b"\x02\xc8\x03")) == [frame(1, b"\x00\x00\x00\x00")]
    assert len(bus.ask(frame(1, b"\x02\x00\xfd"))[0]) == 259
    assert bus.ask(frame(1, b"\x02\x00\xfe")) == [], "the status' length has but a byte"


def test_a_registered_write_waits_for_its_action() -> None:
    bus = Bus(1)
    assert bus.ask(REG_WRITE) == [OK]
    assert bus.table("goal_position") == [0]
    assert bus.ask(frame(1, b"\x02\x40\x01")) == [frame(1, b"\x00\x01")]
    assert bus.ask(ACTION) == [OK]
    assert bus.table("goal_position") == [1000]
    assert bus.ask(frame(1, b"\x02\x40\x01")) == [frame(1, b"\x00\x00")]
    bus.ask(frame(1, b"\x03\x2a\x05\x00"))
    assert bus.ask(ACTION) == [OK]
    assert bus.table("goal_position") == [5], "an action is carried out once"


def test_broadcasts_are_obeyed_in_silence() -> None:
    bus = Bus(1, 2)
    assert bus.ask(frame(0xFE, REG_WRITE[4:-1])) == []
    assert bus.ask(frame(0xFE, b"\x05")) == []
    assert bus.table("goal_position") == [1000, 1000]
    assert bus.ask(frame(0xFE, b"\x03\x28\x01")) == []
    assert bus.table("torque_enable") == [1, 1]
    assert bus.ask(frame(0xFE, READ[4:-1])) == []


def test_a_broadcast_ping_is_answered_in_the_time_slots_of_the_ids() -> None:
    assert Bus(2, 1).send(frame(0xFE, b"\x01")) == [
        Reply(3_000_000, OK), Reply(2_940_000, bytes.fromhex("FF FF 02 02 00 FB"))]


def test_sync_read_is_answered_one_by_one_in_the_listed_order() -> None:
    bus = Bus(2, 1, return_delay_time=5)
    bus.place(1000, 2048)
    assert bus.send(SYNC_READ) == [Reply(10_000, READ_STATUS), Reply(10_000, frame(2, b"\x00\xe8\x03"))]


@pytest.mark.parametrize(("patient", "answering"), [(False, [1]), (True, [1, 3])])
def test_a_silent_servo_may_silence_those_listed_behind_it(patient: bool, answering: list[int]) -> None:
    bus = Bus(1, 3, firmware={"later_ids_answer": patient})
    assert [answer[2] for answer in bus.ask(frame(0xFE, b"\x82\x38\x02\x01\x02\x03"))] == answering


def test_sync_write() -> None:
    bus = Bus(1, 2, 3)
    assert bus.ask(SYNC_WRITE) == []
    assert bus.table("goal_position") == [1000, 2000, 0]


@pytest.mark.parametrize("body", [b"\x83", b"\x83\x2a\x02", b"\x83\x2a\x02\x01\xe8", b"\x82", b"\x82\x38\x02"])
def test_group_instructions_without_their_parts_are_passed_over(body: bytes) -> None:
    bus = Bus(1)
    assert bus.ask(frame(0xFE, body)) == []
    assert bus.table("goal_position") == [0]


def test_at_response_level_0_only_pings_and_reads_are_answered() -> None:
    bus = Bus(1)
    assert bus.ask(frame(1, b"\x03\x08\x00")) == [OK]
    assert bus.ask(WRITE) == []
    assert bus.table("goal_position") == [1000]
    assert [bus.ask(instruction) for instruction in (REG_WRITE, ACTION, RESET)] == [[], [], []]
    assert bus.ask(PING) == [OK]
    assert bus.ask(READ) == [READ_STATUS]
    assert len(bus.ask(SYNC_READ)) == 1


def test_return_delay() -> None:
    bus = Bus(1, return_delay_time=254)
    assert bus.send(PING)[0].delay_ns == 508_000
    bus.send(frame(1, b"\x03\x07\x00"))
    assert bus.send(PING)[0].delay_ns == 0


def test_a_new_id_and_a_new_baud_count_from_the_next_instruction_on() -> None:
    bus = Bus(1)
    assert bus.ask(frame(1, b"\x03\x05\x09")) == [OK]
    assert bus.ask(PING) == []
    assert bus.ask(frame(9, b"\x03\x06\x05")) == [bytes.fromhex("FF FF 09 02 00 F4")]
    assert bus.ask(frame(9, b"\x01")) == []
    assert len(bus.send(frame(9, b"\x01"), baud=76_800)) == 1


def test_recovery_brings_the_factory_back_but_keeps_the_id() -> None:
    bus = Bus(7, position_p_gain=16, baud_rate=1)
    bus.send(frame(7, b"\x03\x28\x01"), baud=500_000)
    assert len(bus.send(frame(7, b"\x06"), baud=500_000)) == 1
    assert bus.ask(frame(7, b"\x01")) == [], "it starts anew"
    bus.now += 300 * MS
    assert len(bus.ask(frame(7, b"\x01"))) == 1
    assert bus.table("position_p_gain") == [32]
    assert bus.table("torque_enable") == [0]


def test_recovery_outlives_power() -> None:
    bus = Bus(1, position_p_gain=16)
    bus.ask(RECOVERY)
    bus.servos[0].reboot(bus.now)
    assert bus.table("position_p_gain") == [32]


def test_reset_forgets_whole_turns() -> None:
    bus = Bus(1, min_position_limit=0, max_position_limit=0, phase=0x1C)
    bus.place(2048 + 2 * 4096)
    assert bus.ask(READ) == [frame(1, b"\x00\x00\x28")]
    assert bus.ask(RESET) == [OK]
    assert bus.ask(READ) == [READ_STATUS]


@pytest.mark.parametrize(("keeps", "found"), [(True, 2), (False, 1)])
def test_whether_recovery_keeps_the_id_is_a_switch(keeps: bool, found: int) -> None:
    bus = Bus(2, firmware={"recovery_keeps_id": keeps}, position_p_gain=16)
    assert bus.ask(frame(2, b"\x06")) == [frame(2, b"\x00")]
    bus.now += 300 * MS
    assert bus.ask(frame(found, b"\x02\x05\x01")) == [frame(found, bytes([0, found]))]
    assert bus.table("position_p_gain") == [32]


def test_calibration_is_known_only_with_its_switch() -> None:
    bus = Bus(1)
    bus.place(2148)
    assert bus.ask(CALIBRATE) == []
    assert bus.table("position_offset") == [0]
    bus = Bus(1, firmware={"calibrate": True})
    bus.place(2148)
    assert bus.ask(CALIBRATE) == [OK]
    assert bus.table("position_offset") == [100]
    assert bus.ask(READ) == [READ_STATUS]


def test_the_switch_for_broadcast_pings() -> None:
    assert Bus(1, firmware={"broadcast_ping": False}).ask(frame(0xFE, b"\x01")) == []


def test_reboot_is_known_only_with_its_switch() -> None:
    bus = Bus(1)
    assert bus.ask(REBOOT) == []
    assert bus.ask(PING) == [OK]
    bus = Bus(1, firmware={"reboot": True})
    bus.ask(WRITE)
    assert bus.ask(REBOOT) == [OK]
    assert bus.ask(PING) == []
    bus.now += 300 * MS
    assert bus.ask(PING) == [OK]
    assert bus.table("goal_position") == [0]


@pytest.mark.parametrize(
    "body", [b"\x00", b"\x07", b"\x0b", b"\x7f", b"\x02", b"\x02\x38", b"\x02\x38\x02\x00", b"\x03", b"\x04",
             b"\x82\x38\x02\x01", b"\x92\x00\x02\x01\x38"])
def test_what_is_not_understood_is_met_with_silence(body: bytes) -> None:
    bus = Bus(1)
    assert bus.ask(frame(1, body)) == []
    assert bus.ask(PING) == [OK]


@pytest.mark.parametrize("instruction", [PING, READ, WRITE, SYNC_READ])
def test_a_wrong_checksum_is_met_with_silence(instruction: bytes) -> None:
    bus = Bus(1)
    assert bus.ask(instruction[:-1] + bytes([instruction[-1] ^ 1])) == []
    assert bus.table("goal_position") == [0]
    assert bus.ask(PING) == [OK]


def test_the_error_byte_of_every_answer_is_the_status() -> None:
    bus = Bus(1)
    bus.physics.supply_v[0], bus.physics.temperature_c[0] = 3.0, 80.0
    bus.now += 5 * MS
    bus.place(2048)
    assert [bus.ask(instruction)[0][4] for instruction in (PING, READ, WRITE, SYNC_READ)] == [5, 5, 5, 5]
    assert bus.ask(frame(1, b"\x02\x41\x01")) == [frame(1, b"\x05\x05")]


def test_with_its_switch_set_the_error_byte_says_that_torque_is_on() -> None:
    bus = Bus(1, firmware={"torque_flag_in_status": True})
    assert bus.ask(frame(1, b"\x03\x28\x01")) == [OK]
    assert bus.ask(PING) == [frame(1, b"\x10")]


def test_headers_may_occur_in_data() -> None:
    bus = Bus(1)
    # Limits of 0xFF are allowed; so is the frame of a ping in bytes that are passed over.
    assert bus.ask(frame(1, b"\x03\x12\xff\xff")) == [OK]
    assert bus.table("phase") == [255]
    assert bus.table("unloading_condition") == [255]
    assert bus.ask(frame(1, b"\x03\x49" + PING)) == [OK]


@pytest.mark.parametrize(
    "noise", [b"\0", b"\xff", b"\xff\xff\xff", b"\xff\xff\x01\x00", b"\xff\xff\x01\x01\x00", b"\x55" * 50,
              b"\xff\xff\x01\x04", READ[:-1], READ[:-1] + b"\0"])
def test_noise_and_broken_frames_before_a_frame_are_skipped(noise: bytes) -> None:
    assert Bus(1).ask(noise + PING)[-1:] == [OK]


def test_a_frame_may_arrive_in_pieces_but_without_a_long_pause() -> None:
    bus = Bus(1)
    for byte in PING[:-1]:
        assert bus.device.receive(bytes([byte]), bus.now, BAUD) == []
        bus.now += MS
    assert len(bus.device.receive(PING[-1:], bus.now, BAUD)) == 1
    bus.device.receive(PING[:3], bus.now, BAUD)
    bus.now += 2 * MS
    assert bus.device.receive(PING[3:], bus.now, BAUD) == []
    assert bus.ask(PING) == [OK]


def test_several_frames_in_one_piece() -> None:
    assert [answer[2] for answer in Bus(1, 2).ask(SYNC_WRITE + SYNC_READ + PING)] == [1, 2, 1]


def test_of_two_servos_with_one_id_both_obey_and_their_answers_collide() -> None:
    bus = Bus(1, 1)
    assert bytes.fromhex("FF FF 01 02 00 FC") == OK
    assert bus.ask(WRITE) == [bytes.fromhex("FB FB 01 02 00 E0")], "with itself, three bits later"
    assert bus.table("goal_position") == [1000, 1000]


def test_two_servos_with_one_id_that_do_not_overlap_are_both_heard() -> None:
    bus = Bus(1, 1)
    bus.servos[1].write(7, b"\xfe")  # return delay time: 508 us
    assert [reply.data for reply in bus.send(PING)] == [OK, OK]
    assert [reply.delay_ns for reply in bus.send(PING)] == [0, 451_000], "508 us, 3 bits, less six bytes"


def test_a_frame_too_short_for_an_instruction_is_none() -> None:
    assert Bus(0xFD).ask(b"\xff\xff\xfd\x01\x01") == []


@given(st.binary(max_size=60))
def test_after_any_noise_a_pause_brings_the_servo_back(noise: bytes) -> None:
    bus = Bus(9)
    bus.send(noise)
    bus.now += 2 * MS
    assert bus.ask(frame(9, b"\x01")) == [frame(9, b"\x00")]


@given(st.binary(min_size=1, max_size=40))
def test_any_instruction_is_answered_with_a_whole_frame_or_not_at_all(body: bytes) -> None:
    for answer in Bus(1).ask(frame(1, body)):
        assert answer == frame(1, answer[4:-1])


class TestFeetechsSdk:
    """feetech-servo-sdk 1.0.0, unchanged."""

    @pytest.fixture
    def port(self) -> Port:
        return Port(Bus(1, 2, 3))

    @pytest.fixture
    def handler(self) -> scservo_sdk.protocol_packet_handler:
        return scservo_sdk.PacketHandler(0)

    def test_ping(self, port: Port, handler: scservo_sdk.protocol_packet_handler) -> None:
        assert handler.ping(port, 2) == (777, 0, 0)
        assert handler.ping(port, 4)[1] == -6  # no status packet

    def test_reads(self, port: Port, handler: scservo_sdk.protocol_packet_handler) -> None:
        port.bus.place(1000, 2000, 3000)
        assert handler.read1ByteTxRx(port, 3, 62) == (74, 0, 0)
        assert handler.read2ByteTxRx(port, 3, 56) == (3000, 0, 0)
        assert handler.read4ByteTxRx(port, 2, 9) == (4095 << 16, 0, 0)

    def test_writes(self, port: Port, handler: scservo_sdk.protocol_packet_handler) -> None:
        assert handler.write1ByteTxRx(port, 1, 40, 1) == (0, 0)
        assert handler.write2ByteTxRx(port, 1, 42, 1234) == (0, 0)
        assert handler.write4ByteTxRx(port, 2, 9, 3000 << 16 | 1000) == (0, 0)
        assert handler.regWriteTxRx(port, 3, 42, 2, [0xD2, 0x04]) == (0, 0)
        assert handler.action(port, 3) == 0
        assert port.bus.table("torque_enable") == [1, 0, 0]
        assert port.bus.table("goal_position") == [1234, 0, 1234]
        assert port.bus.table("min_position_limit") == [0, 1000, 0]
        assert port.bus.table("max_position_limit") == [4095, 3000, 4095]

    def test_sync_read(self, port: Port, handler: scservo_sdk.protocol_packet_handler) -> None:
        port.bus.place(1000, 2000, 3000)
        group = scservo_sdk.GroupSyncRead(port, handler, 56, 15)
        for servo_id in (3, 1, 2):
            assert group.addParam(servo_id)
        assert group.txRxPacket() == 0
        assert [group.getData(servo_id, 56, 2) for servo_id in (1, 2, 3)] == [1000, 2000, 3000]
        assert group.getData(1, 62, 1) == 74

    def test_sync_write(self, port: Port, handler: scservo_sdk.protocol_packet_handler) -> None:
        group = scservo_sdk.GroupSyncWrite(port, handler, 41, 7)
        for servo_id in (1, 3):
            assert group.addParam(servo_id, [50, 0xE8, 0x03, 0, 0, 0x2C, 0x01])
        assert group.txPacket() == 0
        assert port.bus.table("acceleration") == [50, 0, 50]
        assert port.bus.table("goal_position") == [1000, 0, 1000]
        assert port.bus.table("goal_velocity") == [300, 0, 300]


@pytest.mark.parametrize(("new", "answering"), [(False, 1), (True, 5)])
def test_the_switch_for_the_answer_to_a_new_id(new: bool, answering: int) -> None:
    bus = Bus(1, firmware={"answers_at_new_setting": new})
    assert bus.ask(frame(1, b"\x03\x05\x05")) == [frame(answering, b"\0")]


@pytest.mark.parametrize("new", [False, True])
def test_the_switch_for_the_answer_to_a_new_baud_rate(new: bool) -> None:
    bus = Bus(1, firmware={"answers_at_new_setting": new})
    assert (bus.ask(frame(1, b"\x03\x06\x04")) == [frame(1, b"\0")]) == (not new)


@pytest.mark.parametrize("kept", [False, True])
def test_the_switch_for_a_centre_that_outlives_the_lock(kept: bool) -> None:
    bus = Bus(1, firmware={"centre_outlives_lock": kept})
    bus.place(2148)
    bus.ask(frame(1, b"\x03\x37\1"))
    bus.ask(frame(1, b"\x03\x28\x80"))
    assert bus.table("position_offset") == [100]
    bus.servos[0].lose_power(bus.now, 0.0)
    assert bus.table("position_offset") == [100 * kept]


def test_the_switches_for_turnaround_and_for_slow_eeprom() -> None:
    bus = Bus(1, firmware={"turnaround_us": 50, "eeprom_write_ms": 25}, return_delay_time=0)
    writes = b"\x03\x2a\0\1", b"\x03\x15\x20", b"\x03\x37\1", b"\x03\x15\x21"
    delays = [bus.send(frame(1, body))[0].delay_ns for body in writes]
    assert delays == [50_000, 25_050_000, 50_000, 50_000], "RAM, EEPROM, the lock, EEPROM that is locked"
