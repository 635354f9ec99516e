"""Registers by name on either brand: what is written, what stays, and what is said when a servo will not."""

import pytest

from robotwalk.errors import BusError, ServoError, UsageError
from sim_backend.device import Reply

from .rig import BAUD_57600, MEGABAUD, MS, rig

BRANDS = pytest.mark.parametrize("name", ["xl430-w250", "sts3215"])
MAX_VOLTAGE = {"xl430-w250": 32, "sts3215": 14}  # addresses
LOCK = 55


@BRANDS
def test_a_register_is_read_by_its_name(name: str) -> None:
    servo = rig(name, 3).bench.servo(3)
    assert servo.read("present_position") == 2048
    assert servo.read("id") == 3


@BRANDS
def test_all_registers_are_read_in_a_few_reads(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    built.device.heard.clear()
    values = servo.read_all(servo.model.registers)
    assert list(values) == [register.name for register in servo.model.registers]
    assert values["present_position"] == 2048
    assert values["baud_rate"] == MEGABAUD[name]
    assert len(built.device.heard) < 20


def test_a_register_that_the_firmware_lacks_is_none_and_its_neighbours_are_read() -> None:
    built = rig("xl430-w250", 3)
    whole = built.device.device.receive

    def lacking(sent: bytes, now: int, baud: int) -> list[Reply]:
        """Refuse, as an older firmware does, a read that touches address 12."""
        if sent[7] == 2 and sent[8] <= 12 < sent[8] + sent[10]:
            return [Reply(0, bytes.fromhex("FF FF FD 00 03 04 00 55 07 43 0C"))]
        return whole(sent, now, baud)

    built.device.device.receive = lacking
    servo = built.bench.servo(3)
    values = servo.read_all([servo.model[name] for name in ("operating_mode", "secondary_id", "protocol_type")])
    assert values == {"operating_mode": 3, "secondary_id": None, "protocol_type": 2}


@BRANDS
def test_the_eeprom_keeps_what_is_written_over_a_restart(name: str) -> None:
    built = rig(name, 3)
    change = built.bench.servo(3).write("max_voltage_limit", 75)
    assert (change.before, change.after) == ({"xl430-w250": 140, "sts3215": 80}[name], 75)
    built.servos[0].reboot(built.clock.now())
    assert built.servos[0].table["max_voltage_limit"] == 75


def test_the_lock_is_open_while_the_eeprom_is_written_and_shut_afterwards() -> None:
    built = rig("sts3215", 3)
    built.bench.servo(3).write("max_voltage_limit", 75)
    assert built.writes_to(LOCK) == [b"\x00", b"\x01"]
    assert built.servos[0].table["lock"] == 1


def test_the_lock_is_shut_though_the_write_fails() -> None:
    built = rig("sts3215", 3)
    servo = built.bench.servo(3)
    built.servos[0].table.write, table_write = (
        lambda address, data: table_write(address, data) if address == LOCK else set(), built.servos[0].table.write)
    with pytest.raises(ServoError, match=r"^id 3 \(sts3215\) did not take max_voltage_limit = 7\.5 V: .* as 8 V$"):
        servo.write("max_voltage_limit", 75)
    assert built.servos[0].table["lock"] == 1


@BRANDS
def test_what_the_eeprom_holds_is_not_written_again(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    servo.write("max_voltage_limit", 75)
    change = servo.write("max_voltage_limit", 75)
    assert not change.changed
    assert len(built.writes_to(MAX_VOLTAGE[name])) == 1


def test_a_dynamixel_with_torque_on_says_so_and_keeps_it_on() -> None:
    built = rig("xl430-w250", 3)
    servo = built.bench.servo(3)
    servo.write("torque_enable", 1)
    with pytest.raises(ServoError, match="in the EEPROM and torque is on: switch it off first, with `robotwalk servo"):
        servo.write("max_voltage_limit", 75)
    assert built.servos[0].table["torque_enable"] == 1
    assert built.servos[0].table["max_voltage_limit"] == 140


def test_why_a_dynamixel_refuses_is_told() -> None:
    servo = rig("xl430-w250", 3).bench.servo(3)
    with pytest.raises(ServoError, match=r"^id 3 refuses: the value is outside the limits .*goal_position"):
        servo.write("goal_position", 5000)


@BRANDS
def test_what_is_read_only_or_out_of_range_never_reaches_the_line(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    built.device.heard.clear()
    for register, value in (("present_position", 5), ("max_voltage_limit", 9999)):
        with pytest.raises(UsageError):
            servo.write(register, value)
    assert built.device.heard == []


@BRANDS
def test_a_servo_that_acknowledges_nothing_is_written_all_the_same(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    servo.write("status_return_level", {"xl430-w250": 1, "sts3215": 0}[name])
    assert servo.write("max_voltage_limit", 75).after == 75


@BRANDS
def test_a_new_id_is_followed(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    servo.write("id", 9)
    assert servo.id == 9
    assert built.bench.ping(9).identity.id == 9
    if "lock" in servo.model.by_name:
        assert servo.read("lock") == 1


@BRANDS
def test_an_id_that_another_servo_has_is_refused(name: str) -> None:
    built = rig(name, 3, 9)
    with pytest.raises(ServoError, match="id 9 is taken"):
        built.bench.servo(3).write("id", 9)
    assert [servo.table["id"] for servo in built.servos] == [3, 9]


@BRANDS
def test_a_new_baud_rate_is_followed(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    servo.write("baud_rate", BAUD_57600[name])
    assert built.port.baud == 57600
    assert servo.read("present_position") == 2048


@BRANDS
def test_one_garbled_answer_is_asked_for_again(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    garbled: list[bytes] = []

    def once(sent: bytes, replies: list[Reply]) -> list[Reply]:
        garbled.append(sent)
        return replies if len(garbled) > 1 else [Reply(0, replies[0].data[:-1] + b"\x00")]

    built.device.tamper = once
    assert servo.read("present_position") == 2048


@BRANDS
def test_an_answer_that_came_too_late_is_not_taken_for_the_next_one(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    row = servo.model["id"]
    built.port.write(servo.dialogue.protocol.read(3, row.address, row.size))
    built.clock.wait((), built.clock.now() + 10 * MS)
    assert built.port.waiting() > 0
    assert servo.read("baud_rate") == MEGABAUD[name]
    assert servo.read("torque_enable") == 0


@BRANDS
@pytest.mark.parametrize("answer", [
    b"\x00" * 40, b"\xff\xff\xfd\x00\x03\xff\x03", b"\xff\xff\x03\xfa\x00", b"\xff" * 99])
def test_garbage_is_told_and_ends_soon(name: str, answer: bytes) -> None:
    built = rig(name, 3)
    built.device.tamper = lambda sent, replies: [Reply(0, answer)] if replies else []
    with pytest.raises(BusError, match="garbled: two servos with one id, a loose cable, or a wrong baud rate"):
        built.bench.servo(3)
    assert built.clock.now() < 500 * MS


@BRANDS
def test_two_servos_with_one_id_are_not_worked_on(name: str) -> None:
    built = rig(name, 3)
    built.device.tamper = lambda sent, replies: replies * 2
    with pytest.raises(BusError, match="two servos with one id"):
        built.bench.servo(3)


@BRANDS
def test_silence_names_the_id_and_the_baud_rate(name: str) -> None:
    built = rig(name, 3, baud_rate=BAUD_57600[name])
    with pytest.raises(BusError, match="no servo answers as id 3 at 1000000 baud; `robotwalk servo scan` tries all"):
        built.bench.servo(3)


def test_an_unknown_model_is_not_worked_on() -> None:
    built = rig("xl430-w250", 3)
    built.servos[0].table["model_number"] = 4242
    with pytest.raises(BusError, match=r"id 3 is of model 4242, which no servo file .* xl430-w250 \(1060\)"):
        built.bench.servo(3)


@pytest.mark.parametrize(("name", "bit", "words"), [
    ("xl430-w250", 0x24, ["overheating", "overload"]), ("sts3215", 0x21, ["voltage", "overload"])])
def test_hardware_errors_in_words(name: str, bit: int, words: list[str]) -> None:
    built = rig(name, 3)
    built.servos[0].table["hardware_error_status"] = bit
    assert built.bench.servo(3).faults() == words
