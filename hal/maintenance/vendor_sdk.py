"""A servo's maintenance through its vendor's SDK; `dynamixel_vendor` and `feetech_vendor` fill it in.

Both SDKs have one shape: a packet handler whose `readTxRx` and `writeTxRx` take a port and return a result, 0 if all
went well, and the error byte. Only those are used here: they deal in bytes, so that no byte order comes in, which
Feetech's SDK keeps in a global variable.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from enum import StrEnum
from typing import Any, ClassVar, NamedTuple

from hal.maintenance.sdk_port import SdkPort
from robotwalk.errors import BusError, ServoError

SUCCESS = 0  # the SDKs' COMM_SUCCESS
_ATTEMPTS = 3  # at reading


class Keep(StrEnum):
    """What a factory reset leaves as it is."""

    NOTHING = "nothing"
    ID = "id"
    ID_AND_BAUD = "id-and-baud"


class Outcome(NamedTuple):
    """Whether a factory reset leaves these as they are; None: nothing says."""

    id: bool | None
    baud: bool | None


class VendorSdk(ABC):
    """Reads, writes and resets servos on one port.

    Attributes:
        outcomes: what its factory reset can be told to keep, and what comes of it.
    """

    outcomes: ClassVar[Mapping[Keep, Outcome]]

    def __init__(self, handler: Any, port: SdkPort) -> None:
        self.handler = handler
        self.port = port

    def read(self, servo_id: int, address: int, size: int) -> bytes:
        """Return bytes of a servo's table.

        Raises:
            BusError: no good answer came.
            ServoError: the servo refuses.
        """
        result = SUCCESS
        for _ in range(_ATTEMPTS):
            data, result, error = self.handler.readTxRx(self.port, servo_id, address, size)
            if result == SUCCESS:
                self._require_accepted(servo_id, error)
                if len(data) == size:
                    return bytes(data)
        raise BusError(f"id {servo_id}: {self._words(self.handler.getTxRxResult(result))}")

    def write(self, servo_id: int, address: int, data: bytes) -> None:
        """Write bytes to a servo's table. That it is silent is no error: some are set so. Read back to be sure.

        Raises:
            ServoError: the servo refuses.
        """
        result, error = self.handler.writeTxRx(self.port, servo_id, address, len(data), list(data))
        if result == SUCCESS:
            self._require_accepted(servo_id, error)

    @abstractmethod
    def factory_reset(self, servo_id: int, keep: Keep) -> None:
        """Tell a servo to go back to what the factory has set.

        Raises:
            BusError: it does not answer.
            ServoError: it refuses.
        """

    @abstractmethod
    def refusal(self, error: int) -> str:
        """Return why an answer with this error byte is a refusal; "" if it is none."""

    def require_answer(self, servo_id: int, result: int, error: int) -> None:
        """Check the outcome of an instruction. Raises as `factory_reset` does."""
        if result != SUCCESS:
            raise BusError(f"id {servo_id}: {self._words(self.handler.getTxRxResult(result))}")
        self._require_accepted(servo_id, error)

    def _require_accepted(self, servo_id: int, error: int) -> None:
        reason = self.refusal(error)
        if reason:
            raise ServoError(f"id {servo_id} refuses: {reason}")

    def _words(self, text: str) -> str:
        """Drop the SDK's tag: "[TxRxResult] There is no status packet!"."""
        return text.partition("] ")[2].rstrip("!").lower() or "no good answer"
