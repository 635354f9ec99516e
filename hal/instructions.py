"""What Dynamixel and Feetech have in common: the numbers and the parameters of their instructions.

Their frames differ, and so does the width of an address; each protocol module brings both.
"""

from collections.abc import Callable, Iterable, Sequence
from enum import IntEnum

BROADCAST_ID = 0xFE


class Instruction(IntEnum):
    """The instructions that are sent from here."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    RESET_TURNS = 0x0A  # Feetech's only
    CALIBRATE = 0x0B  # Feetech's only
    CLEAR = 0x10  # Dynamixel 2.0 only
    CONTROL_TABLE_BACKUP = 0x20  # Dynamixel 2.0 only
    SYNC_READ = 0x82  # not in Dynamixel 1.0
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A  # Dynamixel 2.0 only
    BULK_READ = 0x92  # Dynamixel's only
    BULK_WRITE = 0x93  # Dynamixel 2.0 only
    FAST_BULK_READ = 0x9A  # Dynamixel 2.0 only


class Instructions:
    """Builds the instructions of one protocol. Each method returns the bytes of a frame, or raises ValueError."""

    def __init__(
        self, frame: Callable[[int, Instruction, bytes], bytes], *, max_id: int, address_bytes: int, largest: int
    ) -> None:
        """Take what frames an instruction, and how many bytes of parameters fit into one frame (`largest`)."""
        self._frame = frame
        self._max_id = max_id
        self._address_bytes = address_bytes
        self._largest = largest

    def ping(self, servo_id: int) -> bytes:
        """Ask whether a servo is there. A broadcast asks everyone."""
        return self._build(servo_id, Instruction.PING)

    def read(self, servo_id: int, address: int, length: int) -> bytes:
        """Read `length` bytes from `address` on."""
        if servo_id == BROADCAST_ID:
            raise ValueError("no servo answers a broadcast read")
        return self._build(servo_id, Instruction.READ, self._range(address, length))

    def write(self, servo_id: int, address: int, data: bytes) -> bytes:
        """Write `data` from `address` on."""
        return self._build(servo_id, Instruction.WRITE, self._at(address, data))

    def reg_write(self, servo_id: int, address: int, data: bytes) -> bytes:
        """Write `data` from `address` on when the next `action` comes."""
        return self._build(servo_id, Instruction.REG_WRITE, self._at(address, data))

    def action(self, servo_id: int) -> bytes:
        """Carry out what `reg_write` registered."""
        return self._build(servo_id, Instruction.ACTION)

    def reboot(self, servo_id: int) -> bytes:
        """Start the servo's firmware anew: torque goes off, RAM goes back to its defaults."""
        return self._build(servo_id, Instruction.REBOOT)

    def factory_reset(self, servo_id: int) -> bytes:
        """Bring back what the factory has set."""
        return self._build(servo_id, Instruction.FACTORY_RESET)

    def reset_turns(self, servo_id: int) -> bytes:
        """Forget whole turns."""
        return self._build(servo_id, Instruction.RESET_TURNS)

    def calibrate(self, servo_id: int) -> bytes:
        """Make where the shaft is the centre of its range."""
        return self._build(servo_id, Instruction.CALIBRATE)

    def sync_write(self, address: int, length: int, items: Iterable[tuple[int, bytes]]) -> bytes:
        """Write `length` bytes of its own to each (id, data), in one frame that nobody answers."""
        items = tuple(items)
        self.check_ids([servo_id for servo_id, _ in items], 1 + length)
        parts = [self._range(address, length)]
        for servo_id, data in items:
            if len(data) != length:
                raise ValueError(f"servo {servo_id}: expected {length} bytes of data, got {len(data)}")
            parts += (bytes((servo_id,)), data)
        return self._build(BROADCAST_ID, Instruction.SYNC_WRITE, b"".join(parts))

    def sync_writer(self, address: int, length: int, ids: Sequence[int]) -> Callable[[bytes], bytes]:
        """Return what makes a sync write to these servos of bytes that hold each id and, behind it, its data."""
        self.check_ids(ids, 1 + length)
        head, frame = self._range(address, length), self._frame
        return lambda columns: frame(BROADCAST_ID, Instruction.SYNC_WRITE, head + columns)

    def sync_read(self, address: int, length: int, ids: Sequence[int]) -> bytes:
        """Read the same `length` bytes of every servo; each answers with a status, in the order of `ids`."""
        return self._group(Instruction.SYNC_READ, address, length, ids)

    def fast_sync_read(self, address: int, length: int, ids: Sequence[int]) -> bytes:
        """Read the same `length` bytes of every servo; they answer with one frame."""
        return self._group(Instruction.FAST_SYNC_READ, address, length, ids)

    def check_ids(self, ids: Sequence[int], bytes_each: int = 1) -> None:
        """Raise ValueError unless these are different ids that fit into one frame."""
        if not ids or len(set(ids)) != len(ids) or min(ids) < 0 or max(ids) > self._max_id:
            raise ValueError(f"expected different ids from 0 to {self._max_id}, got {list(ids)}")
        most = (self._largest - 2 * self._address_bytes) // bytes_each
        if len(ids) > most:
            raise ValueError(f"{most} servos fit into a frame with {self._largest} bytes of parameters, not {len(ids)}")

    def _group(self, instruction: Instruction, address: int, length: int, ids: Sequence[int]) -> bytes:
        self.check_ids(ids)
        return self._build(BROADCAST_ID, instruction, self._range(address, length) + bytes(ids))

    def _build(self, servo_id: int, instruction: Instruction, parameters: bytes = b"") -> bytes:
        if not (0 <= servo_id <= self._max_id or servo_id == BROADCAST_ID):
            raise ValueError(f"a servo's id is 0 to {self._max_id}, not {servo_id}")
        return self._frame(servo_id, instruction, parameters)

    def _at(self, address: int, data: bytes) -> bytes:
        return self._range(address, len(data))[: self._address_bytes] + data

    def _range(self, address: int, length: int) -> bytes:
        size = self._address_bytes
        if not (address >= 0 and length > 0 and address + length <= 1 << 8 * size):
            raise ValueError(f"there is no range of {length} bytes at address {address}")
        if length > self._largest:
            raise ValueError(f"a frame holds {self._largest} bytes of data, not {length}: ask for less at once")
        return address.to_bytes(size, "little") + length.to_bytes(size, "little")
