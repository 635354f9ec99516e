"""What the device of Dynamixel Protocol 1.0 needs of a servo."""

from collections.abc import Callable
from typing import Protocol

from sim_backend.device import BusServo
from sim_backend.reply import Reply


class Protocol1Servo(BusServo, Protocol):
    """What obeys here: an AX, or a later servo that has been told to."""

    @property
    def status_return_level(self) -> int:
        """What it answers at all."""
        ...

    @property
    def conditions(self) -> int:
        """The bits that are in the error byte of every answer."""
        ...

    @property
    def knows_reboot(self) -> bool:
        """Whether it has that instruction."""
        ...

    @property
    def knows_bulk_read(self) -> bool:
        """Whether it has that instruction."""
        ...

    def hear(self, now: int) -> None:
        """Note that an instruction, to whomever, came over the bus."""
        ...

    def answer(self, delay_ns: int, frame: Callable[[int], bytes], servo_id: int, byte_ns: int) -> Reply | None:
        """Return what goes onto the wire after an instruction."""
        ...

    def read(self, address: int, length: int) -> bytes:
        """Return bytes of the control table. Raises RefusedError."""
        ...

    def write(self, address: int, data: bytes) -> None:
        """Write bytes to the control table. Raises RefusedError."""
        ...

    def register_write(self, address: int, data: bytes) -> None:
        """Keep a write for `action`. Raises RefusedError."""
        ...

    def action(self) -> None:
        """Carry out the write that was kept. Raises RefusedError."""
        ...

    def factory_reset(self, now: int) -> None:
        """Go back to the factory's settings, and start afresh."""
        ...

    def reboot(self, now: int) -> None:
        """Start afresh."""
        ...
