"""The log of a run: an MCAP file that PlotJuggler and Foxglove open, and `robotwalk.log` reads.

The loop only puts a row into a queue, about a microsecond's work, and the tape's steps of a tick. A thread of
its own turns them into messages and writes them. Nothing is dropped; a slow disk costs memory, not time.

    /command ... /events      a message a tick, for people
    /bus/NAME/tx, /bus/NAME/rx    the bytes, with their times
    /tape                     the order of all steps; bytes and joint states lie in the messages before it
    attachments               the robot's files, as they were
"""

import json
import math
import queue
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from mcap.writer import Writer

from robotwalk.errors import UsageError
from robotwalk.stability import Stability
from robotwalk.supervisor import State
from robotwalk.tape import Call, Concluded, Failed, Now, Received, Sent, Step, Tape, Wait
from robotwalk.types import Command, FootSwitch, ImuState, JointState, Pose, Twist

_CHUNK = 1 << 16  # bytes; what a crash may cost, some seconds of a walk
_OBJECT = b'{"type": "object"}'
_BYTES = b'{"type": "object", "properties": {"bytes": {"type": "string", "description": "hexadecimal"}}}'


class Row(NamedTuple):
    """One tick, as the loop saw it."""

    time: int  # ns on the loop's clock, at the tick's deadline
    state: State
    command: Command
    twist: Twist  # in force
    goals: tuple[float, ...]  # rad, sent in the next tick
    joints: JointState
    odometry: Pose
    stability: Stability | None
    wake: int | None = None  # ns late at the start; None: not told
    bus: int = 0  # ns in the exchange, and with the sensors
    tick: int = 0  # ns of computing
    imu: ImuState | None = None
    switches: tuple[FootSwitch, ...] = ()


class Event(NamedTuple):
    """Something worth a line in the summary."""

    t: float  # s since the run began
    kind: str
    text: str


class Recorder:
    """Writes rows, events and the tape to an MCAP file until closed.

    Attributes:
        tape: what is put onto it is recorded.
        dropped: how many records of a loop elsewhere found no room on their way here.
    """

    _TOPICS = (
        "command", "joint_states", "joint_goals", "odom", "stability", "imu", "foot_switches", "timing", "events",
        "tape")

    def __init__(
        self, path: Path, joints: tuple[str, ...], about: dict[str, str], *,
        buses: Sequence[str] = (), files: Mapping[str, str] | None = None,
    ) -> None:
        """Open the file; `files` are kept in it, by their names.

        Raises:
            UsageError: it cannot be written.
        """
        try:
            self._file = path.open("wb")
        except OSError as error:
            raise UsageError(f"cannot write the log {path}: {error.strerror}") from error
        self._failure: str | None = None
        self.dropped = 0
        self._joints = list(joints)
        self._writer = Writer(self._file, chunk_size=_CHUNK)
        self._writer.start(library="robotwalk")
        self._writer.add_metadata("robotwalk", about)
        for name, text in (files or {}).items():
            self._writer.add_attachment(0, 0, name, "application/yaml", text.encode())
        self._channels = self._register(_OBJECT, self._TOPICS)
        self._channels |= self._register(_BYTES, [f"bus/{bus}/{way}" for bus in buses for way in ("tx", "rx")])
        self._queue: queue.SimpleQueue[Row | tuple[int, Event] | list[Step] | None] = queue.SimpleQueue()
        self._time = 0  # ns, of the last step
        self.tape = Tape(self._queue.put)
        self._thread = threading.Thread(target=self._drain, name="robotwalk-recorder", daemon=True)
        self._thread.start()

    def put(self, row: Row) -> None:
        """Take a tick's row."""
        self._queue.put(row)
        self.tape.add(Concluded(row.joints))

    def take(self, item: Row | list[Step]) -> None:
        """Take a row, or steps of the tape, of a loop that runs elsewhere."""
        self._queue.put(item)

    def show(self, row: Row) -> None:
        """Take a tick's row for people, and nothing that a replay needs."""
        self._queue.put(row)

    def event(self, time: int, event: Event) -> None:
        """Take an event, at `time` ns."""
        self._queue.put((time, event))

    def close(self) -> str | None:
        """Write out what is left and close the file; return what went wrong with it, if anything did."""
        self.tape.cut()
        self._queue.put(None)
        self._thread.join()
        try:
            with self._file:
                self._writer.finish()
        except OSError as error:
            self._failure = self._failure or f"the log is incomplete: {error.strerror}"
        if self.dropped:
            self._failure = self._failure or (
                f"the log is incomplete: {self.dropped} of the loop's records found no room on their way to it")
        return self._failure

    def _register(self, schema: bytes, topics: Sequence[str]) -> dict[str, int]:
        number = self._writer.register_schema("object", "jsonschema", schema)
        return {
            topic: self._writer.register_channel(topic=f"/{topic}", message_encoding="json", schema_id=number)
            for topic in topics
        }

    def _drain(self) -> None:
        while (item := self._queue.get()) is not None:
            if self._failure is not None:
                continue
            try:
                if isinstance(item, Row):
                    self._write_row(item)
                elif isinstance(item, list):
                    self._write_steps(item)
                else:
                    self._write("events", item[0], item[1]._asdict())
            except Exception as error:  # a full disk is no reason to stop the robot, nor is anything else here
                self._failure = f"the log is incomplete: {error}"

    def _write_row(self, row: Row) -> None:
        command = {"state": row.state.value, **_command_fields(row.command), "twist_in_force": row.twist._asdict()}
        self._write("command", row.time, command)
        self._write("joint_states", row.time, {"name": self._joints, **row.joints._asdict()})
        self._write("joint_goals", row.time, {"name": self._joints, "position": row.goals})
        self._write("odom", row.time, row.odometry._asdict())
        if row.stability is not None:
            self._write("stability", row.time, {
                "margin_m": row.stability.margin, "standing_feet": len(row.stability.standing),
                "centre_of_mass": row.stability.centre._asdict()})
        if row.imu is not None:
            self._write("imu", row.time, _imu_fields(row.imu))
        if row.switches:
            closed, age = zip(*((switch.closed, _finite(switch.age)) for switch in row.switches), strict=True)
            self._write("foot_switches", row.time, {"closed": closed, "age": age})
        if row.wake is None:
            return
        timing = {"wake_us": row.wake / 1e3, "bus_us": row.bus / 1e3, "tick_us": row.tick / 1e3}
        self._write("timing", row.time, timing)

    def _write_steps(self, steps: Sequence[Step]) -> None:
        """Write the bytes first, each with its time, then what says in which order all happened."""
        written: list[list[Any]] = []
        for step in steps:
            match step:
                case Sent(bus, time, data) | Received(bus, time, data):
                    way = "tx" if isinstance(step, Sent) else "rx"
                    written.append([way, bus, len(data)])
                    if data:
                        self._write(f"bus/{bus}/{way}", time, {"bytes": data.hex(" ")})
                case Now(time):
                    self._time = time
                    written.append(["now", time])
                case Wait(deadline):
                    written.append(["wait", deadline])
                case Failed(bus, reason):
                    written.append(["failed", bus, reason])
                case Concluded():
                    written.append(["joints"])
                case Call(name, argument):
                    written.append(["do", name, _command_fields(argument) if name == "command" else argument])
        self._write("tape", self._time, {"steps": written})

    def _write(self, topic: str, time: int, message: dict[str, Any]) -> None:
        data = json.dumps(message).encode()
        self._writer.add_message(self._channels[topic], log_time=time, publish_time=time, data=data)


def _command_fields(command: Command) -> dict[str, Any]:
    return command._asdict() | {"twist": command.twist._asdict(), "posture": command.posture._asdict()}


def _imu_fields(imu: ImuState) -> dict[str, Any]:
    vectors = {"angular_velocity": imu.angular_velocity, "acceleration": imu.acceleration}
    return imu._asdict() | {name: vector and vector._asdict() for name, vector in vectors.items()}


def _finite(seconds: float) -> float | None:
    """Return a time as JSON has it: it knows no infinity."""
    return seconds if math.isfinite(seconds) else None
