"""Servos that have let go or fallen silent: the body is lowered, they are brought back, the robot gets up again.

    patient    its servo let go: an overload, or it lost power for a moment; or it does not answer
    treatment  once the body is down: `ServoBus.revive`, one after the other
    given up   it cannot be brought back, or has had as many treatments of late as the robot's file allows

What cannot be mended so, such as heat, is no case for this.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from robotwalk.config.safety import RecoveryConfig
from robotwalk.ports import Revival, ServoBus


class Treatment(NamedTuple):
    """How far it is."""

    helping: str | None  # why the body is down, or should come down; None: nobody is a patient
    lost: Mapping[int, str]  # joints whose servos are given up, and why
    news: tuple[tuple[str, str], ...] = ()  # kind, and what happened in words


NOBODY = Treatment(None, {})


class Recovery:
    """Looks after the servos of one robot."""

    def __init__(self, joints: Sequence[str], bus: ServoBus, config: RecoveryConfig, rate_hz: int) -> None:
        self._joints = tuple(joints)
        self._bus = bus
        self._most = config.tries
        self._forget = round(config.forget_after_s * rate_hz)
        self._tick = 0
        self._tries: dict[int, list[int]] = {}  # when, by joint
        self._patients: dict[int, str] = {}
        self._revival: tuple[int, Revival] | None = None
        self._lost: dict[int, str] = {}
        self._hopeless: set[int] = set()

    @property
    def patients(self) -> Collection[int]:
        """Those who wait for it, or are under it."""
        return self._patients.keys()

    @property
    def lost(self) -> Collection[int]:
        """Those whose servos were given up."""
        return self._lost.keys()

    def dismiss(self) -> None:
        """Treat nobody any more: the robot comes down for something else, and stays there."""
        self._patients.clear()
        self._revival = None

    def let_go(self) -> None:
        """Think of those that were given up no more: the robot goes on without them."""
        self._lost.clear()

    def step(self, found: Mapping[int, str], *, seated: bool, hopeless: Collection[int] = ()) -> Treatment:
        """Go on by a tick.

        Args:
            found: joints whose servos need help, and why, in words.
            seated: whether the body is down for them.
            hopeless: those among them that no treatment helps.
        """
        self._tick += 1
        self._hopeless.update(hopeless)
        if not (found or self._patients):
            return NOBODY
        news = []
        for slot, words in found.items():
            if slot in self._patients or slot in self._lost:
                continue
            tried = [tick for tick in self._tries.get(slot, ()) if self._tick - tick < self._forget]
            if len(tried) >= self._most:
                tries = f", after {self._most} {'try' if self._most == 1 else 'tries'}" if self._most else ""
                self._lost[slot] = words + tries
            else:
                self._tries[slot] = [*tried, self._tick]
                self._patients[slot] = words
                news.append(("mend", f"lying down: {words}"))
        if seated and self._patients:
            news += self._treat()
        return Treatment(
            "; ".join(self._patients.values()) or None, dict(self._lost) if self._lost else {}, tuple(news))

    def _treat(self) -> list[tuple[str, str]]:
        """Treat one after the other."""
        if self._revival is None:
            slot = next(iter(self._patients))
            if slot in self._hopeless:
                self._lost[slot] = self._patients.pop(slot)
                return []
            self._revival = slot, self._bus.revive(slot)
            return []
        slot, revival = self._revival
        if not revival.over:
            return []
        self._revival = None
        words, joint = self._patients.pop(slot), self._joints[slot]
        if revival.failure is None:
            return [("mend", f"the servo of {joint} holds again")]
        self._lost[slot] = f"{words}, and cannot be brought back: {revival.failure}"
        return [("mend", f"the servo of {joint} cannot be brought back: {revival.failure}")]
