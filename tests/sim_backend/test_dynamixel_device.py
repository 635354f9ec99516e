import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.register_map import ServoModel
from sim_backend.device import Reply

from .dynamixel_bus import BAUD, ROWS, Bus, crc, frame, read, status, write

# The frames of the e-Manual, Protocol 2.0.
PING = bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E")
PING_STATUS = bytes.fromhex("FF FF FD 00 01 07 00 55 00 06 04 26 65 5D")
PING_STATUS_OF_2 = bytes.fromhex("FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D")
PING_ALL = bytes.fromhex("FF FF FD 00 FE 03 00 01 31 42")
READ = bytes.fromhex("FF FF FD 00 01 07 00 02 84 00 04 00 1D 15")
READ_STATUS = bytes.fromhex("FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0")
WRITE = bytes.fromhex("FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89")
DONE = bytes.fromhex("FF FF FD 00 01 04 00 55 00 A1 0C")
REG_WRITE = bytes.fromhex("FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E")
ACTION = bytes.fromhex("FF FF FD 00 01 03 00 05 02 CE")
REBOOT = bytes.fromhex("FF FF FD 00 01 03 00 08 2F 4E")
FACTORY_RESET = bytes.fromhex("FF FF FD 00 01 04 00 06 01 A1 E6")
SYNC_READ = bytes.fromhex("FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA")
SYNC_WRITE = bytes.fromhex("FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87")
FAST_SYNC_READ = bytes.fromhex("FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2")
FAST_SYNC_STATUS = bytes.fromhex(
    "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 08 00 00 16 CA 00 04 FF 03 00 00 D1 9E")


def test_ping() -> None:
    bus = Bus(1, model_number=1030, firmware_version=38)
    assert bus.ask(PING) == [PING_STATUS]


def test_broadcast_ping_is_answered_in_the_order_of_ids_and_in_their_time_slots() -> None:
    bus = Bus(2, 1, model_number=1030, firmware_version=38)
    # 3 ms per id and 0.5 ms return delay; the first answer takes 14 bytes of 10 us.
    assert bus.send(PING_ALL) == [Reply(3_500_000, PING_STATUS), Reply(2_860_000, PING_STATUS_OF_2)]


def test_answers_that_outlast_their_slots_push_back_those_behind_them() -> None:
    bus = Bus(1, 2, baud_rate=0, return_delay_time=0)
    assert [reply.delay_ns for reply in bus.send(PING_ALL, baud=9600)] == [3_000_000, 0]


def test_read() -> None:
    bus = Bus(1)
    bus.place(166)
    assert bus.ask(READ) == [READ_STATUS]


def test_write() -> None:
    bus = Bus(1)
    assert bus.ask(WRITE) == [DONE]
    assert bus.servos[0].table["goal_position"] == 512


def test_a_registered_write_waits_for_its_action() -> None:
    bus = Bus(1)
    assert bus.ask(REG_WRITE) == [DONE]
    assert bus.servos[0].table["goal_velocity"] == 0
    assert bus.ask(read(1, 69, 1)) == [status(1, 0, b"\1")]
    assert bus.ask(ACTION) == [DONE]
    assert bus.servos[0].table["goal_velocity"] == 200
    assert bus.ask(read(1, 69, 1)) == [status(1, 0, b"\0")]
    assert bus.ask(ACTION) == [status(1, 2)]


def test_a_registered_write_is_checked_at_once() -> None:
    bus = Bus(1)
    assert bus.ask(frame(1, b"\x04\x68\x00\xff\x03\x00\x00")) == [status(1, 6)]
    assert bus.ask(ACTION) == [status(1, 2)]


def test_broadcast_action_moves_all_who_wait_and_nobody_answers() -> None:
    bus = Bus(1, 2)
    bus.send(frame(0xFE, REG_WRITE[7:-2]))
    assert bus.ask(frame(0xFE, b"\x05")) == []
    assert [servo.table["goal_velocity"] for servo in bus.servos] == [200, 200]


def test_reboot_is_answered_and_then_the_servo_is_silent_for_a_while() -> None:
    bus = Bus(1)
    bus.ask(write(1, 65, b"\1"))
    assert bus.ask(REBOOT) == [DONE]
    assert bus.ask(PING) == []
    bus.pass_time(290.0)
    assert bus.ask(PING) == []
    bus.pass_time(10.0)
    assert len(bus.ask(PING)) == 1
    assert bus.ask(read(1, 65, 1)) == [status(1, 0, b"\0")]


def test_sync_read_is_answered_one_by_one_in_the_listed_order() -> None:
    bus = Bus(2, 1, return_delay_time=5)
    bus.place(2079, 166)
    assert bus.send(SYNC_READ) == [
        Reply(10_000, READ_STATUS), Reply(10_000, status(2, 0, bytes([0x1F, 8, 0, 0])))]


def test_sync_write() -> None:
    bus = Bus(1, 2, 3)
    assert bus.ask(SYNC_WRITE) == []
    assert [servo.table["goal_position"] for servo in bus.servos] == [150, 170, 2048]


def test_a_sync_write_that_one_servo_refuses_reaches_the_others() -> None:
    bus = Bus(1, 2)
    bus.ask(write(1, 52, (160).to_bytes(4, "little")))
    bus.ask(SYNC_WRITE)
    assert [servo.table["goal_position"] for servo in bus.servos] == [2048, 170]


@pytest.mark.parametrize(("option", "servo_id", "baud"), [(0xFF, 1, 57600), (1, 9, 57600), (2, 9, BAUD)])
def test_a_factory_reset_is_answered_and_keeps_what_the_option_says(option: int, servo_id: int, baud: int) -> None:
    bus = Bus(9)
    bus.ask(write(9, 31, b"\x32"))
    assert bus.ask(frame(9, bytes((6, option)))) == [status(9, 0)]
    assert bus.ask(frame(9, PING[7:-2])) == []
    bus.pass_time(400)
    [servo] = bus.servos
    assert (servo.id, servo.table["temperature_limit"], servo.table["firmware_version"]) == (servo_id, 72, 45)
    assert bus.send(frame(servo_id, PING[7:-2]), baud) != []


def test_a_factory_reset_of_all_to_one_id_and_an_unknown_option_are_refused() -> None:
    bus = Bus(1, 9)
    assert bus.ask(frame(0xFE, b"\x06\xff")) == []
    assert bus.ask(frame(1, b"\x06\x03")) == [status(1, 4)]
    assert bus.ask(frame(1, b"\x06")) == [status(1, 5)]
    assert [servo.id for servo in bus.servos] == [1, 9]
    assert bus.ask(FACTORY_RESET) == [DONE]  # the e-Manual's


def test_fast_sync_read_is_one_frame_with_running_crcs_and_one_return_delay() -> None:
    bus = Bus(3, 7, 4)
    bus.place(166, 2079, 1023)
    assert bus.send(FAST_SYNC_READ) == [Reply(500_000, FAST_SYNC_STATUS)]


@pytest.mark.parametrize("instruction", [frame(1, b"\x7f"), frame(1, b"\x0a"), frame(1, SYNC_READ[7:-2])])
def test_unknown_instructions_are_instruction_errors(instruction: bytes) -> None:
    assert Bus(1).ask(instruction) == [status(1, 2)]


@pytest.mark.parametrize(
    ("instruction", "number"), [
        (WRITE[:-1] + b"\x88", 3),
        (write(1, 64, b"\2"), 4),
        (write(1, 116, b"\0\0"), 5),
        (frame(1, b"\x02\x84\x00\x04"), 5),
        (write(1, 104, (266).to_bytes(4, "little")), 6),
        (write(1, 132, bytes(4)), 7),
        (read(1, 250, 4), 7),
    ])
def test_error_numbers(instruction: bytes, number: int) -> None:
    assert Bus(1).ask(instruction) == [status(1, number)]


def test_a_servo_other_than_the_addressed_one_does_not_report_a_bad_crc() -> None:
    bad = PING[:-1] + b"\0"
    assert Bus(2).ask(bad) == []
    assert Bus(1).ask(frame(0xFE, b"\x01")[:-1] + b"\0") == []


def test_status_return_level() -> None:
    bus = Bus(1)
    assert bus.ask(write(1, 68, b"\1")) == [DONE]
    assert bus.ask(WRITE) == []
    assert bus.servos[0].table["goal_position"] == 512
    assert len(bus.ask(READ)) == 1
    assert bus.ask(write(1, 64, b"\2")) == []  # not even errors
    assert bus.ask(PING[:-1] + b"\0") == []
    bus.ask(write(1, 68, b"\0"))
    assert bus.ask(READ) == []
    assert bus.ask(SYNC_READ) == []
    assert len(bus.ask(PING)) == 1


def test_return_delay() -> None:
    bus = Bus(1, return_delay_time=254)
    assert bus.send(PING)[0].delay_ns == 508_000
    bus.send(write(1, 9, b"\0"))
    assert bus.send(PING)[0].delay_ns == 0


def test_servos_at_another_baud_rate_hear_nothing() -> None:
    bus = Bus(1, baud_rate=1)
    assert bus.send(PING) == []
    assert len(bus.send(PING, baud=57_600)) == 1
    bus.send(write(1, 8, b"\3"), baud=57_600)
    assert bus.send(PING, baud=57_600) == []
    assert len(bus.send(PING)) == 1


def test_a_new_id_counts_from_the_next_instruction_on() -> None:
    bus = Bus(1)
    assert bus.ask(write(1, 7, b"\5")) == [DONE]
    assert bus.ask(PING) == []
    assert len(bus.ask(frame(5, b"\x01"))) == 1


def test_of_two_servos_with_one_id_both_obey_and_their_answers_collide() -> None:
    bus = Bus(1, 1)
    [heard] = bus.ask(WRITE)
    # Of every FF the third bit is the other's start bit.
    assert heard[:3] == b"\xfb\xfb\xe9"
    assert [servo.table["goal_position"] for servo in bus.servos] == [512, 512]


def test_a_secondary_id_is_obeyed_in_silence() -> None:
    bus = Bus(1, 2, secondary_id=9)
    assert bus.ask(write(9, 65, b"\1")) == []
    assert [servo.table["led"] for servo in bus.servos] == [1, 1]
    assert bus.ask(frame(9, b"\x01")) == []


def test_a_sync_write_reaches_secondary_ids_unless_they_are_off() -> None:
    bus = Bus(1, 2, secondary_id=9)
    bus.ask(frame(0xFE, b"\x83\x41\x00\x01\x00\x09\x01"))
    assert [servo.table["led"] for servo in bus.servos] == [1, 1]
    without = Bus(1)
    without.ask(frame(0xFE, b"\x83\x41\x00\x01\x00\xff\x01"))
    assert without.servos[0].table["led"] == 0


def test_broadcast_writes_are_obeyed_and_broadcast_reads_are_not_answered() -> None:
    bus = Bus(1, 2)
    assert bus.ask(write(0xFE, 65, b"\1")) == []
    assert [servo.table["led"] for servo in bus.servos] == [1, 1]
    assert bus.ask(read(0xFE, 132, 4)) == []
    assert bus.ask(frame(0xFE, b"\x08")) == []
    assert bus.ask(PING_ALL) == []  # all of them reboot


def sync_read(*ids: int, instruction: int = 0x82) -> bytes:
    return frame(0xFE, bytes([instruction, 132, 0, 4, 0, *ids]))


@pytest.mark.parametrize(
    ("listed", "answering"),
    [((1, 2, 3), [1]), ((2, 1, 3), []), ((1, 3, 2), [1, 3]), ((3, 1), [3, 1])])
def test_a_silent_servo_silences_those_behind_it(listed: tuple[int, ...], answering: list[int]) -> None:
    bus = Bus(1, 3)
    assert [answer[4] for answer in bus.ask(sync_read(*listed))] == answering


def test_firmware_that_times_out_answers_behind_a_silent_servo() -> None:
    rows = ROWS | {"firmware": ROWS["firmware"] | {"later_ids_answer": True}}
    bus = Bus(1, 3, model=ServoModel.model_validate(rows))
    assert [answer[4] for answer in bus.ask(sync_read(2, 1, 3))] == [1, 3]


def test_a_fast_sync_read_stops_at_a_silent_servo() -> None:
    bus = Bus(3, 4)
    bus.place(166, 1023)
    assert bus.ask(FAST_SYNC_READ) == [FAST_SYNC_STATUS[:16]]  # id 7 is missing
    assert bus.ask(sync_read(7, 3, instruction=0x8A)) == []


def test_firmware_before_45_has_no_fast_sync_read() -> None:
    assert Bus(3, 7, 4, firmware_version=44).ask(FAST_SYNC_READ) == []


def test_a_refused_fast_sync_read_keeps_its_shape() -> None:
    answer = Bus(1).ask(frame(0xFE, b"\x8a\xfa\x00\x04\x00\x01"))  # 250, 4 bytes: beyond the block
    head = b"\xff\xff\xfd\x00\xfe\x09\x00\x55\x07\x01\0\0\0\0"
    assert answer == [head + crc(head).to_bytes(2, "little")]


def test_the_alert_bit_is_set_in_every_answer_after_a_hardware_error() -> None:
    bus = Bus(1, return_delay_time=0)
    bus.physics.temperature_c[0] = 80.0
    bus.pass_time(5.0)
    assert bus.ask(PING)[0][8] == 0x80
    assert bus.ask(WRITE) == [status(1, 0x80)]
    assert bus.ask(write(1, 64, b"\2")) == [status(1, 0x84)]
    assert bus.ask(SYNC_READ)[0][8] == 0x80
    assert bus.ask(sync_read(1, instruction=0x8A))[0][8] == 0x80
    assert bus.ask(READ[:-1] + b"\0") == [status(1, 0x83)]


def test_stuffing_in_what_is_written() -> None:
    bus = Bus(1)
    # FF FF FD to the indirect data at 224 goes over the wire as FF FF FD FD.
    assert bus.ask(write(1, 224, b"\xff\xff\xfd\xfd")) == [DONE]
    assert bus.servos[0].table.read(224, 4) == b"\xff\xff\xfd\0"
    bus.ask(write(1, 230, b"\xff\xff\xfd\xfd\xfd\x07"))
    assert bus.servos[0].table.read(230, 5) == b"\xff\xff\xfd\xfd\x07"


def test_stuffing_in_what_is_read() -> None:
    bus = Bus(1)
    bus.servos[0].table.data[224:227] = b"\xff\xff\xfd"
    assert bus.ask(read(1, 224, 3)) == [status(1, 0, b"\xff\xff\xfd\xfd")]
    assert bus.ask(read(1, 224, 4)) == [status(1, 0, b"\xff\xff\xfd\xfd\0")]


def test_a_fast_sync_read_is_not_stuffed() -> None:
    bus = Bus(1)
    bus.servos[0].table.data[224:227] = b"\xff\xff\xfd"
    answer = bus.ask(frame(0xFE, b"\x8a\xe0\x00\x03\x00\x01"))[0]
    assert answer[8:13] == b"\x00\x01\xff\xff\xfd"
    assert len(answer) == 15


def test_an_unstuffed_header_inside_a_frame_loses_it() -> None:
    bus = Bus(1)
    assert bus.ask(write(1, 224, b"\xff\xff\xfd\x00")) == []
    bus.pass_time(3.0)
    assert len(bus.ask(PING)) == 1


def test_a_frame_may_arrive_in_pieces() -> None:
    bus = Bus(1)
    for byte in PING[:-1]:
        assert bus.device.receive(bytes([byte]), bus.now, BAUD) == []
        bus.now += 1_500_000
    assert len(bus.device.receive(PING[-1:], bus.now, BAUD)) == 1


def test_a_gap_of_more_than_a_millisecond_and_a_half_drops_the_frame() -> None:
    bus = Bus(1)
    bus.device.receive(PING[:5], bus.now, BAUD)
    bus.now += 1_500_000 + 5 * 10_000 + 1  # five more bytes of 10 us each
    assert bus.device.receive(PING[5:], bus.now, BAUD) == []
    assert len(bus.ask(PING)) == 1


def test_the_others_answer_while_one_servo_reboots() -> None:
    bus = Bus(1, 2)
    bus.ask(REBOOT)
    assert [answer[4] for answer in bus.ask(sync_read(2))] == [2]


@pytest.mark.parametrize(
    "noise",
    [b"\0", b"\xff", b"\xff\xff", b"\xff\xff\xfd", b"\xff\xff\xfd\xfd", b"\xff\xff\xfd\x00",
     b"\xff\xff\xff\xff\xfd", b"\xff\xff\xfd\x00\xff\x03\x00\x01", b"\xff\xff\xfd\x00\x01\xff\xff\x01",
     PING[:7], READ[:10], b"\x55" * 50])
def test_noise_and_broken_frames_before_a_frame_are_skipped(noise: bytes) -> None:
    bus = Bus(1, model_number=1030, firmware_version=38)
    assert bus.ask(noise + PING)[-1] == PING_STATUS


def test_a_frame_of_the_wrong_length_is_reported_and_the_next_one_found() -> None:
    bus = Bus(1, model_number=1030, firmware_version=38)
    broken = READ[:5] + b"\x05" + READ[6:]  # two bytes short
    assert bus.ask(broken + PING) == [status(1, 3), PING_STATUS]


def test_several_frames_in_one_piece() -> None:
    bus = Bus(1, 2)
    bus.place(150, 170)
    assert [answer[4] for answer in bus.ask(SYNC_WRITE + SYNC_READ + PING)] == [1, 2, 1]


def test_answers_of_other_servos_are_not_instructions() -> None:
    assert Bus(1).ask(READ_STATUS) == []


@given(st.binary(max_size=60))
def test_after_any_noise_a_pause_brings_the_servo_back(noise: bytes) -> None:
    bus = Bus(1, model_number=1030, firmware_version=38)
    bus.send(noise)
    bus.pass_time(2.0)
    assert bus.ask(PING) == [PING_STATUS]


@given(st.binary(min_size=1, max_size=40))
def test_any_instruction_to_a_servo_is_answered_with_a_whole_frame_or_not_at_all(body: bytes) -> None:
    for answer in Bus(1).ask(frame(1, body.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd"))):
        assert answer[:5] == b"\xff\xff\xfd\x00\x01"
        assert len(answer) == 7 + int.from_bytes(answer[5:7], "little")
        assert crc(answer[:-2]) == int.from_bytes(answer[-2:], "little")
