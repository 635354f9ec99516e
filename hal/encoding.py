"""Raw register values <-> bytes: little-endian, two's complement where the register is signed."""

from hal.register_map import Register


def pack(register: Register, value: int) -> bytes:
    """Return the bytes that hold `value` (counts). Raises ValueError if it does not fit."""
    try:
        return value.to_bytes(register.size, "little", signed=register.signed)
    except OverflowError:
        kind = "signed" if register.signed else "unsigned"
        text = f"{register.name}: {value} does not fit into {8 * register.size} bits, {kind}"
        raise ValueError(text) from None


def unpack(register: Register, data: bytes) -> int:
    """Return the value (counts) that `data` holds. Raises ValueError if its length is not the register's."""
    if len(data) != register.size:
        raise ValueError(f"{register.name}: expected {register.size} bytes, got {len(data)}")
    return int.from_bytes(data, "little", signed=register.signed)
