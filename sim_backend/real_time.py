"""Simulated time tied to the monotonic clock."""

import time

LONGEST_CATCH_UP = 50_000_000  # ns


class RealTime:
    """Says how far the simulation should be by now.

    After a stall it may catch up a little; the rest of the time lost is dropped, so that a computer that is too
    slow never answers later and later.

    Attributes:
        dropped: simulated time that never was, ns.
    """

    def __init__(self, reached: int) -> None:
        """Let simulated time go on from `reached` (ns), now."""
        self._origin = time.monotonic_ns() - reached
        self.dropped = 0

    def wall(self, simulated: int) -> int:
        """Return the monotonic time at which it is `simulated` ns."""
        return self._origin + simulated

    def target(self, reached: int) -> int:
        """Return the simulated time up to which to run, ns, from what was `reached`."""
        lag = time.monotonic_ns() - self._origin - reached
        excess = max(0, lag - LONGEST_CATCH_UP)
        self._origin += excess
        self.dropped += excess
        return reached + max(0, lag - excess)
