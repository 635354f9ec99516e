"""Who drives: one driver at a time, and none that is silent. `stop` is heard from anyone."""

import math

from robotwalk.teleop.ask import Ask, Wish
from robotwalk.types import STILL, Command

SILENCE = 0.5  # s without a word of the driver, and the robot stands still

_FOR_ALL = (Wish.STOP, Wish.QUIT)


class Helm:
    """Whoever asks for something while nobody drives has the helm, until it leaves or falls silent.

    Who drove when somebody said `stop` has to fall silent, too, before it may drive on: what is let go again later must
    not walk off by itself.
    """

    def __init__(self) -> None:
        self._barred: str | None = None
        self._barred_at = -math.inf  # when it was heard last
        self._driver: str | None = None
        self._heard_at = -math.inf
        self._command = Command()

    def driver(self, now: float) -> str | None:
        """Return who drives at `now` (s), if anybody does."""
        return self._driver if now - self._heard_at <= SILENCE else None

    def hear(self, ask: Ask, now: float) -> str | None:
        """Take what somebody asks for at `now` (s). Return why not, if another drives."""
        if ask.wish in _FOR_ALL:
            self._barred, self._barred_at = self.driver(now), now
            self.let_go()
            return None
        if ask.driver == self._barred and ask.wish is None and now - self._barred_at <= SILENCE:
            self._barred_at = now
            return f"stopped while it drove: it should ask for nothing for {SILENCE} s"
        driver = self.driver(now)
        if driver not in (None, ask.driver):
            return None if ask.wish is Wish.LEAVE else f"{driver} drives"
        if ask.wish is Wish.LEAVE:
            self.let_go()
            return None
        self.command(now)  # nobody goes on with what another wanted
        self._driver, self._heard_at = ask.driver, now
        if ask.command is not None:
            self._command = ask.command
        return None

    def let_go(self) -> None:
        """Have nobody drive."""
        self._driver = None
        self._heard_at = -math.inf

    def command(self, now: float) -> Command:
        """Return what the robot is to do: what its driver asked for, and with none to stand as it was told last."""
        if self.driver(now) is None:
            self._command = self._command._replace(twist=STILL, heading=None)
        return self._command
