"""What has happened in a run: its events, in the log and the black box too."""

import contextlib
from collections.abc import Callable, Iterator, Mapping

from robotwalk.barriers import Barrier, Kind
from robotwalk.black_box import BlackBox
from robotwalk.cycle import SensorReports
from robotwalk.estimator import Estimate
from robotwalk.loop import Tick
from robotwalk.recorder import Event, Recorder
from robotwalk.sensor_watch import SensorWatch
from robotwalk.types import Command

_STOPS = ("safety_stop", "stop", "timeout", "freeze")  # events after which the black box is saved
_BARRED: Mapping[Kind, str] = {
    "edge": "a foot found no ground ahead: stopped",
    "obstacle": "feet cannot step over what holds them back: stopped"}


def _imu_heard(seen: Estimate) -> bool:
    return seen.imu is not None and seen.imu.valid


def _switches_heard(seen: Estimate) -> bool:
    return any(switch.closed is not None for switch in seen.switches)


class Chronicle:
    """Collects events, and never keeps the robot from being stopped: what fails here is an event itself.

    Attributes:
        events: all so far.
        black_box: what keeps the last minute, and is saved when the robot stops for its safety; None: nothing does.
    """

    def __init__(
        self, recorder: Recorder | None, imu: SensorReports | None, foot_switches: SensorReports | None,
    ) -> None:
        """Begin; `recorder` writes the log, and of the sensors it is told when they fall silent."""
        self.events: list[Event] = []
        self.black_box: BlackBox | None = None
        self._recorder = recorder
        self._watches: list[tuple[str, SensorWatch, Callable[[Estimate], bool]]] = []
        if imu is not None:
            self._watches.append(("imu", SensorWatch("the IMU", imu.statistics), _imu_heard))
        if foot_switches is not None:
            watch = SensorWatch("the foot-switch board", foot_switches.statistics)
            self._watches.append(("feet", watch, _switches_heard))
        self._seconds = 0.0
        self._time = 0  # ns, of the last tick
        self._barred: Barrier | None = None
        self._recalled: str | None = None

    def add(self, tick: Tick, command: Command, dt: float) -> None:
        """Note what is new in a tick, `dt` s after the one before, in which `command` was in force."""
        self._time = tick.time
        if self.black_box is not None:
            try:
                self.black_box.add(tick, command)
            except Exception as error:
                self.black_box = None
                self.note("error", f"in the black box: {error!r}")
        for kind, text in tick.news:
            self.note(kind, text)
        barred, self._barred = self._barred, tick.wanted.barred
        if self._barred is not None and self._barred != barred:
            self.note(self._barred.kind, _BARRED[self._barred.kind])
        recalled, self._recalled = self._recalled, tick.wanted.recalled
        if self._recalled is not None and self._recalled != recalled:
            self.note("stance", self._recalled)
        self._seconds += dt
        for kind, watch, heard in self._watches:
            news = watch.step(heard(tick.estimate), self._seconds)
            if news is not None:
                self.note(kind, news)

    def note(self, kind: str, text: str) -> None:
        """Add an event."""
        event = Event(round(self._seconds, 3), kind, text)
        self.events.append(event)
        if self._recorder is not None:
            with self.noting("in the log"):
                self._recorder.event(self._time, event)
        if kind in _STOPS and self.black_box is not None:
            with self.noting("in the black box"):
                self.note("black_box", self.black_box.save(text, self.events))

    @contextlib.contextmanager
    def noting(self, where: str) -> Iterator[None]:
        """Make an event, and no more, of an error that must not keep the robot from being stopped."""
        try:
            yield
        except Exception as error:
            # Straight to the list: it may be the log that failed.
            self.events.append(Event(round(self._seconds, 3), "error", f"{where}: {error!r}"))

    def close(self) -> None:
        """End the log."""
        with self.noting("in the log"):
            failure = self._recorder.close() if self._recorder is not None else None
            self._recorder = None
            if failure is not None:
                self.note("log", failure)
