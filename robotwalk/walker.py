"""The stages between measured joints and wanted angles, joined for the legs that walk: all, or those that are left.

A leg that is out takes part in nothing: not in the gait, not in balance, not in odometry. Where all legs walk, joints
and results pass through as they are.
"""

from collections.abc import Collection, Sequence
from typing import NamedTuple

from robotwalk.contact import Felt, FootSense
from robotwalk.controller import NOTHING_WANTED, Controller, Wanted
from robotwalk.estimator import Estimate, Odometry, tilted
from robotwalk.folded import Folded
from robotwalk.model import RobotModel
from robotwalk.stability import Stability, stability
from robotwalk.statics import up_in_base
from robotwalk.supervisor import State
from robotwalk.support import Masses
from robotwalk.types import STILL, Command, FootSwitch, ImuState, JointState, Pose, Tilt

_EASING = 0.08  # s in which the gait comes to a halt, and in which it goes on


class Part(NamedTuple):
    """Which part of a robot walks, and what becomes of the rest."""

    slots: tuple[int, ...]  # of its joints, in the whole robot's joint order
    legs: tuple[int, ...]  # in the whole robot's order
    folded: Folded  # all other legs


class Walker:
    """Perceives and walks with one set of legs."""

    def __init__(
        self, model: RobotModel, controller: Controller, gaits: Collection[str], sense: FootSense | None = None,
        part: Part | None = None,
    ) -> None:
        """Join the stages of the robot that `model` is; as a `part` of another, if it is one."""
        self._controller = controller
        self._gaits = gaits
        self._odometry = Odometry(model)
        self._masses = Masses(model)
        self._tells_stability = model.tells_stability
        self._sense = sense
        self._part = part
        self._wanted = self._told = NOTHING_WANTED  # of the legs that walk; of all joints
        self._pace = 1.0  # of the gait's time

    def start(self, positions: Sequence[float], pose: Pose | None = None) -> None:
        """Take over joints that hold their places, rad; `pose` of the base in odom goes on, if it is known."""
        own = positions if self._part is None else [positions[slot] for slot in self._part.slots]
        self._controller.start(own)
        if pose is not None:
            self._odometry.go_on(pose)
        if self._part is not None:
            self._part.folded.start(positions)
        self._wanted = self._wanted._replace(planted=())
        self._pace = 1.0

    def perceive(
        self, joints: JointState, imu: ImuState | None, switches: Sequence[FootSwitch], dt: float, *, feel: bool
    ) -> tuple[Estimate, Stability | None]:
        """Return what a tick's measurements say of the body; feet are felt only if there is to be `feel`."""
        wanted, part = self._wanted, self._part
        if part is not None:
            joints = _part_of(joints, part.slots)
            switches = [switches[leg] for leg in part.legs] if switches else ()
        centre, feet = self._masses.centre_and_feet(joints.position)
        estimate = self._odometry.step(joints, feet, wanted.planted, wanted.twist, dt)
        tilt = Tilt(imu.roll, imu.pitch) if imu is not None and imu.valid else None
        felt: tuple[Felt | None, ...] = ()
        if self._sense is not None and wanted.legs and feel:
            lying = tilted(wanted.pose, tilt)
            up = up_in_base(lying.roll, lying.pitch)
            felt = self._sense.step(joints, wanted.legs, up, tuple(switches))
        pose = tilted(estimate.pose, tilt)
        stable = stability(centre, feet, wanted.planted, pose) if self._tells_stability else None
        return Estimate(pose, estimate.standing_feet, tilt, imu, estimate.feet, felt, tuple(switches)), stable

    def step(self, state: State, command: Command, estimate: Estimate, dt: float, *, waits: bool = False) -> Wanted:
        """Advance by `dt` s; return what is wanted of all joints of the whole robot.

        While the gait `waits` for joints its time slows down and stands still; then the robot sets off anew.
        """
        if waits or self._pace < 1.0:
            change = dt / _EASING
            self._pace = max(self._pace - change, 0.0) if waits else min(self._pace + change, 1.0)
            if self._pace == 0.0:
                self._controller.halt()
                self._wanted = self._wanted._replace(twist=STILL)
                self._told = self._told._replace(twist=STILL)
                return self._told
            dt *= self._pace
        if command.gait is not None and command.gait not in self._gaits:
            command = command._replace(gait=None)
        wanted = self._wanted = self._controller.step(state, command, estimate, dt)
        if self._part is None:
            self._told = wanted
            return wanted
        angles = self._part.folded.step(dt)
        torques = [0.0] * len(angles)
        for slot, angle, torque in zip(self._part.slots, wanted.angles, wanted.torques, strict=True):
            angles[slot], torques[slot] = angle, torque
        self._told = wanted._replace(angles=angles, torques=torques)
        return self._told


def _part_of(joints: JointState, slots: Sequence[int]) -> JointState:
    position, velocity, effort, valid, age = joints
    return JointState(
        tuple([position[slot] for slot in slots]), tuple([velocity[slot] for slot in slots]),
        tuple([effort[slot] for slot in slots]), tuple([valid[slot] for slot in slots]),
        tuple([age[slot] for slot in slots]))
