"""Goals that make a servo arrive where it should be, when it should.

A position servo near rest is a spring, a damper and a mass: it follows its goal with the lag and the overshoot
of `goal = q + damping q' + inertia q''`. Sending that goal for the wanted q undoes both. Without it a walking
robot strides longer than told: the joints overshoot, they do not merely lag.
"""

from collections.abc import Sequence

from robotwalk.types import DriveResponse


class Feedforward:
    """Inverts the drives' response, with differences of the wanted angles over the ticks."""

    def __init__(self, responses: Sequence[DriveResponse]) -> None:
        self._responses = tuple(responses)
        self._last: Sequence[float] = ()
        self._before: Sequence[float] = ()

    def reset(self, positions: Sequence[float]) -> None:
        """Start at rest."""
        self._last = self._before = tuple(positions)

    def step(self, wanted: Sequence[float], dt: float) -> list[float]:
        """Return the goals for the wanted angles, `dt` s after the last ones."""
        goals = []
        for q, q1, q2, response in zip(wanted, self._last, self._before, self._responses, strict=True):
            speed = (q - q1) / dt
            acceleration = (q - 2.0 * q1 + q2) / (dt * dt)
            goals.append(q + response.damping * speed + response.inertia * acceleration)
        self._before, self._last = self._last, wanted
        return goals
