"""The instructions that Dynamixel Protocol 2.0 has beyond the common ones."""

from collections.abc import Iterable, Sequence
from enum import IntEnum

from hal.instructions import BROADCAST_ID, Instruction, Instructions

_CLEAR = b"\x01\x44\x58\x4c\x22"  # the turns of the position; the rest guards against accidents
_STORE = b"\x01CTRL"
_RESTORE = b"\x02CTRL"

Range = tuple[int, int, int]  # id, address, length


class Keep(IntEnum):
    """What a servo keeps in a factory reset."""

    NOTHING = 0xFF
    ID = 0x01
    ID_AND_BAUD = 0x02


class DynamixelInstructions(Instructions):
    """Builds them. Each method returns the bytes of a frame, or raises ValueError."""

    def factory_reset_but(self, servo_id: int, keep: Keep) -> bytes:
        """Make all settings the factory's, but for what is kept, and start the servo anew."""
        if servo_id == BROADCAST_ID and keep is Keep.NOTHING:
            raise ValueError("all servos of the bus would get the same id, so they refuse")
        return self._build(servo_id, Instruction.FACTORY_RESET, bytes((keep,)))

    def clear(self, servo_id: int) -> bytes:
        """Take whole turns off the position. A servo that moves refuses."""
        return self._build(servo_id, Instruction.CLEAR, _CLEAR)

    def store_backup(self, servo_id: int) -> bytes:
        """Have a servo keep a copy of its control table. While torque is on it refuses."""
        return self._build(servo_id, Instruction.CONTROL_TABLE_BACKUP, _STORE)

    def restore_backup(self, servo_id: int) -> bytes:
        """Have a servo take its copy back, and start anew. While torque is on it refuses."""
        return self._build(servo_id, Instruction.CONTROL_TABLE_BACKUP, _RESTORE)

    def bulk_write(self, items: Iterable[tuple[int, int, bytes]]) -> bytes:
        """Write each (id, address, data), in one frame that nobody answers; an id only once."""
        items = tuple(items)
        self.check_ids([servo_id for servo_id, _, _ in items])
        return self._build(BROADCAST_ID, Instruction.BULK_WRITE, b"".join(
            bytes((servo_id,)) + self._range(address, len(data)) + data for servo_id, address, data in items))

    def bulk_read(self, items: Sequence[Range]) -> bytes:
        """Read a range of each servo; each answers with a status, in the order of `items`; an id only once."""
        return self._ranges(Instruction.BULK_READ, items)

    def fast_bulk_read(self, items: Sequence[Range]) -> bytes:
        """Read a range of each servo; they answer with one frame."""
        return self._ranges(Instruction.FAST_BULK_READ, items)

    def _ranges(self, instruction: Instruction, items: Sequence[Range]) -> bytes:
        self.check_ids([servo_id for servo_id, _, _ in items])
        return self._build(BROADCAST_ID, instruction, b"".join(
            bytes((servo_id,)) + self._range(address, length) for servo_id, address, length in items))
