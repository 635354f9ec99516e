import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.register_map import Memory
from robotwalk.assembly import load_servo
from sim_backend.dynamixel_table import DynamixelTable, ErrorNumber, StatusError

MODEL = load_servo("xl430-w250")


@pytest.fixture
def table() -> DynamixelTable:
    table = DynamixelTable(MODEL)
    table["goal_pwm"] = 885
    return table


def write(table: DynamixelTable, address: int, data: bytes) -> None:
    table.store(table.check(address, data))


def refusal(table: DynamixelTable, address: int, data: bytes) -> ErrorNumber:
    before = bytes(table.data)
    with pytest.raises(StatusError) as caught:
        write(table, address, data)
    assert bytes(table.data) == before, "a refused write must change nothing"
    return caught.value.number


def read_refusal(table: DynamixelTable, address: int, length: int) -> ErrorNumber:
    with pytest.raises(StatusError) as caught:
        table.read(address, length)
    return caught.value.number


def test_registers_are_little_endian(table: DynamixelTable) -> None:
    write(table, 116, bytes([0xB8, 0x0B, 0, 0]))
    assert table["goal_position"] == 3000
    assert table.read(116, 4) == bytes([0xB8, 0x0B, 0, 0])


def test_signed_registers_are_twos_complement(table: DynamixelTable) -> None:
    write(table, 104, bytes([0x9C, 0xFF, 0xFF, 0xFF]))
    assert table["goal_velocity"] == -100
    table["present_load"] = -2
    assert table.read(126, 2) == b"\xfe\xff"


def test_a_new_servo_has_the_factory_values(table: DynamixelTable) -> None:
    assert table.read(0, 2) == bytes([0x24, 0x04])  # 1060
    assert table.read(7, 4) == bytes([1, 1, 250, 0])  # id, 57600 baud, 500 us, drive mode
    assert table.read(84, 2) == bytes([0x80, 0x02])  # P gain 640


@pytest.mark.parametrize("hole", [14, 28, 40, 66, 92, 148, 167])
def test_holes_between_registers_read_as_zero(table: DynamixelTable, hole: int) -> None:
    assert table.read(hole, 1) == b"\0"


@pytest.mark.parametrize(("address", "length"), [(251, 1), (0, 252), (578, 1), (661, 1), (578, 84)])
def test_the_whole_of_both_blocks_can_be_read(table: DynamixelTable, address: int, length: int) -> None:
    assert len(table.read(address, length)) == length


@pytest.mark.parametrize(
    ("address", "length"), [(252, 1), (251, 2), (577, 1), (577, 2), (662, 1), (661, 2), (0, 662), (65535, 1)])
def test_reading_outside_the_blocks_is_refused(table: DynamixelTable, address: int, length: int) -> None:
    assert read_refusal(table, address, length) == 7


def test_reading_nothing_is_a_length_error(table: DynamixelTable) -> None:
    assert read_refusal(table, 132, 0) == 5


@pytest.mark.parametrize(
    ("address", "data"), [(116, b"\0\0"), (118, b"\0\0"), (117, b"\0\0\0\0"), (116, bytes(5)), (116, b"")])
def test_part_of_a_register_cannot_be_written(table: DynamixelTable, address: int, data: bytes) -> None:
    assert refusal(table, address, data) == 5


@pytest.mark.parametrize("address", [0, 6, 14, 66, 132, 146, 252, 577, 662, 65535])
def test_read_only_and_undefined_addresses_cannot_be_written(table: DynamixelTable, address: int) -> None:
    size = {0: 2, 132: 4}.get(address, 1)
    assert refusal(table, address, bytes(size)) == 7


def test_eeprom_is_locked_while_torque_is_on(table: DynamixelTable) -> None:
    write(table, 9, b"\0")
    write(table, 64, b"\1")
    assert refusal(table, 9, b"\1") == 7
    write(table, 65, b"\1")  # RAM is not
    write(table, 64, b"\0")
    write(table, 9, b"\1")
    assert table["return_delay_time"] == 1


@pytest.mark.parametrize(
    ("address", "data"),
    [(7, b"\xfd"), (8, b"\x08"), (64, b"\2"), (68, b"\3"), (98, b"\x80"), (84, b"\0\x40"),
     (112, b"\0\x80\0\0"), (36, b"\x76\x03"), (116, b"\0\0\x10\0")])
def test_values_outside_their_range_are_refused(table: DynamixelTable, address: int, data: bytes) -> None:
    assert refusal(table, address, data) == 4


def test_only_four_operating_modes_exist(table: DynamixelTable) -> None:
    for mode in (1, 3, 4, 16):
        write(table, 11, bytes([mode]))
        assert table["operating_mode"] == mode
    for mode in (0, 2, 5, 15, 17, 255):
        assert refusal(table, 11, bytes([mode])) == 4


@pytest.mark.parametrize("undefined_bit", [2, 3, 6, 10])
def test_drive_mode_has_only_its_defined_bits(table: DynamixelTable, undefined_bit: int) -> None:
    assert refusal(table, 10, bytes([undefined_bit])) == 4


def test_a_position_goal_keeps_to_the_limits_in_position_mode_alone(table: DynamixelTable) -> None:
    write(table, 48, (3000).to_bytes(4, "little"))
    write(table, 52, (1000).to_bytes(4, "little"))
    write(table, 116, (1000).to_bytes(4, "little"))
    write(table, 116, (3000).to_bytes(4, "little"))
    assert refusal(table, 116, (999).to_bytes(4, "little")) == 6
    assert refusal(table, 116, (3001).to_bytes(4, "little")) == 6
    write(table, 11, b"\4")
    write(table, 116, (-50_000).to_bytes(4, "little", signed=True))


def test_velocity_and_pwm_goals_keep_to_their_limits_both_ways(table: DynamixelTable) -> None:
    write(table, 104, (-265).to_bytes(4, "little", signed=True))
    assert refusal(table, 104, (266).to_bytes(4, "little")) == 6
    assert refusal(table, 104, (-266).to_bytes(4, "little", signed=True)) == 6
    write(table, 36, (500).to_bytes(2, "little"))
    write(table, 100, (500).to_bytes(2, "little"))
    assert refusal(table, 100, (-501).to_bytes(2, "little", signed=True)) == 6


def test_a_write_of_several_registers_is_done_or_refused_as_a_whole(table: DynamixelTable) -> None:
    speed, position = (50).to_bytes(4, "little"), (2000).to_bytes(4, "little")
    write(table, 108, speed + speed + position)
    assert (table["profile_velocity"], table["goal_position"]) == (50, 2000)
    assert refusal(table, 108, speed + speed + (4096).to_bytes(4, "little")) == 6
    assert refusal(table, 116, position + b"\0\0") == 7  # runs into the read-only tick
    assert refusal(table, 63, b"\0\1\0\0") == 7  # runs into a hole


def test_indirect_data_is_plain_memory_until_it_is_pointed_elsewhere(table: DynamixelTable) -> None:
    write(table, 224, b"\x11\x22")
    assert table.read(224, 2) == b"\x11\x22"


def test_indirect_data_reads_what_it_points_to(table: DynamixelTable) -> None:
    write(table, 168, bytes([0x92, 0, 0x84, 0]))  # 146 temperature, 132 position's low byte
    table["present_temperature"], table["present_position"] = 41, 0x0807
    assert table.read(224, 2) == bytes([41, 0x07])
    assert table.read(223, 2) == bytes([0, 41])  # from outside into the indirect part


def test_indirect_data_writes_what_it_points_to(table: DynamixelTable) -> None:
    write(table, 168, b"".join(address.to_bytes(2, "little") for address in (65, 116, 117, 118, 119)))
    write(table, 224, bytes([1, 0xD2, 0x04, 0, 0]))
    assert (table["led"], table["goal_position"]) == (1, 1234)
    assert refusal(table, 225, bytes([0xD2, 0x04])) == 5  # half a goal
    assert refusal(table, 224, bytes([1, 0, 0x10, 0, 0])) == 6  # a goal of 4096


def test_the_second_indirect_block_works_too(table: DynamixelTable) -> None:
    write(table, 632, (65).to_bytes(2, "little"))
    write(table, 661, b"\1")
    assert table["led"] == 1


def test_an_indirect_pointer_stays_within_ram(table: DynamixelTable) -> None:
    assert refusal(table, 168, (63).to_bytes(2, "little")) == 4
    assert refusal(table, 168, (662).to_bytes(2, "little")) == 4


def test_defaults_come_back_for_one_memory_at_a_time(table: DynamixelTable) -> None:
    table["id"], table["led"], table["position_p_gain"] = 9, 1, 1
    table.restore_defaults(Memory.RAM)
    assert (table["id"], table["led"], table["position_p_gain"]) == (9, 0, 640)


@given(address=st.integers(0, 700), data=st.binary(max_size=12))
def test_any_write_is_done_in_full_or_refused_without_effect(address: int, data: bytes) -> None:
    table = DynamixelTable(MODEL)
    before = bytes(table.data)
    try:
        write(table, address, data)
    except StatusError:
        assert bytes(table.data) == before
    else:
        assert bytes(table.data) == before[:address] + data + before[address + len(data):]
