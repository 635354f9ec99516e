"""A servo of the X series or MX that has been told to speak Protocol 1.0, as the device of that protocol sees it.

Its control table stays, as far as an address of one byte reaches. Error numbers become bits (e-Manual, Protocol 1.0).
Assumed: a hardware error without a bit of its own, of the encoder or an electrical shock, shows as overload.
"""

from collections.abc import Callable
from typing import TypeVar

from sim_backend.ax_table import Refusal, RefusedError
from sim_backend.dynamixel_core import ENCODER, INPUT_VOLTAGE, OVERHEATING, OVERLOAD, SHOCK
from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.dynamixel_table import ErrorNumber, StatusError
from sim_backend.reply import Reply

_BITS = {ErrorNumber.INSTRUCTION: Refusal.INSTRUCTION, ErrorNumber.DATA_LIMIT: Refusal.ANGLE_LIMIT}  # others: range
_RESET_ALL = 0xFF
_T = TypeVar("_T")


class FirstProtocol:
    """One servo.

    Attributes:
        knows_reboot: it does.
        knows_bulk_read: it does.
    """

    knows_reboot = knows_bulk_read = True

    def __init__(self, servo: DynamixelServo) -> None:
        self._servo = servo
        self._now = 0

    @property
    def id(self) -> int:
        """What it answers to."""
        return self._servo.id

    @property
    def return_delay_ns(self) -> int:
        """From the end of an instruction to the answer."""
        return self._servo.return_delay_ns

    @property
    def later_ids_answer(self) -> bool:
        """Whether it answers a read of many behind a silent servo."""
        return self._servo.later_ids_answer

    @property
    def status_return_level(self) -> int:
        """What it answers at all."""
        return self._servo.status_return_level

    @property
    def conditions(self) -> int:
        """The bits that are in the error byte of every answer."""
        errors = self._servo.table["hardware_error_status"]
        conditions = errors & (INPUT_VOLTAGE | OVERHEATING | OVERLOAD)
        return conditions | OVERLOAD if errors & (ENCODER | SHOCK) else conditions

    def listens(self, now: int, baud: int) -> bool:
        """Whether bytes at `baud` reach it at `now` ns."""
        return self._servo.protocol == 1 and self._servo.listens(now, baud)

    def hear(self, now: int) -> None:
        """Note that an instruction, to whomever, came over the bus."""
        self._now = now
        self._servo.hear(now)

    def answer(self, delay_ns: int, frame: Callable[[int], bytes], servo_id: int, byte_ns: int) -> Reply | None:
        """Return what goes onto the wire after an instruction."""
        return self._servo.answer(delay_ns, frame, servo_id, byte_ns)

    def utter(self, reply: Reply) -> Reply | None:
        """Return what of an answer goes onto the wire."""
        return self._servo.utter(reply)

    def read(self, address: int, length: int) -> bytes:
        """Return bytes of the control table. Raises RefusedError."""
        return self._try(lambda: self._servo.read(address, length, self._now))

    def write(self, address: int, data: bytes) -> None:
        """Write bytes to the control table. Raises RefusedError."""
        self._try(lambda: self._servo.write(address, data))

    def register_write(self, address: int, data: bytes) -> None:
        """Keep a write for `action`. Raises RefusedError."""
        self._try(lambda: self._servo.register_write(address, data))

    def action(self) -> None:
        """Carry out the write that was kept. Raises RefusedError."""
        self._try(self._servo.action)

    def factory_reset(self, now: int) -> None:
        """Go back to the factory's settings, protocol included."""
        self._servo.factory_reset(_RESET_ALL, now)

    def reboot(self, now: int) -> None:
        """Start afresh."""
        self._servo.reboot(now)

    def _try(self, obey: Callable[[], _T]) -> _T:
        try:
            return obey()
        except StatusError as refused:
            raise RefusedError(_BITS.get(refused.number, Refusal.RANGE)) from refused
