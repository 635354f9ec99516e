"""The governor: spares servos and battery before the servos' own protections act.

    ease    near a limit the robot walks slower and lower
    sit     nearer, it sits down while it still can

How near is a share of each servo's own limits (`safety: governor` of the robot's file). One joint is looked at in each
tick, and only readings that are new count; each level takes several that agree. Of a current it is the root mean square
of a few seconds, which is what heats the windings: a leg draws much for moments of each step. Currents ease only: a
servo bears its largest one for a while.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from robotwalk.agreement import Agreement
from robotwalk.config.safety import GovernorConfig
from robotwalk.types import Measured, ServoCondition

_NS = 1_000_000_000
_AGREEING = 3  # readings of one servo
_HYSTERESIS = 0.04  # of the limit, by which it must be better to be well again
_WORDS = {
    "heat": "is at {:.0f} degC, and lets go at {:.0f}",
    "voltage": "gets {:.1f} V, and lets go below {:.1f}",
    "current": "draws {:.1f} A rms, of {:.1f} at most",
}


class Strain(NamedTuple):
    """A quantity that comes near to a limit: shares are of the limit."""

    value: float
    limit: float
    ease: float
    sit: float | None
    low: bool  # the limit is a lowest value

    def beyond(self, share: float) -> bool:
        """Tell whether the value is as near to the limit as a share of it says."""
        return self.value < share * self.limit if self.low else self.value > share * self.limit

    def words(self, quantity: str) -> str:
        """Return how it is, to follow "the servo of lf_coxa"."""
        return _WORDS[quantity].format(self.value, self.limit)


class Governed(NamedTuple):
    """What the governor asks for."""

    eased: bool
    trouble: str | None = None  # why the robot should sit, in words
    news: str | None = None  # what has changed, in words
    weak: bool = False  # the voltage is so low that servos give far less than their efforts say


WELL = Governed(eased=False)
_UNSEEN = ServoCondition(None, None, None, None, ())


class _Gauge:
    """One quantity of one servo that has been strained."""

    def __init__(self) -> None:
        self.near = Agreement(_AGREEING, _AGREEING)
        self.nearest = Agreement(_AGREEING, _AGREEING)

    def step(self, strain: Strain) -> None:
        back = _HYSTERESIS if self.near.holds else 0.0
        self.near.step(strain.beyond(strain.ease + back if strain.low else strain.ease - back))
        if strain.sit is not None:
            self.nearest.step(strain.beyond(strain.sit))


class _MeanSquare:
    """A current's, A^2, as it was of late."""

    __slots__ = ("_over", "_since", "value")

    def __init__(self, seconds: float) -> None:
        self.value = 0.0
        self._over = seconds * _NS
        self._since: int | None = None

    def step(self, current: Measured) -> float:
        """Take a reading; return the root."""
        passed = 0 if self._since is None else current.heard - self._since
        self._since = current.heard
        self.value += passed / (passed + self._over) * (current.value * current.value - self.value)
        return math.sqrt(self.value)


class Governor:
    """Governs one robot."""

    def __init__(
        self, joints: Sequence[str], config: GovernorConfig, condition: Callable[[int], ServoCondition]
    ) -> None:
        """Look at `condition` of each joint's servo in turn: new readings are new objects."""
        self._joints = tuple(joints)
        self._config = config
        self._condition = condition
        self._seen = [_UNSEEN] * len(self._joints)  # when each was last looked at
        self._next = 0
        self._gauges: list[dict[str, _Gauge]] = [{} for _ in self._joints]
        self._currents = [_MeanSquare(config.current_over_s) for _ in self._joints]
        self._near: dict[tuple[str, str], None] = {}  # (joint, quantity), as an ordered set
        self._governed = WELL

    def step(self) -> Governed:
        """Look at the next joint."""
        index, self._next = self._next, (self._next + 1) % len(self._joints)
        before = self._governed
        if before.news is not None:
            before = self._governed = before._replace(news=None)
        condition, seen, joint = self._condition(index), self._seen[index], self._joints[index]
        if condition is seen:
            return before
        self._seen[index] = condition
        for quantity, strain in self._strains(condition, seen, self._currents[index]):
            gauge = self._gauges[index].get(quantity)
            if gauge is None:
                if not strain.beyond(strain.ease):
                    continue
                gauge = self._gauges[index][quantity] = _Gauge()
            gauge.step(strain)
            if gauge.near.holds:
                self._near[joint, quantity] = None
            else:
                self._near.pop((joint, quantity), None)
            if gauge.nearest.holds and before.trouble is None:
                before = before._replace(trouble=f"{_cause(quantity)}: the servo of {joint} {strain.words(quantity)}")
            if bool(self._near) is not before.eased:
                news = "well again: at the usual speed and height"
                if self._near:
                    news = f"slower and lower, for the servo of {joint} {strain.words(quantity)}"
                before = before._replace(eased=bool(self._near), news=news)
        weak = bool(self._near) and any(quantity == "voltage" for _, quantity in self._near)
        if weak is not before.weak:
            before = before._replace(weak=weak)
        self._governed = before
        return before

    def _strains(
        self, condition: ServoCondition, seen: ServoCondition, square: _MeanSquare
    ) -> list[tuple[str, Strain]]:
        """Return what a servo has told, since it was seen, of how near it is to its limits."""
        limits, config = condition.limits, self._config
        found = []
        heat, volts, amperes = condition.temperature, condition.voltage, condition.current
        if heat is not None and limits.hottest is not None and heat is not seen.temperature:
            found.append(("heat", Strain(heat.value, limits.hottest, config.heat_ease, config.heat_sit, False)))
        if volts is not None and limits.lowest_voltage is not None and volts is not seen.voltage:
            found.append(("voltage", Strain(
                volts.value, limits.lowest_voltage, config.voltage_ease, config.voltage_sit, True)))
        if amperes is not None and limits.largest_current is not None and amperes is not seen.current:
            found.append(("current", Strain(
                square.step(amperes), limits.largest_current, config.current_ease, None, False)))
        return found


def _cause(quantity: str) -> str:
    return {"heat": "a servo is too hot", "voltage": "the battery is nearly empty"}[quantity]
