"""Falls: noticed by the IMU where there is one, else by legs that do not push the body up, whichever of them should.

The motors of a robot on its feet push it up with its weight, less what the legs weigh themselves: on the average over
a turn of its gait, however the feet share it, and whether or not they stand where they are thought to. So the motors'
torques tau of each leg are taken for a push at its foot, the least-squares solution of J^T f = -tau, and the parts of
all f along the base's z axis are added up. Of one on its side or back the sum is about 0 or below: what its motors
hold then is their own legs, and those push the wrong way where its knees are on the ground. A robot that is lifted is
told by the same sign.

It says nothing while the body is on the ground anyway, nor before the legs were felt to push once. They never are where
they stand so straight that motors bear little, or where servos tell nothing of their effort: such a robot needs an IMU.
"""

import math
from collections.abc import Collection, Sequence

from robotwalk.agreement import Agreement
from robotwalk.config.safety import FallConfig
from robotwalk.controller import Wanted
from robotwalk.model import RobotModel
from robotwalk.statics import GRAVITY, LegStatics
from robotwalk.types import DriveResponse, ImuState, JointState, Vec3

_AVERAGED = 1.0  # s, longer than a turn of most gaits; what swinging legs are accelerated by comes to nothing in it
_AGREEING = 0.5  # s, that the average must be so low
_PROOF = 0.5  # of what they should push, that legs must have been felt to do to be believed
_DAMPING = 0.02  # m; a push along a way in which motors can hardly move the foot is not told


class FallWatch:
    """Watches one robot."""

    def __init__(self, model: RobotModel, drives: Sequence[DriveResponse], config: FallConfig, dt: float) -> None:
        self._weight = model.mass * GRAVITY
        self._motors = [(drive.effort_torque, drive.effort_damping) for drive in drives]
        self._spans = [leg.span for leg in model.legs]
        self._tilt = math.cos(math.radians(config.tilt_deg))
        self._least = config.least_share
        self._push, self._due = 0.0, self._weight  # N, averaged: by the motors of all legs, and that they should
        self._proven = False  # that they push when the robot stands
        self._turn = 0  # whose turn it is to be looked at: a leg each tick
        self._forget = dt / _AVERAGED
        self._tilted, self._light = Agreement(), Agreement(round(_AGREEING / dt))

    def spare(self, out: Collection[int]) -> None:
        """Go on without the legs of these joints (slots): they are folded, and part of what the others bear."""
        self._spans = [span for span in self._spans if span.start not in out]
        self._turn = 0

    def step(self, imu: ImuState | None, joints: JointState, wanted: Wanted, *, up: bool) -> str | None:
        """Look at a tick; return that it fell, and how that is known, in words.

        Args:
            imu: as heard; None: there is none.
            joints: as measured.
            wanted: by the controller, for these measurements.
            up: whether the body should be on its feet.
        """
        if imu is not None and imu.valid:
            level = math.cos(imu.roll) * math.cos(imu.pitch)
            if self._tilted.step(level < self._tilt):
                return f"it fell: it lies {math.degrees(math.acos(max(level, -1.0))):.0f} deg off level"
            return None
        if self._least == 0.0:
            return None
        if not up:
            self._push, self._due = self._weight if self._proven else 0.0, self._weight
        elif len(wanted.legs) == len(self._spans):  # not on its way to the seated pose
            turn = self._turn
            self._turn = (turn + 1) % len(self._spans)
            self._look(self._spans[turn], wanted.legs[turn], joints)
        self._proven = self._proven or self._push > _PROOF * self._due
        if self._light.step(self._proven and self._push < self._least * self._due):
            share = max(100.0 * self._push / self._weight, 0.0)
            return f"it fell, or was lifted: its legs push it up with {share:.0f} % of its weight"
        return None

    def _look(self, span: slice, leg: LegStatics, joints: JointState) -> None:
        """Take a leg's push for what it does until its next turn, if all of its joints were heard."""
        if not all(joints.valid[span]):
            return
        lever = _lever(leg)
        push = own = 0.0
        for (x, y, z), weight, effort, speed, (torque, damping) in zip(
            leg.columns, leg.weights, joints.effort[span], joints.velocity[span], self._motors[span], strict=True,
        ):
            by = x * lever.x + y * lever.y + z * lever.z
            push -= by * (torque * effort - damping * speed)
            own += by * weight
        count = len(self._spans)
        self._push += self._forget * (count * push - self._push)
        self._due += self._forget * (self._weight - count * own - self._due)


def _lever(leg: LegStatics) -> Vec3:
    """Return y with (J J^T + damping) y = z: the z part of J^T's least-squares inverse is y^T J, 1/m per joint."""
    xx = yy = zz = _DAMPING * _DAMPING
    xy = xz = yz = 0.0
    for cx, cy, cz in leg.columns:
        xx, yy, zz, xy, xz, yz = xx + cx * cx, yy + cy * cy, zz + cz * cz, xy + cx * cy, xz + cx * cz, yz + cy * cz
    ax, ay, az = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    inverse = 1.0 / (xx * ax + xy * ay + xz * az)
    return Vec3(az * inverse, (xy * xz - xx * yz) * inverse, (xx * yy - xy * xy) * inverse)
