"""The reply to a fast sync read or a fast bulk read: one frame that Dynamixels build in turn.

    FF FF FD 00 | FE | length L | 55 | error id data CRC | error id data CRC | ...

It is not stuffed. Each CRC runs over the whole frame so far, with the earlier CRCs; the last one is the frame's own.
Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0".
"""

from collections.abc import Callable, Mapping, Sequence
from struct import Struct

from fastcrc.crc16 import umts as crc16

from hal.dynamixel_frames import ALERT, HEAD, HEADER, MAX_LENGTH, STATUS
from hal.instructions import BROADCAST_ID
from hal.protocol import Status
from hal.whole_reply import Outline

JOINT_OUTLINE = Outline(HEAD.size + 1, 2, 2)
_CRC = Struct("<H")


def usual_joint_reply(ids: Sequence[int], length: int) -> Callable[[bytes], bool]:
    """Return what tells whether a reply is the usual one: all `ids` answer, without error or alert.

    Its last CRC covers all blocks and their CRCs.
    """
    heads = Struct("<" + f"BB{length + 2}x" * len(ids))
    head = _head(len(ids) * (length + 4))
    expected = tuple(byte for servo_id in ids for byte in (0, servo_id))

    def is_usual(data: bytes) -> bool:
        return (
            data.startswith(head) and heads.unpack_from(data, len(head)) == expected
            and crc16(data[:-2]) == _CRC.unpack_from(data, len(data) - 2)[0])

    return is_usual


def _head(blocks: int) -> bytes:
    """Return what comes before blocks of so many bytes."""
    return HEAD.pack(HEADER, BROADCAST_ID, 1 + blocks) + bytes((STATUS,))


class JointReply:
    """Takes such a reply apart, block by block.

    Each block is checked by its own CRC, so those before a silent servo or a garbled byte count. Bytes before
    the reply, an echo among them, are skipped. `results` has one entry per id, in the order asked for: None
    until a good block has come. `corrupt` tells that a block came garbled; it and all behind it stay None.
    """

    waits = 1  # the return delay passes once for all

    def __init__(self, lengths: Mapping[int, int]) -> None:
        """Expect so many bytes of data of each id, in that order. Raises ValueError if they do not fit in a frame."""
        self._blocks = [(servo_id, Struct(f"<BB{length}sH")) for servo_id, length in lengths.items()]
        size = 1 + sum(block.size for _, block in self._blocks)
        if size > MAX_LENGTH:
            raise ValueError(f"a reply may be {MAX_LENGTH} bytes long, not {size}: read less at once")
        self._head = _head(size - 1)
        self.size = HEAD.size + size
        self.bad_frames = 0
        self.reset()

    def reset(self) -> None:
        """Forget what has come, for the next reply to the same instruction."""
        self.results: dict[int, Status | None] = {servo_id: None for servo_id, _ in self._blocks}
        self.corrupt = False
        self._pending = b""
        self._crc: int | None = None  # over the frame up to `_pending`; None: its head has not come
        self._arrived = 0  # blocks

    @property
    def complete(self) -> bool:
        """Whether every block has arrived, good or bad: nothing more will come."""
        return self._arrived == len(self._blocks)

    def feed(self, data: bytes) -> None:
        """Take the next bytes and put the blocks that they complete into `results`. What follows the reply goes."""
        if self.complete:
            return
        pending = self._pending + data
        if self._crc is None:
            start = pending.find(self._head)
            if start < 0:
                self._pending = pending[max(0, len(pending) - len(self._head) + 1) :]
                return
            self._crc = crc16(self._head)
            pending = pending[start + len(self._head) :]
        self._pending = self._take_blocks(pending, self._crc)

    def _take_blocks(self, pending: bytes, crc: int) -> bytes:
        """Check and store the whole blocks of `pending`, return the bytes behind them."""
        position = checked = 0
        for expected, block in self._blocks[self._arrived :]:
            end = position + block.size
            if end > len(pending):
                break
            error, servo_id, data, received = block.unpack_from(pending, position)
            crc = crc16(pending[checked : end - 2], crc)
            checked = end - 2
            if not self.corrupt and (crc != received or servo_id != expected):
                self.corrupt = True
                self.bad_frames += 1
            if not self.corrupt:
                self.results[servo_id] = Status(servo_id, error & ~ALERT, error >= ALERT, data)
            position = end
            self._arrived += 1
        crc = crc16(pending[checked:position], crc)
        self._crc = crc
        return b"" if self.complete else pending[position:]
