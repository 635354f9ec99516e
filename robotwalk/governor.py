"""The governor: spares servos and battery before the servos' own protections act.

    ease    near a limit the robot walks slower and lower
    sit     nearer, it sits down while it still can

How near is a share of each servo's own limits (`safety: governor` of the robot's file). One joint is looked at in each
tick, and only readings that are new count; each level takes several that agree. Currents ease only: a servo bears its
largest one for a while.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from robotwalk.agreement import Agreement
from robotwalk.config.safety import GovernorConfig
from robotwalk.types import Measured, ServoCondition

_AGREEING = 3  # readings of one servo
_HYSTERESIS = 0.04  # of the limit, by which it must be better to be well again


class Strain(NamedTuple):
    """A quantity that comes near to a limit: shares are of the limit."""

    value: float
    limit: float
    ease: float
    sit: float | None
    low: bool  # the limit is a lowest value
    words: str  # how it is, to follow "the servo of lf_coxa"

    def beyond(self, share: float) -> bool:
        """Tell whether the value is as near to the limit as a share of it says."""
        return self.value < share * self.limit if self.low else self.value > share * self.limit


class Governed(NamedTuple):
    """What the governor asks for."""

    eased: bool
    trouble: str | None = None  # why the robot should sit, in words
    news: str | None = None  # what has changed, in words
    weak: bool = False  # the voltage is so low that servos give far less than their efforts say


WELL = Governed(eased=False)


class _Gauge:
    """One quantity of one servo."""

    def __init__(self) -> None:
        self.near = Agreement(_AGREEING, _AGREEING)
        self.nearest = Agreement(_AGREEING, _AGREEING)

    def step(self, strain: Strain) -> None:
        back = _HYSTERESIS if self.near.holds else 0.0
        self.near.step(strain.beyond(strain.ease + back if strain.low else strain.ease - back))
        if strain.sit is not None:
            self.nearest.step(strain.beyond(strain.sit))


class Governor:
    """Governs one robot."""

    def __init__(
        self, joints: Sequence[str], config: GovernorConfig, condition: Callable[[int], ServoCondition], dt: float
    ) -> None:
        """Look at `condition` of each joint's servo in turn, once every `dt` s."""
        self._joints = tuple(joints)
        self._config = config
        self._condition = condition
        self._turn = len(self._joints) * dt  # s from one look at a joint to the next
        self._next = 0
        self._gauges: list[dict[str, _Gauge]] = [{} for _ in self._joints]
        self._near: dict[tuple[str, str], None] = {}  # (joint, quantity), as an ordered set
        self._governed = WELL

    def step(self) -> Governed:
        """Look at the next joint."""
        index, self._next = self._next, (self._next + 1) % len(self._joints)
        before = self._governed
        if before.news is not None:
            before = self._governed = before._replace(news=None)
        condition, joint = self._condition(index), self._joints[index]
        for quantity, measured, strain in self._strains(condition):
            if measured.age > self._turn:
                continue
            gauge = self._gauges[index].setdefault(quantity, _Gauge())
            gauge.step(strain)
            if gauge.near.holds:
                self._near[joint, quantity] = None
            else:
                self._near.pop((joint, quantity), None)
            if gauge.nearest.holds and before.trouble is None:
                before = before._replace(trouble=f"{_cause(quantity)}: the servo of {joint} {strain.words}")
            if bool(self._near) is not before.eased:
                news = "well again: at the usual speed and height"
                if self._near:
                    news = f"slower and lower, for the servo of {joint} {strain.words}"
                before = before._replace(eased=bool(self._near), news=news)
            weak = any(quantity == "voltage" for _, quantity in self._near)
            if weak is not before.weak:
                before = before._replace(weak=weak)
        self._governed = before
        return before

    def _strains(self, condition: ServoCondition) -> list[tuple[str, Measured, Strain]]:
        limits, config = condition.limits, self._config
        found = []
        heat, volts, amperes = condition.temperature, condition.voltage, condition.current
        if heat is not None and limits.hottest is not None:
            words = f"is at {heat.value:.0f} degC, and lets go at {limits.hottest:.0f}"
            found.append(("heat", heat, Strain(
                heat.value, limits.hottest, config.heat_ease, config.heat_sit, False, words)))
        if volts is not None and limits.lowest_voltage is not None:
            words = f"gets {volts.value:.1f} V, and lets go below {limits.lowest_voltage:.1f}"
            found.append(("voltage", volts, Strain(
                volts.value, limits.lowest_voltage, config.voltage_ease, config.voltage_sit, True, words)))
        if amperes is not None and limits.largest_current is not None:
            value = abs(amperes.value)
            words = f"draws {value:.1f} A, of {limits.largest_current:.1f} at most"
            found.append(("current", amperes, Strain(
                value, limits.largest_current, config.current_ease, None, False, words)))
        return found


def _cause(quantity: str) -> str:
    return {"heat": "a servo is too hot", "voltage": "the battery is nearly empty"}[quantity]
