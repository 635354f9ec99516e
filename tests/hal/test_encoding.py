"""Sign and magnitude, in which Feetech's servos count, low byte first (STS) or high byte first (SCS)."""

from collections.abc import Callable, Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scservo_sdk import SCS_TOHOST, SCS_TOSCS

from hal.encoding import column, decoder, pack, unpack
from hal.register_map import Block, Register
from robotwalk.assembly import load_servo

STS, SCS = load_servo("sts3215"), load_servo("scs15")

SIGNED = [row.name for row in STS.registers if row.sign_bit is not None]
WORDS = [row.name for row in SCS.registers if row.size == 2]


@pytest.mark.parametrize(
    ("name", "value", "data"),
    [
        ("goal_position", 2048, "00 08"),
        ("goal_position", -100, "64 80"),
        ("goal_position", -1, "01 80"),
        ("goal_position", 30719, "FF 77"),
        ("goal_position", -30719, "FF F7"),
        ("present_velocity", -3400, "48 8D"),
        ("present_load", 500, "F4 01"),
        ("present_load", -500, "F4 05"),
        ("goal_pwm", -1000, "E8 07"),
        ("position_offset", -85, "55 08"),
        ("position_offset", 2047, "FF 07"),
        ("position_offset", -2047, "FF 0F"),
        ("present_current", -1, "01 80"),
    ],
)
def test_bytes_on_the_wire(name: str, value: int, data: str) -> None:
    assert pack(STS[name], value) == bytes.fromhex(data)
    assert unpack(STS[name], bytes.fromhex(data)) == value


@pytest.mark.parametrize(
    ("name", "value", "data"),
    [
        ("goal_position", 700, "02 BC"),
        ("goal_position", 1023, "03 FF"),
        ("goal_time", 1124, "04 64"),  # with both limits 0 a PWM of -100
        ("goal_velocity", 1500, "05 DC"),
        ("goal_velocity", -100, "80 64"),
        ("present_velocity", -1, "80 01"),
        ("present_load", 500, "01 F4"),
        ("present_load", -500, "05 F4"),
        ("model_number", 1295, "05 0F"),
        ("lock", 1, "01"),
    ],
)
def test_bytes_on_the_wire_of_an_scs_servo(name: str, value: int, data: str) -> None:
    assert pack(SCS[name], value) == bytes.fromhex(data)
    assert unpack(SCS[name], bytes.fromhex(data)) == value


@given(st.sampled_from(WORDS), st.integers(0, 1023), st.booleans())
def test_a_word_of_an_scs_servo_is_an_sts_servo_s_turned_round(name: str, magnitude: int, negative: bool) -> None:
    register = SCS[name]
    value = -magnitude if negative and register.sign_bit is not None else magnitude
    data = pack(register, value)
    assert unpack(register, data) == value
    turned = register.model_copy(update={"byte_order": "little"})
    assert pack(turned, value) == data[::-1]
    word = value if register.sign_bit is None else SCS_TOSCS(value, register.sign_bit)
    assert data == word.to_bytes(2, "big")


@pytest.mark.parametrize("name", SIGNED)
def test_minus_zero_is_zero(name: str) -> None:
    sign_bit = STS[name].sign_bit
    assert sign_bit is not None
    assert unpack(STS[name], (1 << sign_bit).to_bytes(2, "little")) == 0


@pytest.mark.parametrize(
    ("name", "largest"),
    [("goal_position", 32767), ("present_velocity", 32767), ("present_load", 1023), ("position_offset", 2047)],
)
def test_what_does_not_fit_beside_the_sign_is_refused(name: str, largest: int) -> None:
    for value in (largest, -largest):
        assert unpack(STS[name], pack(STS[name], value)) == value
    for value in (largest + 1, -largest - 1):
        with pytest.raises(ValueError, match=f"^{name}: {value} does not fit beside its sign in bit "):
            pack(STS[name], value)


@given(st.sampled_from(SIGNED), st.integers(-1023, 1023))
def test_every_value_comes_back_and_is_what_the_sdks_own_helper_makes_of_it(name: str, value: int) -> None:
    register = STS[name]
    data = pack(register, value)
    assert unpack(register, data) == value
    assert int.from_bytes(data, "little") == SCS_TOSCS(value, register.sign_bit)
    assert SCS_TOHOST(int.from_bytes(data, "little"), register.sign_bit) == value


def test_the_newer_sdks_two_s_complement_would_be_a_far_goal() -> None:
    """ftservo-python-sdk 2.0.1 sends 9C FF for -100: to the servo that is eight turns away."""
    assert unpack(STS["goal_position"], b"\x9c\xff") == -32668
    assert pack(STS["goal_position"], -100) == (0x8064).to_bytes(2, "little")


def block_decoder(block: Block) -> Callable[[bytes], Sequence[int]]:
    return decoder([(register, register.address - block.address) for register in block.registers])


class TestBlock:
    def test_the_cyclic_read(self) -> None:
        assert (STS.feedback.address, STS.feedback.size) == (56, 6)
        decode = block_decoder(STS.feedback)
        # Half a turn past the centre, backwards at 1 rev/s, pulling with a quarter of the output the other way.
        assert decode(bytes.fromhex("00 10  00 90  FA 04")) == [4096, -4096, -250]

    def test_holes_are_skipped(self) -> None:
        block = Block(tuple(STS[name] for name in ("present_position", "present_temperature", "present_current")))
        assert (block.address, block.size) == (56, 15)
        decode = block_decoder(block)
        data = bytes.fromhex("64 80 11 22 33 44 55 1E 77 88 99 AA BB 05 80")
        assert decode(data) == [-100, 30, -5]

    @given(st.integers(-32767, 32767), st.integers(-32767, 32767), st.integers(-1023, 1023))
    def test_a_block_holds_what_its_registers_hold(self, position: int, velocity: int, load: int) -> None:
        names = ("present_position", "present_velocity", "present_load")
        values = [position, velocity, load]
        data = b"".join(pack(STS[name], value) for name, value in zip(names, values, strict=True))
        assert block_decoder(STS.feedback)(data) == values

    @given(st.integers(0, 1023), st.integers(-32767, 32767), st.integers(-1023, 1023))
    def test_so_does_one_with_the_high_byte_first(self, position: int, velocity: int, load: int) -> None:
        names = ("present_position", "present_velocity", "present_load")
        values = [position, velocity, load]
        data = b"".join(pack(SCS[name], value) for name, value in zip(names, values, strict=True))
        assert block_decoder(SCS.feedback)(data) == values


REGISTERS = [load_servo(name)["goal_position"] for name in ("xl430-w250", "ax-12a", "sts3215", "scs15")]


@given(st.sampled_from(REGISTERS), st.lists(st.integers(-(2**33), 2**33) | st.integers(-3000, 3000), min_size=1))
def test_a_column_of_goals_is_packed_as_each_alone(register: Register, values: list[int]) -> None:
    ids = list(range(1, len(values) + 1))
    try:
        alone = b"".join(bytes((i,)) + pack(register, value) for i, value in zip(ids, values, strict=True))
    except ValueError:
        with pytest.raises(ValueError, match=r"^goal_position: "):
            column(register, ids)(values)
        return
    assert column(register, ids)(values) == alone
