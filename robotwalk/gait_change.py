"""From one gait to another while the robot walks: at a phase that the standing feet can wait for.

A gait takes over once the body is slow enough for it. A dynamic one begins with the body in its place, and ends on all
feet: on those that stand in mid-rock the body would go on and over.
"""

from collections.abc import Iterable

from robotwalk.body import Body
from robotwalk.gait import Gait, GaitClock
from robotwalk.stance import Stance
from robotwalk.types import Pose, Twist

_BESIDE = 5e-3  # m off its place at which the body is in it
_ROUNDING = 1e-9


class GaitChange:
    """Changes one robot's gait.

    Attributes:
        landing: the feet come down before a dynamic gait is left; none lifts off.
    """

    def __init__(self, clock: GaitClock, body: Body, stance: Stance) -> None:
        self._clock = clock
        self._body = body
        self._stance = stance
        self._setting_off = False
        self.landing = False

    def set_off(self) -> None:
        """Begin to walk, from standing."""
        self._setting_off = True

    def step(
        self, gait: Gait, now: Twist, course: Pose, posture: Pose, part: float, *, planted: Iterable[bool], idle: bool
    ) -> float:
        """Go over to a gait if that is possible in this tick.

        Args:
            gait: to go on in; nothing happens if it is the present one.
            now: the body's twist.
            course: of the body, in odom, over the ground that its feet stand on.
            posture: to go for.
            part: of the usual strides, that there is room for.
            planted: which feet stand.
            idle: the robot does not walk.

        Returns:
            The share of the present twist, 0 to 1, at which the feet could; 1 also while only the body has to slow down
            to what the gait can do at all.
        """
        self.landing = False
        if gait is self._clock.gait or gait.largest_scale(now, part) < 1.0 - _ROUNDING:
            return 1.0
        ready, phase = self._stance.entry(self._clock, gait, course, now)
        if ready >= 1.0 and (idle or not gait.dynamic or self._in_place(posture)):
            self.landing = self._clock.gait.dynamic and not all(planted)
            if not self.landing:
                self._clock.change(gait, phase)
        return ready

    def waits(self, posture: Pose) -> bool:
        """Tell whether the body must not yet tip: it set off in a dynamic gait, and is still beside its place.

        Once it has been there it must go on, wherever it is.
        """
        self._setting_off = self._setting_off and self._clock.gait.dynamic and not self._in_place(posture)
        return self._setting_off

    def _in_place(self, posture: Pose) -> bool:
        return self._body.shifted_from(posture) <= _BESIDE
