"""A serial line, what it carried, and how long things take on it."""

from hal.protocol import GroupReply
from robotwalk.ports import BytePort

_NS = 1_000_000_000
_BITS_PER_BYTE = 10  # 8N1


class Wire:
    """A port whose bytes are counted.

    Attributes:
        latency: ns that a reply takes beyond its time on the wire: the adapter's, mostly.
        return_delay: ns that the slowest of its servos lets pass before it answers.
    """

    def __init__(self, port: BytePort, baud: int) -> None:
        self.port = port
        self.baud = baud
        self.tx_bytes = self.rx_bytes = 0
        self.latency = self.return_delay = 0

    def send(self, frame: bytes) -> None:
        """Queue a frame for sending. Raises BusError if the port is dead."""
        self.tx_bytes += len(frame)
        self.port.write(frame)

    def receive(self) -> bytes:
        """Return what has come. Raises BusError if the port is dead."""
        data = self.port.read()
        self.rx_bytes += len(data)
        return data

    def duration(self, size: int) -> int:
        """Return how long so many bytes are on the wire, ns."""
        return size * _BITS_PER_BYTE * _NS // self.baud

    def round_trip(self, frame: bytes, reply: GroupReply) -> int:
        """Return how long it takes to send a frame and hear the whole reply, ns; the adapter's latency not counted."""
        return self.duration(len(frame) + reply.size) + reply.waits * self.return_delay
