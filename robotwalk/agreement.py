"""One reading is none: what is believed is what several in a row agree on."""

_AGREEING = 5  # ticks


class Agreement:
    """Believes what the last few readings say; until they agree it stays with what it believed."""

    def __init__(self, enter: int = _AGREEING, leave: int = 1) -> None:
        """Take as many readings in a row to `enter`, and to `leave`."""
        self.holds = False
        self._needed = {True: enter, False: leave}
        self._against = 0

    def step(self, reading: bool) -> bool:
        """Take a reading; return what is believed now."""
        self._against = self._against + 1 if reading is not self.holds else 0
        if self._against >= self._needed[reading]:
            self.holds, self._against = reading, 0
        return self.holds
