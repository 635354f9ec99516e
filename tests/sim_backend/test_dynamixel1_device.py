"""The simulated AX-12A seen from the wire, byte by byte."""

import pytest

from .ax_bus import AxBus

PING, READ, WRITE, REG_WRITE, ACTION, FACTORY_RESET, REBOOT = 1, 2, 3, 4, 5, 6, 8
SYNC_READ, SYNC_WRITE, BULK_READ = 0x82, 0x83, 0x92
OK = bytes.fromhex("FF FF 01 02 00 FC")
RANGE, CHECKSUM, INSTRUCTION = 0x08, 0x10, 0x40


def error_of(answer: bytes) -> int:
    assert len(answer) == 6, "a refusal has no data"
    return answer[4]


class TestInstructions:
    def test_ping(self) -> None:
        assert AxBus(1).raw(bytes.fromhex("FF FF 01 02 01 FB")) == OK

    def test_ping_of_another_id_is_not_answered(self) -> None:
        assert AxBus(1).send(2, PING) == b""

    def test_read_of_the_temperature(self) -> None:
        bus = AxBus(1, firmware={"temperature_c": 32})
        assert bus.raw(bytes.fromhex("FF FF 01 04 02 2B 01 CC")) == bytes.fromhex("FF FF 01 03 00 20 DB")

    def test_read_of_model_firmware_id_and_baud_rate(self) -> None:
        assert AxBus(1).read(1, 0, 5) == bytes((12, 0, 24, 1, 1))

    def test_write(self) -> None:
        bus = AxBus(1)
        assert bus.send(1, WRITE, 25, 1) == OK
        assert bus.read(1, 25, 1) == b"\x01"

    def test_a_registered_write_waits_for_the_action(self) -> None:
        bus = AxBus(1)
        assert bus.raw(bytes.fromhex("FF FF 01 05 04 1E F4 01 E2")) == OK
        assert (bus.read(1, 44, 1), bus.word(30)) == (b"\x01", 512)
        assert bus.send(1, ACTION) == OK
        assert (bus.read(1, 44, 1), bus.word(30)) == (b"\x00", 500)

    def test_a_broadcast_action_lets_all_go_at_once_and_nobody_answers(self) -> None:
        bus = AxBus(1, 2)
        bus.send(1, REG_WRITE, 25, 1)
        bus.send(2, REG_WRITE, 25, 1)
        assert bus.raw(bytes.fromhex("FF FF FE 02 05 FA")) == b""
        assert bus.read(1, 25, 1) == bus.read(2, 25, 1) == b"\x01"

    def test_a_broadcast_write_reaches_all_and_nobody_answers(self) -> None:
        bus = AxBus(1, 2)
        assert bus.send(254, WRITE, 25, 1) == b""
        assert bus.read(1, 25, 1) == bus.read(2, 25, 1) == b"\x01"

    def test_a_sync_write_gives_each_its_own(self) -> None:
        bus = AxBus(0, 1)
        frame = bytes.fromhex("FF FF FE 0E 83 1E 04 00 10 00 50 01 01 20 02 60 03 67")
        assert bus.raw(frame) == b""
        assert bus.read(0, 30, 4) == bytes.fromhex("10 00 50 01")
        assert bus.read(1, 30, 4) == bytes.fromhex("20 02 60 03")

    def test_a_sync_write_that_does_not_come_out_even_does_nothing(self) -> None:
        bus = AxBus(1)
        assert bus.send(254, SYNC_WRITE, 25, 1, 1) == b""
        assert bus.read(1, 25, 1) == b"\x00"

    def test_a_factory_reset_brings_back_id_1_and_1_mbaud(self) -> None:
        bus = AxBus(9, baud_rate=3, return_delay_time=0)
        bus.baud = 500_000
        assert bus.send(9, FACTORY_RESET) == bytes.fromhex("FF FF 09 02 00 F4")
        bus.run(0.4)
        bus.baud = 1_000_000
        assert bus.read(1, 0, 6) == bytes((12, 0, 24, 1, 1, 250))


class TestSilence:
    @pytest.mark.parametrize("instruction", [PING, READ, SYNC_READ, BULK_READ, REBOOT])
    def test_a_broadcast_is_not_answered(self, instruction: int) -> None:
        assert AxBus(1, 2).send(254, instruction, 0, 2, 1, 36) == b""

    def test_at_another_baud_rate(self) -> None:
        bus = AxBus(1)
        bus.baud = 500_000
        assert bus.send(1, PING) == b""

    def test_while_it_starts(self) -> None:
        bus = AxBus(1)
        bus.send(1, FACTORY_RESET)
        bus.run(0.2)
        assert bus.send(1, PING) == b""

    @pytest.mark.parametrize(
        ("level", "read_answers", "write_answers"), [(0, False, False), (1, True, False), (2, True, True)])
    def test_the_status_return_level_outlives_power(self, level: int, read_answers: bool, write_answers: bool) -> None:
        bus = AxBus(1)
        bus.send(1, WRITE, 16, level)
        bus.servos[0].reboot(bus.now)
        bus.run(0.4)
        assert bus.send(1, PING) == OK
        assert bool(bus.send(1, READ, 0, 2)) == read_answers
        assert bool(bus.send(1, WRITE, 25, 1)) == write_answers
        assert bool(bus.send(1, 0x77)) == write_answers
        assert bool(bus.raw(bytes.fromhex("FF FF 01 02 01 00"))) == write_answers

    def test_two_with_one_id_garble_each_other(self) -> None:
        bus = AxBus(1, 1)
        answer = bus.send(1, PING)
        assert answer
        assert answer != OK

    def test_the_return_delay(self) -> None:
        bus = AxBus(1, return_delay_time=250)
        [reply] = bus.device.receive(bytes.fromhex("FF FF 01 02 01 FB"), bus.now + 5_000_000, 1_000_000)
        assert reply.delay_ns == 500_000


class TestRefusals:
    """Bits of the error byte: e-Manual, Protocol 1.0, status packet."""

    @pytest.mark.parametrize("instruction", [0x00, REBOOT, 0x0A, 0x55, SYNC_READ, BULK_READ])
    def test_an_unknown_instruction(self, instruction: int) -> None:
        assert error_of(AxBus(1).send(1, instruction, 0, 2, 1, 36)) == INSTRUCTION

    def test_an_action_without_anything_registered(self) -> None:
        assert error_of(AxBus(1).send(1, ACTION)) == INSTRUCTION

    def test_a_garbled_instruction(self) -> None:
        assert AxBus(1).raw(bytes.fromhex("FF FF 01 02 01 FC")) == bytes.fromhex("FF FF 01 02 10 EC")

    def test_a_garbled_instruction_does_nothing(self) -> None:
        bus = AxBus(1)
        assert error_of(bus.raw(bytes.fromhex("FF FF 01 04 03 19 01 DC"))) == CHECKSUM
        assert bus.read(1, 25, 1) == b"\x00"

    @pytest.mark.parametrize(("address", "length"), [(50, 1), (49, 2), (0, 51), (255, 1), (36, 0)])
    def test_reading_beyond_the_table(self, address: int, length: int) -> None:
        assert error_of(AxBus(1).send(1, READ, address, length)) == RANGE

    def test_the_whole_table_can_be_read(self) -> None:
        assert len(AxBus(1).read(1, 0, 50)) == 50

    @pytest.mark.parametrize(
        "parameters",
        [
            (0, 13, 0),  # model number: read-only
            (36, 0, 2),  # present position: read-only
            (49, 0, 0),  # over the end
            (3, 254),  # id
            (4, 2),  # baud rate that has no name
            (16, 3),  # status return level
            (24, 2),  # torque enable
            (30, 0, 4),  # goal 1024
            (34, 0, 4),  # torque limit 1024
            (32, 1, 4),  # moving speed -1, in joint mode
            (48, 31, 0),  # punch
            (30, 0, 2, 1, 4),  # a good goal, and a moving speed that is none
        ],
    )
    def test_writing_what_does_not_go(self, parameters: tuple[int, ...]) -> None:
        bus = AxBus(1)
        before = bus.read(1, 0, 36)
        assert error_of(bus.send(1, WRITE, *parameters)) == RANGE
        assert error_of(bus.send(1, REG_WRITE, *parameters)) == RANGE
        assert bus.read(1, 0, 36) == before
        assert bus.read(1, 44, 1) == b"\x00", "nothing is registered"

    @pytest.mark.parametrize(("goal", "error"), [(399, 2), (400, 0), (600, 0), (601, 2)])
    def test_a_goal_outside_the_angle_limits(self, goal: int, error: int) -> None:
        bus = AxBus(1, cw_angle_limit=400, ccw_angle_limit=600)
        assert bus.write_word(30, goal) == error
        assert bus.word(30) == (512 if error else goal)


class TestLock:
    def test_it_stays_until_power_is_switched_off(self) -> None:
        bus = AxBus(1)
        assert bus.write(47, 1) == 0
        assert bus.write(47, 0) == RANGE
        assert bus.write(5, 7) == RANGE
        assert bus.read(1, 5, 1) == b"\x00"
        assert bus.write(25, 1) == 0, "RAM is not locked"
        bus.servos[0].reboot(bus.now)
        bus.run(0.4)
        assert bus.write(5, 7) == 0
        assert bus.read(1, 5, 1) == b"\x07"


class TestParser:
    @pytest.mark.parametrize("noise", ["FF", "FF FF FF", "00 FF 12", "FF FF 01 01"])
    def test_noise_before_a_frame(self, noise: str) -> None:
        assert AxBus(1).raw(bytes.fromhex(noise + "FF FF 01 02 01 FB")).endswith(OK)

    def test_a_frame_in_two_pieces(self) -> None:
        bus = AxBus(1)
        frame = bytes.fromhex("FF FF 01 02 01 FB")
        assert bus.device.receive(frame[:3], bus.now + 30_000, 1_000_000) == []
        assert len(bus.device.receive(frame[3:], bus.now + 60_000, 1_000_000)) == 1

    def test_a_frame_with_a_long_pause_is_dropped(self) -> None:
        bus = AxBus(1)
        frame = bytes.fromhex("FF FF 01 02 01 FB")
        assert bus.raw(frame[:3]) + bus.raw(frame[3:]) == b""
