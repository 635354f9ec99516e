"""Falls: noticed by the IMU where there is one, else by legs that bear nothing though they should bear the robot.

What joints tell is a share: the torques that their efforts show, over those with which they would bear the body at
rest, averaged for long enough to take in a gait's own ups and downs. A robot on its feet has about 1, one on its side
or back near 0. It says nothing while the body is on the ground anyway, and is not asked where legs stand so straight
below the body that motors bear little of it: such a robot needs an IMU to know that it fell.
"""

import math
from collections.abc import Sequence

from robotwalk.agreement import Agreement
from robotwalk.config.safety import FallConfig
from robotwalk.model import RobotModel
from robotwalk.statics import GRAVITY
from robotwalk.types import DriveResponse, ImuState

_AVERAGED = 0.4  # s
_SPREAD = 0.8  # of its height, that legs must reach out for their motors to bear the body
_NONE = 0.1  # of weight times reach; torques below that bear nothing


class FallWatch:
    """Watches one robot."""

    def __init__(self, model: RobotModel, drives: Sequence[DriveResponse], config: FallConfig, dt: float) -> None:
        reaches = [
            math.hypot(leg.rest_foot.x - leg.mount.x, leg.rest_foot.y - leg.mount.y) for leg in model.legs]
        reach = sum(reaches) / len(reaches)
        self._none = (_NONE * model.mass * GRAVITY * reach) ** 2
        self._torques = [drive.effort_torque for drive in drives]
        self._damping = [drive.effort_damping for drive in drives]
        self._tilt = math.cos(math.radians(config.tilt_deg))
        tells = reach >= _SPREAD * model.heights.stand and all(self._torques)
        self._least = config.least_share if tells else 0.0
        self._share = 1.0
        self._forget = dt / _AVERAGED
        self._tilted, self._light = Agreement(), Agreement(round(_AVERAGED / dt))

    def step(
        self, imu: ImuState | None, efforts: Sequence[float], speeds: Sequence[float], borne: Sequence[float], *,
        up: bool,
    ) -> str | None:
        """Look at a tick; return that it fell, and how that is known, in words.

        Args:
            imu: as heard; None: there is none.
            efforts, speeds: of the joints, as measured.
            borne: torques that the joints should bear, N m.
            up: whether the body should be on its feet.
        """
        if imu is not None and imu.valid:
            level = math.cos(imu.roll) * math.cos(imu.pitch)
            if self._tilted.step(level < self._tilt):
                return f"it fell: it lies {math.degrees(math.acos(max(level, -1.0))):.0f} deg off level"
            return None
        if self._least == 0.0:
            return None
        square = sum([torque * torque for torque in borne])
        if not up or square < self._none:
            self._share = 1.0
        else:
            along = 0.0
            for effort, speed, torque, full, damping in zip(
                efforts, speeds, borne, self._torques, self._damping, strict=True):
                along += torque * (full * effort - damping * speed)
            self._share += self._forget * (along / square - self._share)
        if self._light.step(self._share < self._least):
            return f"it fell: its legs bear {max(100.0 * self._share, 0.0):.0f} % of what they should"
        return None
