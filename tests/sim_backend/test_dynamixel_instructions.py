"""Clear, control table backup, bulk reads and writes; what depends on the firmware's version; the switches."""

import pytest

from hal.register_map import ServoModel
from robotwalk.assembly import load_servo
from sim_backend.device import Reply

from .dynamixel_bus import MODEL, MS, Bus, frame, read, status, write

CLEAR = bytes.fromhex("FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC")
STORE = bytes.fromhex("FF FF FD 00 01 08 00 20 01 43 54 52 4C 16 F5")
RESTORE = bytes.fromhex("FF FF FD 00 01 08 00 20 02 43 54 52 4C 9E F5")
BULK_READ = bytes.fromhex("FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05")
BULK_WRITE = bytes.fromhex("FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68")
FAST_BULK_READ = bytes.fromhex("FF FF FD 00 FE 12 00 9A 03 84 00 04 00 07 7C 00 02 00 04 92 00 01 00 DA 2D")
FAST_BULK_STATUS = bytes.fromhex(
    "FF FF FD 00 FE 14 00 55  00 03 A6 00 00 00 67 A4  00 07 A5 01 24 74  00 04 1F D9 C1")
DONE, FAILED = [status(1, 0)], [status(1, 1)]


def switched(**switches: object) -> ServoModel:
    return MODEL.model_copy(update={"firmware": MODEL.firmware.model_copy(update=switches)})


def position(bus: Bus) -> int:
    [answer] = bus.ask(read(1, 132, 4))
    return int.from_bytes(answer[9:13], "little", signed=True)


class TestClear:
    def test_takes_whole_turns_off_and_holds_there(self) -> None:
        bus = Bus(1, operating_mode=4)
        bus.place(3 * 4096 + 100)
        assert bus.ask(write(1, 64, b"\1")) == DONE
        assert position(bus) == 3 * 4096 + 100
        assert bus.ask(CLEAR) == DONE
        bus.place(3 * 4096 + 100)
        assert position(bus) == 100
        assert bus.ask(read(1, 116, 4)) == [status(1, 0, b"\x64\0\0\0")]
        assert bus.physics.torque[0] == 0.0

    def test_fails_while_the_shaft_moves(self) -> None:
        bus = Bus(1, operating_mode=4)
        for address, data in ((64, b"\1"), (112, b"\x0a\0\0\0"), (116, b"\0\x10\0\0")):
            assert bus.ask(write(1, address, data)) == DONE
        assert bus.ask(CLEAR) == FAILED

    @pytest.mark.parametrize(("body", "number"), [(b"\x10\1DXL\x23", 4), (b"\x10\2DXL\x22", 4), (b"\x10\1", 5)])
    def test_wants_its_key(self, body: bytes, number: int) -> None:
        assert Bus(1).ask(frame(1, body)) == [status(1, number)]


class TestBackup:
    def test_is_restored_with_a_restart(self) -> None:
        bus = Bus(1)
        bus.ask(write(1, 84, b"\x20\3"))  # P gain, RAM
        bus.ask(write(1, 48, b"\0\x08\0\0"))  # largest position, EEPROM
        bus.ask(write(1, 168, b"\x84\0"))  # an indirect address
        assert bus.ask(read(1, 147, 1)) == [status(1, 0, b"\0")]
        assert bus.ask(STORE) == DONE
        assert bus.ask(read(1, 147, 1)) == [status(1, 0, b"\1")]
        bus.ask(write(1, 84, b"\1\0"))
        bus.ask(write(1, 48, b"\1\0\0\0"))
        assert bus.ask(RESTORE) == DONE
        assert bus.ask(read(1, 147, 1)) == [], "it starts afresh"
        bus.pass_time(301)
        for address, data in ((84, b"\x20\3"), (48, b"\0\x08\0\0"), (168, b"\x84\0"), (147, b"\1"), (64, b"\0")):
            assert bus.ask(read(1, address, len(data))) == [status(1, 0, data)]

    def test_is_refused_with_torque_on_and_restored_only_if_there_is_one(self) -> None:
        bus = Bus(1)
        assert bus.ask(RESTORE) == FAILED
        bus.ask(STORE)
        bus.ask(write(1, 64, b"\1"))
        assert bus.ask(STORE) == FAILED
        assert bus.ask(RESTORE) == FAILED

    def test_comes_back_at_every_start_if_so_configured(self) -> None:
        bus = Bus(1, startup_configuration=2)
        bus.ask(write(1, 84, b"\x20\3"))
        bus.ask(STORE)
        bus.ask(write(1, 84, b"\1\0"))
        bus.ask(frame(1, b"\x08"))
        bus.pass_time(301)
        assert bus.ask(read(1, 84, 2)) == [status(1, 0, b"\x20\3")]

    @pytest.mark.parametrize(("body", "number"), [(b"\x20\3CTRL", 4), (b"\x20\1CTRM", 4), (b"\x20", 5)])
    def test_wants_its_key(self, body: bytes, number: int) -> None:
        assert Bus(1).ask(frame(1, body)) == [status(1, number)]

    def test_is_unknown_to_older_firmware_and_to_the_mx(self) -> None:
        assert Bus(1, firmware_version=44).ask(STORE) == [status(1, 2)]
        assert Bus(1, model=load_servo("mx-28")).ask(STORE) == [status(1, 2)]


class TestBulk:
    def test_read_is_answered_in_the_listed_order_each_its_own_range(self) -> None:
        bus = Bus(2, 1)
        assert bus.ask(BULK_READ) == [status(1, 0, b"\x6f\0"), status(2, 0, b"\x1e")]

    def test_of_an_id_named_twice_the_first_counts_and_half_an_item_spoils_all(self) -> None:
        item = b"\1\x92\0\1\0"
        assert Bus(1).ask(frame(0xFE, b"\x92" + item + b"\1\x90\0\2\0")) == [status(1, 0, b"\x1e")]
        assert Bus(1).ask(frame(0xFE, b"\x92" + item + b"\1")) == []

    def test_a_silent_servo_silences_those_behind_it(self) -> None:
        items = b"".join(bytes((servo_id, 0x92, 0, 1, 0)) for servo_id in (1, 3, 2))
        assert Bus(1, 2).ask(frame(0xFE, b"\x92" + items)) == [status(1, 0, b"\x1e")]

    def test_write_gives_each_its_own(self) -> None:
        bus = Bus(1, 2, max_voltage_limit=140)
        assert bus.ask(BULK_WRITE) == []  # 160 is beyond this servo's range, and goes unseen
        assert [servo.table["max_voltage_limit"] for servo in bus.servos] == [140, 140]
        assert [servo.table["temperature_limit"] for servo in bus.servos] == [72, 80]

    def test_a_write_that_is_cut_short_reaches_nobody(self) -> None:
        bus = Bus(1)
        assert bus.ask(frame(0xFE, b"\x93\1\x41\0\1\0\1\2\x41\0\2\0\1")) == []
        assert bus.servos[0].table["led"] == 0

    def test_fast_read_is_one_frame_with_running_crcs(self) -> None:
        bus = Bus(3, 7, 4)
        bus.ask(write(7, 84, b"\xa5\1"))  # 421 / 128 of PWM per tick
        bus.ask(write(7, 64, b"\1"))
        bus.ask(write(7, 116, (2048 + 128).to_bytes(4, "little")))
        bus.physics.temperature_c[2] = 31
        bus.place(166, 2048, 2048)
        assert bus.send(FAST_BULK_READ) == [Reply(500_000, FAST_BULK_STATUS)]


class TestFirmwareVersion:
    def test_torque_by_goal_and_startup_configuration_came_with_45(self) -> None:
        assert Bus(1).ask(write(1, 10, b"\x08")) == DONE
        assert Bus(1, firmware_version=44).ask(write(1, 10, b"\x08")) == [status(1, 4)]
        assert Bus(1, firmware_version=44).ask(write(1, 60, b"\1")) == [status(1, 7)]

    @pytest.mark.parametrize(("version", "ids"), [(41, [1, 1]), (42, [3, 4])])
    def test_a_reset_of_all_to_one_id_is_refused_from_42_on(self, version: int, ids: list[int]) -> None:
        bus = Bus(3, 4, firmware_version=version)
        assert bus.ask(frame(0xFE, b"\x06\xff")) == []
        assert [servo.id for servo in bus.servos] == ids

    def test_the_mx_limits_its_profiles_acceleration(self) -> None:
        bus = Bus(1, model=load_servo("mx-28"), acceleration_limit=100)
        assert bus.ask(write(1, 108, b"\x64\0\0\0")) == DONE
        assert bus.ask(write(1, 108, b"\x65\0\0\0")) == [status(1, 6)]

    def test_the_bus_watchdog_came_with_38(self) -> None:
        assert Bus(1, firmware_version=38).ask(write(1, 98, b"\1")) == DONE
        assert Bus(1, firmware_version=37).ask(write(1, 98, b"\1")) == [status(1, 7)]

    @pytest.mark.parametrize(("version", "base"), [(51, 224), (52, 208)])
    def test_indirect_data_of_the_x330(self, version: int, base: int) -> None:
        bus = Bus(1, model=load_servo("xl330-m288"), firmware_version=version)
        assert bus.ask(read(1, 168, 2)) == [status(1, 0, bytes((base, 0)))]
        bus.ask(write(1, 168, b"\x92\0"))
        assert bus.ask(read(1, base, 1)) == [status(1, 0, b"\x1e")]


class TestSecondaryId:
    @pytest.mark.parametrize("number", [253, 254, 255])
    def test_is_off_above_252(self, number: int) -> None:
        assert Bus(1, secondary_id=number).servos[0].secondary_id is None

    def test_writes_the_ram_alone(self) -> None:
        bus = Bus(1, secondary_id=9)
        assert bus.ask(write(9, 65, b"\1")) == bus.ask(write(9, 9, b"\0")) == []
        assert (bus.servos[0].table["led"], bus.servos[0].table["return_delay_time"]) == (1, 250)


class TestSwitches:
    def test_another_protocol_type_makes_it_deaf(self) -> None:
        bus = Bus(1, model=load_servo("xl330-m288"))
        assert bus.ask(write(1, 13, b"\x14")) == DONE
        assert bus.ask(frame(1, b"\1")) == []

    @pytest.mark.parametrize("new", [False, True])
    def test_the_answer_to_a_new_id(self, new: bool) -> None:
        bus = Bus(1, model=switched(answers_at_new_setting=new))
        assert bus.ask(write(1, 7, b"\5")) == [status(5 if new else 1, 0)]

    @pytest.mark.parametrize(("new", "heard"), [(False, True), (True, False)])
    def test_the_answer_to_a_new_baud_rate(self, new: bool, heard: bool) -> None:
        bus = Bus(1, model=switched(answers_at_new_setting=new))
        assert (bus.ask(write(1, 8, b"\2")) == DONE) == heard
        assert bus.send(frame(1, b"\1"), baud=115_200)

    def test_turnaround(self) -> None:
        assert Bus(1, model=switched(turnaround_us=50), return_delay_time=1).send(write(1, 65, b"\1"))[0][0] == 52_000

    @pytest.mark.parametrize("holds", [False, True])
    def test_the_bus_watchdog_holds_or_lets_go(self, holds: bool) -> None:
        bus = Bus(1, model=switched(watchdog_holds=holds))
        bus.ask(write(1, 64, b"\1"))
        bus.ask(write(1, 98, b"\1"))
        bus.pass_time(30)
        assert bus.ask(read(1, 98, 1)) == [status(1, 0, b"\xff")]
        assert bus.ask(read(1, 64, 1)) == [status(1, 0, bytes((holds,)))]

    @pytest.mark.parametrize("forgets", [False, True])
    def test_the_bus_watchdog_of_older_firmware_heads_elsewhere(self, forgets: bool) -> None:
        model = switched(watchdog_forgets_offset=forgets)
        bus = Bus(1, model=model, operating_mode=4, homing_offset=500)
        bus.ask(write(1, 64, b"\1"))
        bus.ask(write(1, 98, b"\1"))
        bus.pass_time(30)
        goal = 2548 - 500 * forgets
        assert bus.ask(read(1, 116, 4)) == [status(1, 0, goal.to_bytes(4, "little"))]

    @pytest.mark.parametrize("shock", [False, True])
    def test_electrical_shock_when_power_comes_back(self, shock: bool) -> None:
        bus = Bus(1, model=switched(shock_at_power_up=shock))
        bus.servos[0].lose_power(bus.now, 0.05)
        bus.pass_time(400)
        assert bus.ask(read(1, 70, 1)) == [status(1, 0x80 * shock, bytes((0x10 * shock,)))]

    def test_a_failing_encoder_is_a_hardware_error(self) -> None:
        bus = Bus(1)
        bus.ask(write(1, 63, b"\x08"))
        bus.ask(write(1, 64, b"\1"))
        bus.servos[0].encoder_fails = True
        bus.pass_time(10)
        assert bus.ask(read(1, 70, 1)) == [status(1, 0x80, b"\x08")]
        assert bus.ask(read(1, 64, 1)) == [status(1, 0x80, b"\0")]


def test_a_factory_reset_forgets_the_limits_of_goals() -> None:
    bus = Bus(1, max_position_limit=1000)
    assert bus.ask(write(1, 116, b"\xd0\7\0\0")) == [status(1, 6)]
    bus.ask(frame(1, b"\x06\x02"))
    bus.now += 400 * MS
    bus.place(2048)
    assert bus.ask(write(1, 116, b"\xd0\7\0\0")) == DONE
