"""Goals that make a servo arrive where it should be, when it should.

A position servo near rest is a spring, a damper and a mass with dry friction: it follows its goal with the lag and
the overshoot of `goal = q + damping q' + inertia q'' + friction sgn q' + torque / stiffness`. Sending that goal for
the wanted q undoes them. Without it a walking robot strides longer than told where the joints overshoot, and shorter
where a soft servo loses some of its way to friction at each turn; and its body hangs lower than told, and tilts as its
legs take turns at bearing it.
"""

import math
from collections.abc import Sequence

from robotwalk.types import DriveResponse

_CREEP = 0.1  # rad/s, below which friction is overcome in part only: sgn without its step


class Feedforward:
    """Inverts the drives' response, with differences of the wanted angles over the ticks."""

    def __init__(self, responses: Sequence[DriveResponse], *, lag: bool = True, load: bool = True) -> None:
        """Undo the drives' lag (damping, inertia, friction), and what a load takes over their stiffness."""
        if not lag:
            responses = [drive._replace(damping=0.0, inertia=0.0, friction=0.0) for drive in responses]
        if not load:
            responses = [drive._replace(stiffness=math.inf) for drive in responses]
        self._responses = tuple((drive.damping, drive.inertia, drive.friction, drive.stiffness) for drive in responses)
        self._last: Sequence[float] = ()
        self._before: Sequence[float] = ()

    def reset(self, positions: Sequence[float]) -> None:
        """Start at rest."""
        self._last = self._before = tuple(positions)

    def step(self, wanted: Sequence[float], torques: Sequence[float], dt: float) -> list[float]:
        """Return the goals for the wanted angles, `dt` s after the last ones; the joints bear `torques`, N m."""
        goals, square = [], dt * dt
        for q, q1, q2, torque, (damping, inertia, friction, stiffness) in zip(
            wanted, self._last, self._before, torques, self._responses, strict=True,
        ):
            speed = (q - q1) / dt
            acceleration = (q - 2.0 * q1 + q2) / square
            direction = speed / _CREEP if -_CREEP < speed < _CREEP else 1.0 if speed > 0.0 else -1.0
            goals.append(q + damping * speed + inertia * acceleration + friction * direction + torque / stiffness)
        self._before, self._last = self._last, wanted
        return goals
