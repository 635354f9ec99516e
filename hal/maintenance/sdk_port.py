"""What the vendors' SDKs take for a serial port: their `PortHandler`, over a port and a clock of ours.

Their own polls the line without a pause, keeps time by a clock that can be set back, and waits 34 ms for whoever is
silent. This one blocks in `Clock.wait`, so that simulated time can pass there. The port is already open.
"""

# ruff: noqa: N802 (the SDKs choose these names)

from collections.abc import Sequence

from hal.tunable_port import TunablePort
from robotwalk.ports import Clock

_MS = 1_000_000  # ns
_NS = 1_000_000_000
_BITS_PER_BYTE = 10  # 8N1
_PATIENCE = 150 * _MS  # beyond the wire time; only a silent servo costs it. Feetech's EEPROM may take over 21 ms


class SdkPort:
    """A `PortHandler` of dynamixel_sdk and of scservo_sdk.

    Attributes:
        is_using: the SDKs' mark that a reply is still to come.
    """

    def __init__(self, port: TunablePort, clock: Clock) -> None:
        self.is_using = False
        self._port = port
        self._clock = clock
        self._received = bytearray()
        self._deadline = 0
        self._written = 0  # bytes

    def getBaudRate(self) -> int:
        """Return the baud rate."""
        return self._port.baud

    def clearPort(self) -> None:
        """Throw away what has come."""
        self._port.read()
        self._received.clear()

    def writePort(self, packet: Sequence[int]) -> int:
        """Send a packet; return its length."""
        try:
            self._port.write(bytes(packet))
        except BaseException:
            self.is_using = False  # or the SDK would call the port busy for ever
            raise
        self._written = len(packet)
        return len(packet)

    def readPort(self, length: int) -> bytes:
        """Return up to `length` bytes; if there are none, wait for some until the packet's time is over."""
        if length <= 0:
            return b""
        while not self._received and self._clock.now() < self._deadline:
            self._clock.wait((self._port,), self._deadline)
            self._received += self._port.read()
        data = bytes(self._received[:length])
        del self._received[:length]
        return data

    def setPacketTimeout(self, packet_length: int) -> None:
        """Begin the time for a packet of so many bytes, behind the one just sent."""
        on_wire = (self._written + packet_length) * _BITS_PER_BYTE * _NS // self._port.baud
        self._deadline = self._clock.now() + on_wire + _PATIENCE

    def setPacketTimeoutMillis(self, msec: float) -> None:
        """Begin a time of so many milliseconds."""
        self._deadline = self._clock.now() + round(msec * _MS)

    def isPacketTimeout(self) -> bool:
        """Tell whether the time is over and all that came has been read."""
        return not self._received and self._clock.now() >= self._deadline
