"""Feetech servos through Feetech's `scservo_sdk`."""

from types import MappingProxyType

from scservo_sdk import protocol_packet_handler

from hal.maintenance.sdk_port import SdkPort
from hal.maintenance.vendor_sdk import Keep, Outcome, VendorSdk

_RECOVERY = 0x06  # in FTServo_Arduino's INST.h; the SDK has no function for it
_SIZE = 6  # bytes of a packet without parameters


class FeetechSdk(VendorSdk):
    """STS, SMS and SCS series."""

    # Nothing says what becomes of the id and the baud rate, and the instruction takes no choice.
    outcomes = MappingProxyType({Keep.NOTHING: Outcome(id=None, baud=None)})

    def __init__(self, port: SdkPort) -> None:
        # Not by `PacketHandler(end)`: that sets the byte order of every other handler in the process.
        super().__init__(protocol_packet_handler(), port)

    def factory_reset(self, servo_id: int, keep: Keep) -> None:
        """Reset a servo. Nothing says that it acknowledges."""
        packet = [0] * _SIZE
        packet[2:5] = servo_id, 2, _RECOVERY
        self.handler.txRxPacket(self.port, packet)

    def refusal(self, error: int) -> str:
        """Return "": the error byte tells of faults of the hardware, never of a refusal."""
        return ""
