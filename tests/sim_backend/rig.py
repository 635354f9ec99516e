"""What tests of single servos share: registers by name, and a shaft in MuJoCo."""

from typing import Any

import mujoco
import numpy as np

from hal.register_map import Register, ServoModel
from sim_backend.brands import make_servo
from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.servo_physics import ServoPhysics
from sim_backend.shafts import Shafts

MS = 1_000_000  # ns

_ARM = 0.02  # m: what turns with the shaft is a ball on a lever


class Registers:
    """Reads and writes a servo's registers by name, in counts. The rest of the rig is the test's."""

    servo: Any
    now: int

    def write(self, **registers: int) -> None:
        for name, value in registers.items():
            register: Register = self.servo.model[name]
            if register.sign_bit is not None and value < 0:
                value = -value | 1 << register.sign_bit
            data = value.to_bytes(register.size, register.byte_order, signed=register.signed)
            self.servo.write(register.address, data)

    def read(self, name: str) -> int:
        register: Register = self.servo.model[name]
        value = int.from_bytes(self.read_bytes(register), register.byte_order, signed=register.signed)
        if register.sign_bit is not None and value >> register.sign_bit:
            return (1 << register.sign_bit) - value
        return value

    def read_bytes(self, register: Register) -> bytes:
        return bytes(self.servo.read(register.address, register.size))


class Hinge:
    """Each servo's shaft on a hinge in MuJoCo, with little on it but its own gears. What is told is the first one's."""

    def __init__(self, physics: ServoPhysics, spring: float = 0.0, ball: float = 0.02) -> None:
        spec = mujoco.MjSpec()
        spec.option.timestep = 0.001
        spec.option.gravity = [0.0, 0.0, 0.0]
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        count = len(physics.models)
        for index in range(count):
            body = spec.worldbody.add_body(pos=[index, 0, 0])
            body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1], stiffness=spring)
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, pos=[_ARM, 0, 0], size=[0.01, 0, 0], mass=ball)
        self._ball = ball
        self._mujoco = spec.compile()
        self.data = mujoco.MjData(self._mujoco)
        self._shafts = Shafts(
            self._mujoco, self.data, physics, first_angle=0, first_dof=0, direction=np.ones(count),
            zero=np.zeros(count))

    def load(self, torque: float) -> None:
        """Have a torque act on the shaft (N m, while it is near 0): gravity on the ball."""
        self._mujoco.opt.gravity[1] = torque / (self._ball * _ARM)

    @property
    def angle(self) -> float:
        return float(self.data.qpos[0])

    @property
    def speed(self) -> float:
        return float(self.data.qvel[0])

    def step(self, now: int) -> None:
        """Let a millisecond pass, at whose end it is `now` ns."""
        self._shafts.drive(now)
        mujoco.mj_step(self._mujoco, self.data)


class Turning:
    """What the rigs of either brand do with a `hinge`: let it move, and look at it."""

    hinge: Hinge
    now: int

    @property
    def angle(self) -> float:
        return self.hinge.angle

    @property
    def speed(self) -> float:
        return self.hinge.speed

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 1000)):
            self.now += MS
            self.hinge.step(self.now)


class Rig(Turning, Registers):
    """One servo of any brand, whose shaft MuJoCo moves."""

    def __init__(self, model: ServoModel, spring: float = 0.0, ball: float = 0.02, **factory_settings: int) -> None:
        """Put a spring (N m/rad) and a ball (kg) on the shaft of a servo that the factory has given some settings."""
        self.physics = ServoPhysics([model])
        self.servo = make_servo(self.physics, 0, **factory_settings)
        self.hinge = Hinge(self.physics, spring, ball)
        self.now = 0

    def read_bytes(self, register: Register) -> bytes:
        if isinstance(self.servo, DynamixelServo):
            return self.servo.read(register.address, register.size, self.now)
        return super().read_bytes(register)
