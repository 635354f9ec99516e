"""Keeps the heading: what the turning rates add up to is compared with what odometry has seen of it.

Legs that differ a little, by their servos' gains or friction, walk an arc where they should walk straight. The
standing feet show it. Small errors are left alone: odometry lags behind the body by a few ticks and sways with
its steps.
"""

import math

from robotwalk.types import STILL, Twist

_LEFT_ALONE = math.radians(1.0)
_GAIN = 1.0  # rad/s per rad beyond that
_LARGEST = math.radians(6.0)  # per second


class Steering:
    """Corrects the turning rate of a robot that walks without a heading to hold."""

    def __init__(self) -> None:
        self._heading: float | None = None  # rad, in odom; None while there is nothing to keep

    def step(self, twist: Twist, yaw: float, dt: float, *, held: bool) -> Twist:
        """Return the twist to walk with.

        Args:
            twist: the shaped one.
            yaw: by odometry, rad.
            dt: s since the last step.
            held: whether to let the turning rate be: it comes from a heading to hold, or odometry is not to be trusted.
        """
        if twist == STILL or held:
            self._heading = None
            return twist
        if self._heading is None:
            self._heading = yaw
        self._heading += twist.wz * dt
        error = self._heading - yaw
        excess = error - min(max(error, -_LEFT_ALONE), _LEFT_ALONE)
        if excess == 0.0:
            return twist
        return Twist(twist.vx, twist.vy, twist.wz + min(max(_GAIN * excess, -_LARGEST), _LARGEST))
