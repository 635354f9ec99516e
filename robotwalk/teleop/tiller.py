"""What hands do, as a command: full speed, the gait and how the body is carried are kept here."""

import math
from collections.abc import Sequence

from robotwalk.settings import Heights, MotionLimits
from robotwalk.teleop.layout import CENTRED, Act, Faster, Lean, Stick
from robotwalk.types import LEVEL, STILL, Command, Twist

_START = 0.5  # of what the robot can do
_LEAST = 0.05  # of it, that full speed may be
_STEPS = 8  # from the lowest to the highest
_LEAN = math.radians(2.0)  # a step
_MOST_LEAN = math.radians(10.0)  # in each axis, assumed to be in reach at every height
_MOST_AHEAD = math.radians(30.0)  # that the wanted heading may be ahead of the body


class Tiller:
    """A person's settings.

    By turn, the stick's third axis is a turning rate. By heading, it turns the direction that the body shall face, and
    what then disturbs the body is made good; the heading lasts while the stick is off its centre.
    """

    def __init__(self, motion: MotionLimits, heights: Heights, gaits: Sequence[str], gait: str) -> None:
        """Begin at half of what the robot can do, level, in that gait of those."""
        self._motion = motion
        self._heights = heights
        self._gaits = tuple(gaits)
        self.speed, self.turn = _START * motion.speed, _START * motion.turn  # m/s, rad/s with the stick pushed home
        self.gait = gait
        self.height = heights.stand
        self.posture = LEVEL
        self.by_heading = False
        self._heading: float | None = None

    def adjust(self, what: Faster | Lean | Act) -> bool:
        """Change a setting; return whether it was one."""
        motion, heights = self._motion, self._heights
        if isinstance(what, Faster):
            self.speed = min(max(self.speed * what.linear, _LEAST * motion.speed), motion.speed)
            self.turn = min(max(self.turn * what.angular, _LEAST * motion.turn), motion.turn)
        elif isinstance(what, Lean):
            step = (heights.highest - heights.lowest) / _STEPS
            self.height = min(max(self.height + what.height * step, heights.lowest), heights.highest)
            roll, pitch, yaw = (
                min(max(angle + steps * _LEAN, -_MOST_LEAN), _MOST_LEAN)
                for angle, steps in zip(self.posture[3:], what[1:], strict=True))
            self.posture = self.posture._replace(roll=roll, pitch=pitch, yaw=yaw)
        elif what in (Act.NEXT_GAIT, Act.LAST_GAIT):
            step_to = 1 if what is Act.NEXT_GAIT else -1
            self.gait = self._gaits[(self._gaits.index(self.gait) + step_to) % len(self._gaits)]
        elif what is Act.HEADING:
            self.by_heading = not self.by_heading
            self._heading = None
        elif what is Act.LEVEL:
            self.posture, self.height = LEVEL, heights.stand
        else:
            return False
        return True

    def command(self, stick: Stick, yaw: float, dt: float) -> Command:
        """Return what the stick asks for, `dt` s after the last call, of a body that faces `yaw` (rad in odom)."""
        x, y, w = stick
        longest = max(1.0, math.hypot(x, y))
        twist = Twist(x / longest * self.speed, y / longest * self.speed, w * self.turn)
        if stick == CENTRED:
            self._heading, twist = None, STILL
        elif self.by_heading:
            heading = yaw if self._heading is None else self._heading
            ahead = min(max(heading + twist.wz * dt - yaw, -_MOST_AHEAD), _MOST_AHEAD)
            self._heading = yaw + ahead
        return Command(twist, self._heading, self.height, self.posture, self.gait)
