"""What a servo protocol must offer, whatever the brand; `hal.dynamixel_protocol` is one.

A protocol is a module of pure functions and two classes: frames out, statuses in, no I/O.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, Protocol


class Status(NamedTuple):
    """What one servo answered."""

    id: int
    error: int  # 0, or why the servo refused, as the protocol's `describe_error` says
    alert: bool  # the servo reports a fault of its hardware; the data is valid all the same
    data: bytes


class Receiver(Protocol):
    """Finds statuses in a stream of bytes that may be garbled."""

    bad_frames: int

    def feed(self, data: bytes) -> list[Status]:
        """Take the next bytes, return the statuses that they complete."""
        ...

    def reset(self) -> None:
        """Throw away half a frame that is waiting for its rest."""
        ...


class GroupReply(Protocol):
    """Collects the answers to one read of many servos."""

    @property
    def results(self) -> dict[int, Status | None]:
        """The statuses by id, in the order asked for; None until a good answer has come."""
        ...

    @property
    def bad_frames(self) -> int:
        """How many frames, or answers in a joint frame, came garbled."""
        ...

    @property
    def size(self) -> int:
        """How many bytes come if everybody answers and nothing needs stuffing."""
        ...

    @property
    def waits(self) -> int:
        """How many times a servo's return delay passes."""
        ...

    def reset(self) -> None:
        """Forget what has come, for the next answers to the same request."""
        ...

    def feed(self, data: bytes) -> None:
        """Take the next bytes and put the statuses that they complete into `results`."""
        ...

    @property
    def complete(self) -> bool:
        """Whether nothing more will come."""
        ...


class SeparateReplies:
    """A `GroupReply` of one status a servo, found by a receiver."""

    def __init__(self, receiver: Receiver, ids: Sequence[int], size: int) -> None:
        """Expect a status of each of `ids`, `size` bytes in all, frames included."""
        self._receiver = receiver
        self._ids = tuple(ids)
        self.size = size
        self.waits = len(self._ids)
        self.reset()

    @property
    def bad_frames(self) -> int:
        """How many frames came garbled."""
        return self._receiver.bad_frames

    def reset(self) -> None:
        """Forget what has come."""
        self._receiver.reset()
        self.results: dict[int, Status | None] = dict.fromkeys(self._ids)
        self._missing = len(self._ids)

    def feed(self, data: bytes) -> None:
        """Take the next bytes."""
        for status in self._receiver.feed(data):
            if self.results.get(status.id, status) is None:
                self.results[status.id] = status
                self._missing -= 1

    @property
    def complete(self) -> bool:
        """Whether everybody has answered."""
        return self._missing == 0


class ServoProtocol(Protocol):
    """Frames of one protocol. Each function returns the bytes of one instruction."""

    @property
    def BROADCAST_ID(self) -> int:  # noqa: N802 (a module's constant)
        """The id that everybody obeys."""
        ...

    @property
    def BULK_READ(self) -> bool:  # noqa: N802 (a module's constant)
        """Whether there is an instruction that reads another range of each servo."""
        ...

    @property
    def PING_SLOT_NS(self) -> int | None:  # noqa: N802 (a module's constant)
        """How long after a broadcast ping each id has for its answer, ns; None: they would all answer at once."""
        ...

    def receiver(self) -> Receiver:
        """Return what finds statuses in the bytes that come back."""
        ...

    def ping(self, servo_id: int) -> bytes:
        """Ask whether a servo is there."""
        ...

    def read(self, servo_id: int, address: int, length: int) -> bytes:
        """Read `length` bytes from `address` on."""
        ...

    def write(self, servo_id: int, address: int, data: bytes) -> bytes:
        """Write `data` from `address` on."""
        ...

    def reboot(self, servo_id: int) -> bytes:
        """Start the servo's firmware anew."""
        ...

    def sync_write(self, address: int, length: int, items: Iterable[tuple[int, bytes]]) -> bytes:
        """Write `length` bytes of its own to each (id, data), in one frame that nobody answers."""
        ...

    def sync_writer(self, address: int, length: int, ids: Sequence[int]) -> Callable[[bytes], bytes]:
        """Return what makes a sync write to these servos of bytes that hold each id and, behind it, its data."""
        ...

    def single_read(self, servo_id: int, address: int, length: int) -> tuple[bytes, GroupReply]:
        """Read bytes of one servo; return the request and what collects the answer."""
        ...

    def group_read(self, address: int, length: int, ids: Sequence[int], *, fast: bool) -> tuple[bytes, GroupReply]:
        """Read the same bytes of many servos at once; return the request and what collects the answers."""
        ...

    def bulk_read(self, items: Sequence[tuple[int, int, int]], *, fast: bool) -> tuple[bytes, GroupReply]:
        """Read of each (id, address, length) that range; return the request and what collects the answers."""
        ...

    def describe_error(self, number: int) -> str:
        """Return in plain words what `Status.error` says."""
        ...
