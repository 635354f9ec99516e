"""Dynamixel servos through ROBOTIS's `dynamixel_sdk`."""

from types import MappingProxyType

from dynamixel_sdk import Protocol2PacketHandler

from hal.dynamixel_protocol import describe_error
from hal.maintenance.sdk_port import SdkPort
from hal.maintenance.vendor_sdk import Keep, Outcome, VendorSdk

_OPTIONS = {Keep.NOTHING: 0xFF, Keep.ID: 0x01, Keep.ID_AND_BAUD: 0x02}  # e-Manual, Protocol 2.0, factory reset
_ALERT = 0x80
_LENGTH, _INSTRUCTION = 5, 7  # where they are in a packet
_CRC = 2  # bytes
_PLAIN, _STUFFED = b"\xff\xff\xfd", b"\xff\xff\xfd\xfd"


class DynamixelSdk(VendorSdk):
    """Protocol 2.0."""

    outcomes = MappingProxyType({
        Keep.NOTHING: Outcome(id=False, baud=False),
        Keep.ID: Outcome(id=True, baud=False),
        Keep.ID_AND_BAUD: Outcome(id=True, baud=True),
    })

    def __init__(self, port: SdkPort) -> None:
        handler = Protocol2PacketHandler()
        # Version 4.1.0 throws away what its own stuffing returns, so that a false header goes out, and takes
        # stuffing out of bytes that it has already overwritten.
        handler.addStuffing = _stuff
        handler.removeStuffing = _unstuff
        super().__init__(handler, port)

    def factory_reset(self, servo_id: int, keep: Keep) -> None:
        """Reset a servo."""
        self.require_answer(servo_id, *self.handler.factoryReset(self.port, servo_id, _OPTIONS[keep]))

    def refusal(self, error: int) -> str:
        """Return what the error number says; the alert beside it is no refusal."""
        number = error & ~_ALERT
        return describe_error(number) if number else ""


def _stuff(packet: list[int]) -> list[int]:
    """Stuff a packet in place, its CRC's two bytes being empty yet."""
    return _replace_body(packet, _PLAIN, _STUFFED)


def _unstuff(packet: list[int]) -> list[int]:
    """Take the stuffing out of a packet in place."""
    return _replace_body(packet, _STUFFED, _PLAIN)


def _replace_body(packet: list[int], old: bytes, new: bytes) -> list[int]:
    length = packet[_LENGTH] | packet[_LENGTH + 1] << 8
    end = _INSTRUCTION + length - _CRC
    body = bytes(packet[_INSTRUCTION:end]).replace(old, new)
    packet[_LENGTH:end] = [*(len(body) + _CRC).to_bytes(2, "little"), *body]
    return packet
