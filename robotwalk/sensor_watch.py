"""Whether a sensor is heard that talks unasked: what a run's events tell of it."""

from collections.abc import Callable

from robotwalk.types import SensorStatistics

_SILENT = 0.5  # s of ticks; with fewer it may be the first ones after a pause


class SensorWatch:
    """Notices when a sensor falls silent, and when it is back."""

    def __init__(self, name: str, statistics: Callable[[], SensorStatistics]) -> None:
        """Watch a sensor that is called `name` in sentences."""
        self._name = name
        self._statistics = statistics
        self._heard = True
        self._heard_at = 0.0

    def step(self, valid: bool, seconds: float) -> str | None:
        """Return what is new, in words, when so many seconds of ticks have passed in all.

        `valid`: what the sensor said last still counts.
        """
        if valid:
            self._heard_at = seconds
        heard = seconds - self._heard_at < _SILENT
        if heard is self._heard:
            return None
        self._heard = heard
        if heard:
            return f"{self._name} is heard again"
        failure = self._statistics().failure
        return f"{self._name} is silent{f': {failure}' if failure else ''}"
