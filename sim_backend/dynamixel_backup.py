"""The copy of its control table that a Dynamixel keeps on request.

It holds the EEPROM, and of the RAM the gains, the profile and the indirect addresses (e-Manual, Backup Ready). Assumed:
a factory reset leaves it alone; model number and firmware version are no part of it.
"""

from hal.register_map import Access, Memory, Register, ServoModel
from sim_backend.control_table import ControlTable

_RAM = (
    "velocity_i_gain", "velocity_p_gain", "position_d_gain", "position_i_gain", "position_p_gain",
    "feedforward_2nd_gain", "feedforward_1st_gain", "profile_acceleration", "profile_velocity")
_INDIRECT_ADDRESS = "indirect_address_"


class TableBackup:
    """A copy of one servo's registers, if it has been made."""

    def __init__(self) -> None:
        self._values: dict[str, int] = {}

    @property
    def ready(self) -> bool:
        """Whether there is a copy."""
        return bool(self._values)

    def store(self, model: ServoModel, table: ControlTable) -> None:
        """Make a copy, in place of an earlier one."""
        self._values = {register.name: table[register.name] for register in model.registers if _kept(register)}

    def restore(self, model: ServoModel, table: ControlTable, memory: Memory) -> None:
        """Bring the registers of one memory back."""
        for register in model.registers:
            if register.memory is memory and register.name in self._values:
                table.assign(register, self._values[register.name])


def _kept(register: Register) -> bool:
    if register.memory is Memory.EEPROM:
        return register.access is Access.READ_WRITE
    return register.name in _RAM or register.name.startswith(_INDIRECT_ADDRESS)
