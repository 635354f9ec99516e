"""The servos' output shafts as joints in MuJoCo: what the motors and gears do to them, and what they do to those."""

import mujoco
import numpy as np
import numpy.typing as npt

from sim_backend.gear_train import GearTrain
from sim_backend.servo_physics import ServoPhysics

Floats = npt.NDArray[np.float64]


class Shafts:
    """The hinges that the servos turn, one after the other in a model's joints.

    Joint angle = direction x shaft angle + zero.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, servos: ServoPhysics, *, first_angle: int, first_dof: int,
        direction: Floats, zero: Floats,
    ) -> None:
        """Take charge of the joints from an index into `qpos` and one into `qvel` on; zero in rad."""
        self._data, self._servos = data, servos
        self._direction, self._zero = direction, zero
        count = len(servos.models)
        dofs = slice(first_dof, first_dof + count)
        # Views: MuJoCo never moves these arrays.
        self._angle, self._speed = data.qpos[first_angle:first_angle + count], data.qvel[dofs]
        self._applied = data.qfrc_applied[dofs]
        self._constraint, self._bias, self._spring = (
            data.qfrc_constraint[dofs], data.qfrc_bias[dofs], data.qfrc_spring[dofs])
        self._armature, self._damping = model.dof_armature[dofs], model.dof_damping[dofs]
        self._friction = model.dof_frictionloss[dofs]
        # With MuJoCo's default softness, made for joints without rotors, dry friction creeps: a limp leg sinks onto its
        # stop within seconds, and a stalled shaft turns on.
        armature = np.array([servo.motor.armature_kgm2 for servo in servos.models])
        model.dof_invweight0[dofs] = 1.0 / (1.0 / model.dof_invweight0[dofs] + armature)
        model.dof_solimp[dofs, :2] = 0.999, 0.9999
        model.dof_solref[dofs, 0] = 2.0 * model.opt.timestep
        # Stops are metal: with the default a body's weight presses a leg half a degree into them.
        joints = model.dof_jntid[dofs]
        model.jnt_solimp[joints, :2] = 0.999, 0.9999
        model.jnt_solref[joints, 0] = 2.0 * model.opt.timestep
        self._gears = GearTrain([servo.motor for servo in servos.models], model.opt.timestep, self._shaft_angles())
        self._set_joints()
        mujoco.mj_forward(model, data)
        assert not model.dof_simplenum[dofs].any(), "MuJoCo takes the inertia of a body on its own axis as given"
        assert (data.ne, data.nf) == (0, count), "MuJoCo's friction is not that of the servos alone"

    def drive(self, now: int) -> None:
        """Have the firmware, at `now` ns, and the gears set the joints' torques and friction for the next step."""
        data, direction, gears = self._data, self._direction, self._gears
        friction = data.efc_force[:data.nf]
        shaft, speed = self._shaft_angles(), self._speed * direction
        gears.follow(shaft, speed, friction * direction)
        torque = self._servos.step(shaft, speed, now, gears.rotor_speed)
        external = (self._constraint - friction - self._bias + self._spring) * direction if gears.follows_load else None
        np.multiply(gears.drive(torque, external), direction, out=self._applied)
        self._set_joints()

    def _shaft_angles(self) -> Floats:
        angles: Floats = (self._angle - self._zero) * self._direction
        return angles

    def _set_joints(self) -> None:
        self._armature[:] = self._gears.armature
        self._damping[:] = self._gears.viscous
        self._friction[:] = self._gears.friction
