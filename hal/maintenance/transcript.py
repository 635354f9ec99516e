"""What is said on a servo bus, in words: instructions, answers, and what is neither.

Dynamixel 2.0 tells instructions from answers. In the other protocols they look alike: the answer to an instruction
is the next frame of a servo that was asked, unless it repeats the question byte for byte.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

from hal.dynamixel_frames import ALERT
from hal.encoding import unpack
from hal.frame_splitter import Frame, Garbage, Piece, Splitter
from hal.instructions import BROADCAST_ID, Instruction
from hal.maintenance import quantity
from hal.protocols import protocol_named
from hal.register_map import ServoModel

_SINGLE = {
    Instruction.ACTION: "do what was registered", Instruction.FACTORY_RESET: "factory reset",
    Instruction.REBOOT: "reboot", Instruction.RESET_TURNS: "reset turns", Instruction.CALIBRATE: "calibrate",
    Instruction.CLEAR: "clear", Instruction.CONTROL_TABLE_BACKUP: "control table backup"}
_GROUP_READS = {
    Instruction.SYNC_READ: "sync read", Instruction.FAST_SYNC_READ: "fast sync read"}
_BULK_READS = {Instruction.BULK_READ: "bulk read", Instruction.FAST_BULK_READ: "fast bulk read"}
_CRC = 2  # bytes behind each block of a joint reply
_LONGEST = 24  # bytes of garbage that are shown


class Said(NamedTuple):
    """Something that was said."""

    kind: str  # "instruction", "status" or "garbage"
    id: int | None
    words: str
    raw: bytes


class Transcriber:
    """Follows one bus."""

    def __init__(self, protocol: str, models: Mapping[int, ServoModel]) -> None:
        """Take the name of the protocol, and the models of the servos that are known, by id."""
        self._two = protocol == "dynamixel-2.0"
        self._address_bytes = 2 if self._two else 1
        self._describe: Callable[[int], str] = protocol_named(protocol).describe_error
        self._receiver = protocol_named(protocol).receiver
        self._pinged = False  # and nothing was asked since
        self._models = dict(models)
        self._streams = {way: Splitter(protocol) for way in (True, False, None)}
        self._awaited: list[int] = []
        self._asked: dict[int, tuple[int, int]] = {}  # by id: address and length of what was last asked for
        self._question = b""

    def take(self, data: bytes, sent: bool | None = None) -> Iterator[Said]:
        """Take bytes that the host sent, or received; None: nobody knows, since somebody else spoke."""
        for piece in self._streams[sent].feed(data):
            yield self._said(piece, sent)

    def end(self) -> Iterator[Said]:
        """Return what is left of frames that break off."""
        for sent, stream in self._streams.items():
            for piece in stream.flush():
                yield self._said(piece, sent)

    def _said(self, piece: Piece, sent: bool | None) -> Said:
        if isinstance(piece, Garbage):
            shown = piece.raw[:_LONGEST].hex(" ") + (" ..." if len(piece.raw) > _LONGEST else "")
            return Said("garbage", None, f"{len(piece.raw)} bytes, {piece.why}: {shown}", piece.raw)
        status = piece.status
        if status is None:
            status = self._answers(piece) if sent is None else not sent
        words = self._status(piece) if status else self._instruction(piece)
        return Said("status" if status else "instruction", piece.id, words, piece.raw)

    def _answers(self, frame: Frame) -> bool:
        return frame.id in self._awaited and frame.raw != self._question

    def _instruction(self, frame: Frame) -> str:
        self._question, parameters, width = frame.raw, frame.parameters, self._address_bytes
        who = "everyone" if frame.id == BROADCAST_ID else str(frame.id)
        self._awaited = [] if frame.id == BROADCAST_ID else [frame.id]
        if frame.id != BROADCAST_ID:
            self._asked.pop(frame.id, None)
        try:
            instruction = Instruction(frame.code)
        except ValueError:
            return f"instruction {frame.code:#04x} to {who}, which no manual names: {parameters.hex(' ')}"
        self._pinged = instruction is Instruction.PING
        if self._pinged:
            return f"ping {who}"
        if instruction is Instruction.READ and len(parameters) == 2 * width:
            self._asked[frame.id] = self._number(parameters), self._number(parameters[width:])
            return f"read {who}: {self._names(frame.id, *self._asked[frame.id])}"
        if instruction in (Instruction.WRITE, Instruction.REG_WRITE) and len(parameters) > width:
            verb = "write" if instruction is Instruction.WRITE else "register a write to"
            return f"{verb} {who}: {self._values(frame.id, self._number(parameters), parameters[width:])}"
        if instruction is Instruction.SYNC_WRITE and len(parameters) > 2 * width:
            return self._sync_write(parameters)
        if instruction in _GROUP_READS and len(parameters) > 2 * width:
            address, length = self._number(parameters), self._number(parameters[width:])
            self._await(list(parameters[2 * width :]), [(address, length)] * len(parameters))
            names = self._names(self._awaited[0], address, length)
            return f"{_GROUP_READS[instruction]} {', '.join(map(str, self._awaited))}: {names}"
        if instruction in _BULK_READS:
            return self._bulk_read(_BULK_READS[instruction], parameters)
        if instruction is Instruction.BULK_WRITE:
            return f"bulk write, {len(parameters)} bytes: {parameters.hex(' ')}"
        behind = f" {parameters.hex(' ')}" if parameters else ""
        return f"{_SINGLE.get(instruction, instruction.name.lower().replace('_', ' '))} {who}{behind}"

    def _sync_write(self, parameters: bytes) -> str:
        width = self._address_bytes
        address, length = self._number(parameters), self._number(parameters[width:])
        items, step = parameters[2 * width :], 1 + length
        rows = [items[i : i + step] for i in range(0, len(items), step)]
        return f"sync write: {'; '.join(f'{row[0]} {self._values(row[0], address, row[1:])}' for row in rows)}"

    def _bulk_read(self, name: str, parameters: bytes) -> str:
        if self._two:
            rows = [parameters[i : i + 5] for i in range(0, len(parameters) - 4, 5)]
            items = [(row[0], self._number(row[1:3]), self._number(row[3:5])) for row in rows]
        else:
            rows = [parameters[i : i + 3] for i in range(1, len(parameters) - 2, 3)]
            items = [(row[1], row[2], row[0]) for row in rows]
        self._await([item[0] for item in items], [item[1:] for item in items])
        return f"{name}: {'; '.join(f'{who} {self._names(who, address, size)}' for who, address, size in items)}"

    def _await(self, ids: list[int], ranges: Sequence[tuple[int, int]]) -> None:
        self._awaited = ids
        self._asked.update(zip(ids, ranges, strict=False))

    def _status(self, frame: Frame) -> str:
        if self._two and frame.id == BROADCAST_ID:
            return self._joint_status(frame.parameters)
        if frame.id in self._awaited:
            del self._awaited[: self._awaited.index(frame.id) + 1]
        error, data = (frame.parameters[0], frame.parameters[1:]) if self._two else (frame.code, frame.parameters)
        return f"{frame.id} {self._answer(frame.id, error, data)}"

    def _joint_status(self, parameters: bytes) -> str:
        """A reply that servos have built in turn: each block is error, id, data, CRC."""
        told, position = [], 0
        for servo_id in self._awaited:
            end = position + 2 + self._asked.get(servo_id, (0, 0))[1]
            block = parameters[position:end]
            if len(block) > 1:
                told.append(f"{block[1]} {self._answer(block[1], block[0], block[2:])}")
            position = end + _CRC
        self._awaited = []
        return "; ".join(told) or f"a joint reply to nothing that was heard: {parameters.hex(' ')}"

    def _answer(self, servo_id: int, error: int, data: bytes) -> str:
        parts = []
        if self._two:
            number, alert = error & ~ALERT, error >= ALERT
        else:
            # The protocol's own reader tells conditions from refusals.
            body = bytes((servo_id, len(data) + 2, error)) + data
            found = self._receiver().feed(b"\xff\xff" + body + bytes((~sum(body) & 0xFF,)))
            number, alert = (found[0].error, found[0].alert) if found else (error, False)
        if self._pinged and not number:
            about = f": model {int.from_bytes(data[:2], 'little')}, firmware {data[2]}" if len(data) == 3 else ""
            parts.append(f"is there{about}")
            data = b""
        if number:
            parts.append(f"refuses: {self._describe(number)}")
        if alert:
            parts.append("reports a fault of its hardware" + (f" ({error:#04x})" if not self._two else ""))
        if data and servo_id in self._asked:
            parts.append(self._values(servo_id, self._asked[servo_id][0], data))
        elif data:
            parts.append(f"says {data.hex(' ')}")
        return ", ".join(parts) or "agrees"

    def _names(self, servo_id: int, address: int, length: int) -> str:
        model = self._model(servo_id)
        rows = [row.name for row in model.registers if address <= row.address and row.end <= address + length] \
            if model else []
        return ", ".join(rows) or f"{length} bytes from {address}"

    def _values(self, servo_id: int, address: int, data: bytes) -> str:
        model = self._model(servo_id)
        rows = [row for row in model.registers if address <= row.address and row.end <= address + len(data)] \
            if model else []
        if not rows:
            return f"{data.hex(' ')} at {address}"
        return ", ".join(
            f"{row.name} = {quantity.text(row, unpack(row, data[row.address - address : row.end - address]))}"
            for row in rows)

    def _model(self, servo_id: int) -> ServoModel | None:
        """Return a servo's model; of what everyone is told, any one's."""
        return next(iter(self._models.values()), None) if servo_id == BROADCAST_ID else self._models.get(servo_id)

    def _number(self, data: bytes) -> int:
        return int.from_bytes(data[: self._address_bytes], "little")
