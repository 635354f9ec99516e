"""The log of a run, read back: what `robotwalk.recorder` has written, as far as the file goes."""

import itertools
import json
import struct
from collections import defaultdict, deque
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, NamedTuple

from mcap.exceptions import EndOfFile
from mcap.records import Attachment, Channel, Message, Metadata
from mcap.stream_reader import StreamReader

from robotwalk.errors import UsageError
from robotwalk.tape import Call, Concluded, Failed, Now, Received, Sent, Step, Wait
from robotwalk.types import Command, JointState, Pose, Twist

_TAPE, _BUS, _STATES = "/tape", "/bus/", "/joint_states"
_LARGEST_RECORD = 1 << 28  # bytes; a length beyond it is damage


class Traffic(NamedTuple):
    """Bytes that went over a bus at once."""

    time: int  # ns on the loop's clock
    bus: str
    sent: bool  # by us; else received
    data: bytes


class Log:
    """A log that can be read once, from front to end. Use it in a `with` block.

    Attributes:
        about: what the run was of, by name.
        files: the text of the robot's files, by name.
        damage: how the file ends other than it should, known at its end; None if it is whole.
    """

    def __init__(self, path: Path) -> None:
        """Open a log and read its head.

        Raises:
            UsageError: there is none, or it is no log of ours.
        """
        self.about: dict[str, str] = {}
        self.files: dict[str, str] = {}
        self.damage: str | None = None
        self._path = path
        self._topics: dict[int, str] = {}
        try:
            self._file: IO[bytes] = path.open("rb")
        except OSError as error:
            raise UsageError(f"cannot read the log {path}: {error.strerror}") from error
        messages = self._read(StreamReader(self._file, validate_crcs=True, record_size_limit=_LARGEST_RECORD))
        # What is before the first message is the head.
        first = list(itertools.islice(messages, 1))
        self._messages = itertools.chain(first, messages)
        if not (self.about and self.files):
            self._file.close()
            raise UsageError(
                f"{path} is no log of robotwalk" + (f": {self.damage}" if self.damage else " that has the bus in it"))

    def __enter__(self) -> "Log":
        return self

    def __exit__(self, *exception: object) -> None:
        self._file.close()

    def steps(self) -> Iterator[Step]:
        """Return the tape.

        Raises:
            UsageError: it is of another version.
        """
        before: dict[str, deque[tuple[int, dict[str, Any]]]] = defaultdict(deque)  # messages, by topic
        with self._understood():
            for time, topic, fields in self._contents(_STATES):
                if topic == _TAPE:
                    for step in fields["steps"]:
                        yield _step(step, before)
                else:
                    before[topic].append((time, fields))

    def traffic(self) -> Iterator[Traffic]:
        """Return the bytes.

        Raises:
            UsageError: the log is of another version.
        """
        with self._understood():
            for time, topic, fields in self._contents():
                if topic != _TAPE:
                    bus, _, way = topic.removeprefix(_BUS).rpartition("/")
                    yield Traffic(time, bus, way == "tx", bytes.fromhex(fields["bytes"]))

    @contextmanager
    def _understood(self) -> Iterator[None]:
        try:
            yield
        except (LookupError, TypeError, ValueError, AttributeError) as error:
            raise UsageError(f"{self._path} was written by another version: {error!r} is not understood") from error

    def _contents(self, *others: str) -> Iterator[tuple[int, str, dict[str, Any]]]:
        """Return (time, topic, fields) of every message of the tape, the buses and some other topics."""
        for message in self._messages:
            topic = self._topics.get(message.channel_id, "")
            if topic == _TAPE or topic.startswith(_BUS) or topic in others:
                yield message.log_time, topic, json.loads(message.data)

    def _read(self, reader: StreamReader) -> Iterator[Message]:
        """Return the messages up to the end, or to the first record that cannot be read."""
        try:
            for record in reader.records:
                match record:
                    case Message():
                        yield record
                    case Channel():
                        self._topics[record.id] = record.topic
                    case Metadata(name="robotwalk"):
                        self.about = record.metadata
                    case Attachment():
                        self.files[record.name] = record.data.decode()
        except (EndOfFile, struct.error):  # the latter in the middle of a record's head
            self.damage = "it breaks off"
        except Exception as error:  # whatever damage makes of a parser
            self.damage = f"it is damaged ({error})"


def _step(written: list[Any], before: dict[str, deque[tuple[int, dict[str, Any]]]]) -> Step:
    """Return a step of the tape; what it holds may lie in a message before it."""
    match written:
        case ["now", time]:
            return Now(time)
        case ["wait", deadline]:
            return Wait(deadline)
        case [("tx" | "rx") as way, bus, size]:
            kind = Sent if way == "tx" else Received
            time, fields = before[f"{_BUS}{bus}/{way}"].popleft() if size else (0, {"bytes": ""})
            return kind(bus, time, bytes.fromhex(fields["bytes"]))
        case ["failed", bus, reason]:
            return Failed(bus, reason)
        case ["joints"]:
            _, fields = before[_STATES].popleft()
            return Concluded(JointState(*(tuple(fields[name]) for name in JointState._fields)))
        case ["do", "command", fields]:
            twist, posture = Twist(**fields["twist"]), Pose(**fields["posture"])
            return Call("command", Command(**(fields | {"twist": twist, "posture": posture})))
        case ["do", name, argument]:
            return Call(name, argument)
    raise ValueError(written)
