"""What hangs on the far end of a wire, whatever its protocol: bytes in, replies out.

Of servos that share an id all obey and all answer: `reply.collide` tells what is heard. Each servo's answer passes
through `FakeServo.utter` before it goes onto the wire. Those that wait for their turn behind a servo wait for
the end of its bytes, whatever they say.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import ClassVar, Generic, NamedTuple, Protocol, TypeVar

from sim_backend.reply import Reply as Reply  # named twice: what devices return
from sim_backend.reply import collide

_GAP_NS = 1_500_000  # a longer pause inside a frame drops it (e-Manual, Protocol 2.0; assumed of other brands)
_PING_SLOT_NS = 3_000_000  # per id, after a broadcast ping: what the hosts' libraries of either brand allow for
_BITS_PER_BYTE = 10  # 8N1
_NS = 1_000_000_000



class BusServo(Protocol):
    """What a device needs of a servo, besides that it obeys."""

    @property
    def id(self) -> int:
        """What it answers to."""
        ...

    @property
    def return_delay_ns(self) -> int:
        """From the end of an instruction to the answer."""
        ...

    @property
    def later_ids_answer(self) -> bool:
        """Whether it answers a read of many behind a silent servo."""
        ...

    def listens(self, now: int, baud: int) -> bool:
        """Whether bytes at `baud` reach it at `now` ns."""
        ...

    def utter(self, reply: Reply) -> Reply | None:
        """Return what of an answer goes onto the wire."""
        ...


Servo = TypeVar("Servo", bound=BusServo)


class Device(Protocol):
    """All that hangs on the far end of a wire."""

    def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
        """Take bytes, the last of which arrives at `now` ns; return what is answered, in order."""
        ...


class Packet(NamedTuple):
    """An instruction as received."""

    id: int
    instruction: int
    parameters: bytes
    intact: bool = True  # whether its checksum is right


class InstructionParser(ABC):
    """Finds frames in what arrives on the wire, piece by piece."""

    header: ClassVar[bytes]
    prologue: ClassVar[int]  # bytes until a frame's length is known

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._last_byte_at = 0

    def feed(self, data: bytes, now: int, byte_ns: int) -> Iterator[Packet]:
        """Take bytes, without pauses between them, the last of which arrives at `now`; yield whole frames."""
        if now - len(data) * byte_ns - self._last_byte_at > _GAP_NS:
            self._buffer.clear()
        self._last_byte_at = now
        self._buffer += data
        while (packet := self._next()) is not None:
            yield packet

    def _align(self) -> bool:
        """Skip noise and false headers. Return whether a frame begins the buffer, its length known."""
        buffer = self._buffer
        while True:
            start = buffer.find(self.header)
            if start < 0:
                del buffer[:max(0, len(buffer) - len(self.header) + 1)]
                return False
            del buffer[:start]
            if len(buffer) < self.prologue:
                return False
            if self._plausible():
                return True
            del buffer[0]

    @abstractmethod
    def _plausible(self) -> bool:
        """Tell whether the buffer begins with a header, id and length that a frame may have."""

    @abstractmethod
    def _next(self) -> Packet | None:
        """Take the first whole frame off the buffer, and what lies before it."""


class ServoDevice(ABC, Generic[Servo]):
    """All servos of one bus, of one protocol; a `Device`."""

    def __init__(self, servos: Sequence[Servo], parser: InstructionParser) -> None:
        self._servos = tuple(servos)
        self._parser = parser

    def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
        """Take bytes, the last of which arrives at `now` ns; return what is answered, in order."""
        byte_ns = byte_time(baud)
        replies: list[Reply] = []
        for packet in self._parser.feed(data, now, byte_ns):
            listening = [servo for servo in self._servos if servo.listens(now, baud)]
            replies += self._obey(packet, listening, now, byte_ns)
        return replies

    @abstractmethod
    def _obey(self, packet: Packet, listening: list[Servo], now: int, byte_ns: int) -> list[Reply]:
        """Let the servos that hear a packet do as it says; return what they answer."""


def byte_time(baud: int) -> int:
    """Return how long a byte is on the wire, ns."""
    return _BITS_PER_BYTE * _NS // baud


def by_id(servos: Iterable[Servo]) -> dict[int, list[Servo]]:
    """Return the servos by their ids; there should be one of each."""
    found: dict[int, list[Servo]] = {}
    for servo in servos:
        found.setdefault(servo.id, []).append(servo)
    return found


def sync_write_blocks(blocks: bytes, length: int) -> dict[int, bytes]:
    """Split what follows a sync write's range: by id, the `length` bytes for it. Empty if they do not fit."""
    if len(blocks) % (length + 1):
        return {}
    return {blocks[at]: blocks[at + 1:at + 1 + length] for at in range(0, len(blocks), length + 1)}


def answers_in_slots(
    servos: Iterable[Servo], answer: Callable[[Servo], bytes | None], byte_ns: int
) -> list[Reply]:
    """Let every servo answer in the time slot of its id."""
    replies = []
    free_at = 0  # after the instruction's end, ns
    for servo_id, sharing in sorted(by_id(servos).items()):
        at = servo_id * _PING_SLOT_NS
        for delay_ns, data in answers_at_once(sharing, answer, byte_ns):
            starts = max(free_at, at + delay_ns)
            replies.append(Reply(starts - free_at, data))
            free_at = at = starts + len(data) * byte_ns
    return replies


def answers_in_turn(
    ids: Iterable[int], listening: Iterable[Servo], answer: Callable[[Servo], bytes | None], byte_ns: int
) -> list[Reply]:
    """Let each servo listed answer behind the one before it, if that one does; a firmware may be more patient."""
    servos = by_id(listening)
    replies: list[Reply] = []
    broken = False  # whether a listed servo stayed silent
    for servo_id in ids:
        sharing = [servo for servo in servos.get(servo_id, ()) if not broken or servo.later_ids_answer]
        heard = answers_at_once(sharing, answer, byte_ns)
        replies += heard
        broken = broken or not heard
    return replies


def answers_at_once(
    sharing: Iterable[Servo], answer: Callable[[Servo], bytes | None], byte_ns: int
) -> list[Reply]:
    """Return what is heard of servos that share an id: of one alone, its answer."""
    said = []
    for servo in sharing:
        frame = answer(servo)
        reply = None if frame is None else servo.utter(Reply(servo.return_delay_ns, frame))
        if reply is not None:
            said.append(reply)
    return collide(said, byte_ns)
