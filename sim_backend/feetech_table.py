"""The control table of a Feetech servo: the rules of reading and writing it.

The protocol has no code for a write that is refused: its status says that a write came, not what came of it.
What manuals leave open is decided here, in one place:

- A register written with a value outside its range keeps its old one, unnoticed; what else was written counts.
- A part of a register may be written: the table is a memory of bytes.
- What is read-only, and what lies between and behind the registers, is passed over; where nothing is, 0 is read.
"""

from hal.register_map import Access, Memory, Register, ServoModel
from sim_backend.control_table import ControlTable


class FeetechTable(ControlTable):
    """The bytes of one servo, as far as its user may reach them."""

    def __init__(self, model: ServoModel) -> None:
        super().__init__(model)
        self._by_byte = {
            at: r for r in model.registers if r.access is Access.READ_WRITE for at in range(r.address, r.end)}
        self._stored = bytearray(self.data)  # what outlives power; of use is the EEPROM
        self.stores = 0  # registers that the EEPROM has been given

    def read(self, address: int, length: int) -> bytes:
        """Return raw bytes."""
        return bytes(self.data[address:address + length]).ljust(length, b"\0")

    def write(self, address: int, data: bytes) -> set[str]:
        """Write raw bytes; return the names of the registers that took them."""
        image = bytearray(self.data)
        image[address:address + len(data)] = data
        touched = dict.fromkeys(filter(None, map(self._by_byte.get, range(address, address + len(data)))))
        taken = set()
        for register in touched:
            value = self.decode(register.name, image)
            if _fits(register, value):
                self.assign(register, value)
                taken.add(register.name)
        return taken

    def assign(self, register: Register, value: int) -> None:
        """Set a register as its user does: of the EEPROM it outlives power only if `lock` is 0."""
        self[register.name] = value
        if register.memory is Memory.EEPROM and not self["lock"]:
            self.keep(register)

    def keep(self, register: Register) -> None:
        """Have what a register of the EEPROM holds outlive power."""
        self._stored[register.address:register.end] = self.data[register.address:register.end]
        self.stores += 1

    def restore(self) -> None:
        """Set all registers as at power-up."""
        self.data[:] = self._stored
        self.restore_defaults(Memory.RAM)

    def recover(self, *, keeping_id: bool) -> None:
        """Set all registers as the factory does, but for the id if that is kept."""
        servo_id = self["id"]
        self.restore_defaults(Memory.EEPROM)
        if keeping_id:
            self["id"] = servo_id
        self._stored[:] = self.data


def _fits(register: Register, value: int) -> bool:
    if register.range is not None and not register.range[0] <= value <= register.range[1]:
        return False
    return register.choices is None or value in register.choices
