"""What tests of single servos share: registers by name, and a shaft in MuJoCo."""

from typing import Any

import mujoco

from hal.register_map import Register, ServoModel
from sim_backend.brands import make_servo
from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.servo_physics import ServoPhysics

MS = 1_000_000  # ns


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
    """One servo's shaft on a hinge in MuJoCo, with little on it but its own armature and friction."""

    def __init__(self, physics: ServoPhysics, spring: float = 0.0) -> None:
        spec = mujoco.MjSpec()
        spec.option.timestep = 0.001
        spec.option.gravity = [0.0, 0.0, 0.0]
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        body = spec.worldbody.add_body()
        body.add_joint(
            type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1], armature=physics.armature[0],
            frictionloss=physics.coulomb[0], damping=physics.viscous[0], stiffness=spring)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.01, 0, 0], mass=0.001)
        self._mujoco = spec.compile()
        self._physics = physics
        self.data = mujoco.MjData(self._mujoco)

    @property
    def angle(self) -> float:
        return float(self.data.qpos[0])

    @property
    def speed(self) -> float:
        return float(self.data.qvel[0])

    def step(self, now: int) -> None:
        """Let a millisecond pass, at whose end it is `now` ns."""
        torque = self._physics.step(self.data.qpos.copy(), self.data.qvel.copy(), now)
        self.data.qfrc_applied[0] = torque[0]
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

    def __init__(self, model: ServoModel, spring: float = 0.0, **factory_settings: int) -> None:
        self.physics = ServoPhysics([model])
        self.servo = make_servo(self.physics, 0, **factory_settings)
        self.hinge = Hinge(self.physics, spring)
        self.now = 0

    def read_bytes(self, register: Register) -> bytes:
        if isinstance(self.servo, DynamixelServo):
            return self.servo.read(register.address, register.size, self.now)
        return super().read_bytes(register)
