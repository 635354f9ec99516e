"""Raw register values <-> bytes, in the register's byte order; two's complement or sign and magnitude where signed."""

from collections.abc import Callable, Iterator, Sequence
from struct import Struct, error

from hal.register_map import Register

_FORMATS = {1: "B", 2: "H", 4: "I"}


def pack(register: Register, value: int) -> bytes:
    """Return the bytes that hold `value` (counts). Raises ValueError if it does not fit."""
    if register.sign_bit is not None:
        sign = 1 << register.sign_bit
        if abs(value) >= sign:
            raise ValueError(f"{register.name}: {value} does not fit beside its sign in bit {register.sign_bit}")
        return (-value | sign if value < 0 else value).to_bytes(register.size, register.byte_order)
    try:
        return value.to_bytes(register.size, register.byte_order, signed=register.signed)
    except OverflowError:
        kind = "signed" if register.signed else "unsigned"
        raise ValueError(f"{register.name}: {value} does not fit into {8 * register.size} bits, {kind}") from None


def unpack(register: Register, data: bytes) -> int:
    """Return the value (counts) that `data` holds. Raises ValueError if its length is not the register's."""
    if len(data) != register.size:
        raise ValueError(f"{register.name}: expected {register.size} bytes, got {len(data)}")
    value = int.from_bytes(data, register.byte_order, signed=register.signed)
    return value if register.sign_bit is None else _from_magnitude(value, register.sign_bit)


def column(register: Register, ids: Sequence[int]) -> Callable[[Sequence[int]], bytes]:
    """Return what packs a value (counts) of each servo, with its id before it, as a sync write wants them.

    It raises ValueError where one does not fit.
    """
    order = "<" if register.byte_order == "little" else ">"
    letter = _FORMATS[register.size]
    sign = 0 if register.sign_bit is None else 1 << register.sign_bit
    layout = Struct(order + ("B" + (letter.lower() if register.signed else letter)) * len(ids))
    fields = [0] * (2 * len(ids))
    fields[::2] = ids

    def pack_all(values: Sequence[int]) -> bytes:
        if sign:
            if max(map(abs, values)) >= sign:
                raise ValueError(f"{register.name}: one of {list(values)} leaves no room for its sign")
            values = [value if value >= 0 else sign - value for value in values]
        fields[1::2] = values
        try:
            return layout.pack(*fields)
        except error as cause:
            raise ValueError(f"{register.name}: {cause}; got {list(values)}") from None

    return pack_all


def decoder(fields: Sequence[tuple[Register, int]]) -> Callable[[bytes], Sequence[int]]:
    """Return what decodes registers that lie at these offsets of the bytes, in that order, all at once."""
    order = "<" if fields[0][0].byte_order == "little" else ">"
    unpack = Struct(order + "".join(_formats(fields))).unpack_from
    magnitudes = [
        (index, register.sign_bit) for index, (register, _) in enumerate(fields) if register.sign_bit is not None]
    if not magnitudes:
        return unpack

    def decode(data: bytes) -> Sequence[int]:
        values = list(unpack(data))
        for index, sign_bit in magnitudes:
            if values[index] >> sign_bit & 1:
                values[index] = _from_magnitude(values[index], sign_bit)
        return values

    return decode


def _from_magnitude(value: int, sign_bit: int) -> int:
    sign = 1 << sign_bit
    return -(value & ~sign) if value & sign else value


def _formats(fields: Sequence[tuple[Register, int]]) -> Iterator[str]:
    """Return the format of each register, with pad bytes where they do not adjoin."""
    end = 0
    for register, offset in fields:
        letter = _FORMATS[register.size]
        yield f"{offset - end}x" + (letter.lower() if register.signed else letter)
        end = offset + register.size
