"""The log of a run: an MCAP file that PlotJuggler and Foxglove open.

The loop only puts a row into a queue, about a microsecond's work. A thread of its own turns rows into
messages and writes them. Rows are never dropped; a slow disk costs memory, not time.
"""

import json
import queue
import threading
from pathlib import Path
from typing import Any, NamedTuple

from mcap.writer import Writer

from robotwalk.errors import UsageError
from robotwalk.supervisor import State
from robotwalk.types import Command, JointState, Pose, Twist


class Row(NamedTuple):
    """One tick, as the loop saw it."""

    time: int  # ns on the loop's clock, at the tick's deadline
    state: State
    command: Command
    twist: Twist  # in force
    goals: tuple[float, ...]  # rad, sent in the next tick
    joints: JointState
    odometry: Pose
    wake: int  # ns late at the start
    bus: int  # ns in the exchange
    tick: int  # ns of computing


class Event(NamedTuple):
    """Something worth a line in the summary."""

    t: float  # s since the run began
    kind: str
    text: str


class Recorder:
    """Writes rows and events to an MCAP file until closed."""

    _TOPICS = ("command", "joint_states", "joint_goals", "odom", "timing", "events")

    def __init__(self, path: Path, joints: tuple[str, ...], about: dict[str, str]) -> None:
        """Open the file.

        Raises:
            UsageError: it cannot be written.
        """
        try:
            self._file = path.open("wb")
        except OSError as error:
            raise UsageError(f"cannot write the log {path}: {error.strerror}") from error
        self._failure: str | None = None
        self._joints = list(joints)
        self._writer = Writer(self._file)
        self._writer.start(library="robotwalk")
        self._writer.add_metadata("robotwalk", about)
        schema = self._writer.register_schema("object", "jsonschema", b'{"type": "object"}')
        self._channels = {
            topic: self._writer.register_channel(topic=f"/{topic}", message_encoding="json", schema_id=schema)
            for topic in self._TOPICS
        }
        self._queue: queue.SimpleQueue[Row | tuple[int, Event] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._drain, name="robotwalk-recorder", daemon=True)
        self._thread.start()

    def put(self, row: Row) -> None:
        """Take a tick's row."""
        self._queue.put(row)

    def event(self, time: int, event: Event) -> None:
        """Take an event, at `time` ns."""
        self._queue.put((time, event))

    def close(self) -> str | None:
        """Write out what is left and close the file; return what went wrong with it, if anything did."""
        self._queue.put(None)
        self._thread.join()
        try:
            with self._file:
                self._writer.finish()
        except OSError as error:
            self._failure = self._failure or f"the log is incomplete: {error.strerror}"
        return self._failure

    def _drain(self) -> None:
        while (item := self._queue.get()) is not None:
            if self._failure is not None:
                continue
            try:
                if isinstance(item, Row):
                    self._write_row(item)
                else:
                    self._write("events", item[0], item[1]._asdict())
            except Exception as error:  # a full disk is no reason to stop the robot, nor is anything else here
                self._failure = f"the log is incomplete: {error}"

    def _write_row(self, row: Row) -> None:
        command = row.command._asdict()
        command |= {"twist": row.command.twist._asdict(), "posture": row.command.posture._asdict()}
        self._write("command", row.time, {"state": row.state.value, **command, "twist_in_force": row.twist._asdict()})
        self._write("joint_states", row.time, {"name": self._joints, **row.joints._asdict()})
        self._write("joint_goals", row.time, {"name": self._joints, "position": row.goals})
        self._write("odom", row.time, row.odometry._asdict())
        timing = {"wake_us": row.wake / 1e3, "bus_us": row.bus / 1e3, "tick_us": row.tick / 1e3}
        self._write("timing", row.time, timing)

    def _write(self, topic: str, time: int, message: dict[str, Any]) -> None:
        data = json.dumps(message).encode()
        self._writer.add_message(self._channels[topic], log_time=time, publish_time=time, data=data)
