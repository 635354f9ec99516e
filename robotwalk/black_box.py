"""The black box: the last minute of a run, always kept in memory, and saved when the robot stops for its safety.

It lies in the driver's process, which gets every tick, and outlives the loop's. What it saves is a log as
`robotwalk.recorder` writes it, which PlotJuggler and Foxglove open, but without the bytes and without a tape.
"""

import os
import pickle
from collections import deque
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path

from robotwalk.errors import UsageError
from robotwalk.loop import Tick
from robotwalk.recorder import Event, Recorder, Row
from robotwalk.types import Command

SECONDS = 60  # that are kept
_SLOT = 1024  # bytes, of which a row takes as many as it needs
_KEPT = 20  # files of one robot; the oldest go


def folder() -> Path:
    """Return where they are saved: ~/.local/state, or what XDG_STATE_HOME says (XDG Base Directory Specification)."""
    state = os.environ.get("XDG_STATE_HOME", "")
    return (Path(state) if state.startswith("/") else Path.home() / ".local" / "state") / "robotwalk"


class BlackBox:
    """Keeps the last rows of one run, packed; nothing grows beyond them."""

    def __init__(
        self, where: Path, about: Mapping[str, str], files: Mapping[str, str], joints: tuple[str, ...], rate_hz: int
    ) -> None:
        """Keep them for a file in the folder `where`; `about` and `files` go into it, as into any log."""
        self._where = where
        self._about = dict(about)
        self._files = dict(files)
        self._joints = joints
        self._rows: deque[bytes] = deque(maxlen=SECONDS * rate_hz)

    def add(self, tick: Tick, command: Command) -> None:
        """Take a tick, and what its driver wanted."""
        seen = tick.estimate
        # As objects a row would take more memory, and have the garbage collector look at a hundred of them.
        row = pickle.dumps(Row(
            tick.time, tick.state, command, tick.wanted.twist, tick.goals, tick.joints, seen.pose, tick.stability,
            imu=seen.imu, switches=seen.switches), pickle.HIGHEST_PROTOCOL)
        # Equally long, or memory would be split ever finer. What follows its end is no matter to pickle.
        self._rows.append(row.ljust(-(-len(row) // _SLOT) * _SLOT))

    def save(self, reason: str, events: Sequence[Event]) -> str:
        """Write all to a new file; return where it is, or why not, in words. Never raises."""
        try:
            path = self._write(reason, events)
        except (OSError, UsageError) as error:
            return f"the black box could not be saved: {error}"
        return f"the black box, with what happened before: {path}"

    def _write(self, reason: str, events: Sequence[Event]) -> Path:
        self._where.mkdir(parents=True, exist_ok=True)
        robot = self._about.get("robot", "robot")
        path = self._where / f"{robot}-{datetime.now():%Y%m%d-%H%M%S-%f}.mcap"
        recorder = Recorder(path, self._joints, {**self._about, "black_box": reason}, files=self._files)
        last = 0
        for packed in self._rows:
            row: Row = pickle.loads(packed)
            recorder.show(row)
            last = row.time
        for event in events:
            recorder.event(last, event)
        failure = recorder.close()
        if failure is not None:
            raise UsageError(failure)
        for old in sorted(self._where.glob(f"{robot}-*.mcap"))[:-_KEPT]:
            old.unlink()
        return path
