"""The control table of one servo: its bytes, and its registers by name. The rules of access are each brand's."""

import itertools
import struct
from collections.abc import Sequence

from hal.register_map import Memory, Register, ServoModel


class ControlTable:
    """The bytes of one servo. `table[name]` is the firmware's own access and obeys no rules."""

    def __init__(self, model: ServoModel) -> None:
        self.data = bytearray(max(register.end for register in model.registers))
        self._registers = model.registers
        self._places = {r.name: (r.address, r.end, r.byte_order, r.signed, _sign(r)) for r in model.registers}
        self.restore_defaults(Memory.EEPROM)
        self.restore_defaults(Memory.RAM)

    def __getitem__(self, name: str) -> int:
        return self.decode(name, self.data)

    def __setitem__(self, name: str, value: int) -> None:
        address, end, byte_order, signed, sign = self._places[name]
        if sign and value < 0:
            value = -value | sign
        self.data[address:end] = value.to_bytes(end - address, byte_order, signed=signed)

    def decode(self, name: str, image: bytearray) -> int:
        """Return what a register would hold if the table's bytes were those of `image`."""
        address, end, byte_order, signed, sign = self._places[name]
        value = int.from_bytes(image[address:end], byte_order, signed=signed)
        return sign - value if value & sign else value

    def assign(self, register: Register, value: int) -> None:
        """Set a register as its user does, once the value is known to be allowed."""
        self[register.name] = value

    def restore_defaults(self, memory: Memory) -> None:
        """Set all registers of one memory as the factory does; those without a default become 0."""
        for register in self._registers:
            if register.memory is memory:
                self[register.name] = register.default or 0


class Window:
    """Registers side by side that the firmware sets all at once, and often."""

    def __init__(self, model: ServoModel, names: Sequence[str]) -> None:
        """Open a window on registers, by address.

        Raises:
            ValueError: they do not lie side by side.
        """
        rows = [model[name] for name in names]
        if any(before.end != after.address for before, after in itertools.pairwise(rows)):
            raise ValueError(f"{model.name}: {', '.join(names)} do not lie side by side")
        letters = {1: "B", 2: "H", 4: "I"}
        layout = "".join(letters[row.size].lower() if row.signed else letters[row.size] for row in rows)
        self._struct = struct.Struct(("<" if rows[0].byte_order == "little" else ">") + layout)
        self._address = rows[0].address
        self._signs = [_sign(row) for row in rows]
        self._plain = not any(self._signs)

    def store(self, table: ControlTable, values: Sequence[int]) -> None:
        """Set the registers, in their order."""
        if not self._plain:
            values = [
                -value | sign if sign and value < 0 else value
                for value, sign in zip(values, self._signs, strict=True)]
        self._struct.pack_into(table.data, self._address, *values)


def _sign(register: Register) -> int:
    """Return the bit of the sign, where the others are the magnitude; 0 where there is none."""
    return 0 if register.sign_bit is None else 1 << register.sign_bit
