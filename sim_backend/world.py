"""The robot's body and the ground in MuJoCo, built from the robot's model: no second copy of any length.

Contact settings: elliptic cones, impratio 10 and feet with torsional friction (condim 4), which slip an order
of magnitude less than MuJoCo's defaults. Not modelled here: legs colliding with legs or with the body.
"""

import math
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from robotwalk.model import Leg, RobotModel
from robotwalk.types import Pose, Vec3
from sim_backend.fake_imu import Felt
from sim_backend.servo_physics import ServoPhysics
from sim_backend.shafts import Shafts
from sim_backend.terrain.build import add_floor, add_ground
from sim_backend.terrain.course import FLAT, Ground

LONGEST_STEP = 0.0025  # s; results agree within 1.5 % from 0.5 to 10 ms

_LEG_RGBA = (0.25, 0.28, 0.33, 1.0)
_BODY_RGBA = (0.93, 0.52, 0.18, 1.0)
_FOOT_RGBA = (0.10, 0.10, 0.11, 1.0)
_STOP_MARGIN = math.radians(5.0)  # the mechanical stops lie this far behind the joints' limits
_SEATING_SPREAD = math.radians(0.1)  # no two robots sit exactly alike
_LIFTED = 0.03  # m, that feet are kept off the ground on a stand, legs straight down
_STAND_RGBA = (0.55, 0.57, 0.60, 1.0)
_STAND_RADIUS = 0.015  # m
_STAND_STIFFNESS, _STAND_DAMPING = 2e4, 2e3  # N/m and N s/m; N m/rad and N m s/rad: it gives by a millimetre
_TORSIONAL_FRICTION = 0.005  # m; MuJoCo's default, the size of the contact patch
_ROLLING_FRICTION = 0.0001  # m


class Mounting(NamedTuple):
    """How a servo sits on its joint: joint angle = direction x shaft angle + zero."""

    direction: int
    zero: float  # rad


class Truth(NamedTuple):
    """What really is, which no part of the controller may see."""

    time: float  # s, simulated
    base: Pose
    attitude: tuple[float, ...]  # of the base, quaternion w, x, y, z
    joints: tuple[float, ...]  # rad
    contacts: tuple[bool, ...]  # by leg
    energy: float  # J, electrical, drawn by all servos so far
    ground: float  # m, height of the ground under the body, on average


def steps_per_tick(rate_hz: int) -> int:
    """Return how many physics steps a tick has: a whole number, none longer than `LONGEST_STEP`."""
    return math.ceil(1.0 / (rate_hz * LONGEST_STEP) - 1e-9)


class World:
    """A robot on its belly, its servos off, on a ground that is level there; or on a stand, its feet off it."""

    def __init__(
        self, model: RobotModel, servos: ServoPhysics, mountings: Sequence[Mounting], seated: Sequence[float], *,
        rate_hz: int, friction: float = 1.0, seed: int = 0, ground: Ground = FLAT,
        imu: tuple[float, float, float] | None = None, hung: bool = False,
    ) -> None:
        """Build the world around a robot whose joints sit at `seated` (rad), give or take a tenth of a degree.

        `imu` is how one is mounted on the base, at its origin: roll, pitch, yaw (rad); None: there is none. `hung`: the
        body is on a stand, so high that no foot reaches the ground.
        """
        self.steps_per_second = rate_hz * steps_per_tick(rate_hz)
        assert self.steps_per_second % rate_hz == 0, "a tick must hold a whole number of physics steps"
        self._servos = servos
        spec = _spec(model, friction, ground)
        if imu is not None:
            _add_imu(spec, imu)
        height = 0.5 * model.body_box.z
        if hung:
            height += _LIFTED + max(sum(math.hypot(*joint.link) for joint in leg.joints) for leg in model.legs)
            _add_stand(spec, height)
        spec.option.timestep = 1.0 / self.steps_per_second
        self.model = spec.compile()
        if hung:  # by springs: an equality would be one more row of constraints, where shafts have theirs
            self.model.jnt_stiffness[0], self.model.dof_damping[:6] = _STAND_STIFFNESS, _STAND_DAMPING
        self.data = mujoco.MjData(self.model)
        dofs = [self.model.joint(name).dofadr[0] for name in model.joint_names]
        assert dofs == list(range(6, 6 + len(dofs))), "MuJoCo's joint order is not the robot's"
        # Behind the robot's own joints come those of bodies that lie around.
        self._angles = slice(7, 7 + len(dofs))
        self._feet = [self.model.geom(f"{leg.name}_foot").id for leg in model.legs]
        self.ground, self._body_box = ground, model.body_box
        self._base = self.model.body("base").id
        self._yaw = 0.0
        self._steps = 0
        self.data.qpos[2] = height
        self.data.qpos[self._angles] = np.random.default_rng(seed).normal(seated, _SEATING_SPREAD)
        self._shafts = Shafts(
            self.model, self.data, servos, first_angle=7, first_dof=6,
            direction=np.array([float(m.direction) for m in mountings]), zero=np.array([m.zero for m in mountings]))
        self._shafts.drive(0)

    def step(self, now: int) -> None:
        """End the physics step that ends at `now` ns, and let the servos' firmware set the motors for the next."""
        mujoco.mj_step(self.model, self.data)
        self._steps += 1
        self._yaw += math.remainder(_yaw(self.data.qpos[3:7]) - self._yaw, math.tau)
        self._shafts.drive(now)

    def push(self, force: Vec3) -> None:
        """Have another force act on the middle of the body from now on: N, in the world's frame."""
        self.data.xfrc_applied[self._base, :3] += force

    def jam(self, joint: int) -> Callable[[], None]:
        """Jam a joint, by its number, where it is; return what sets it free: its stops close on it."""
        at = 1 + joint  # behind the free one
        stops = self.model.jnt_range[at].copy()
        self.model.jnt_range[at] = self.data.qpos[7 + joint]

        def release() -> None:
            self.model.jnt_range[at] = stops
        return release

    def felt(self) -> Felt:
        """Return what the sensors of the IMU have now."""
        w, x, y, z, gx, gy, gz, ax, ay, az = self.data.sensordata.tolist()
        return Felt((w, x, y, z), (gx, gy, gz), (ax, ay, az))

    def pressed(self) -> list[float]:
        """Return how hard each foot is pressed against something now, N, by leg."""
        forces, force = dict.fromkeys(self._feet, 0.0), np.zeros(6)
        for number, geoms in enumerate(self.data.contact.geom.tolist()):
            for geom in geoms:
                if geom in forces:
                    mujoco.mj_contactForce(self.model, self.data, number, force)
                    forces[geom] += float(force[0])  # along the contact's normal
        return list(forces.values())

    def truth(self) -> Truth:
        """Return what is the case now."""
        qpos = self.data.qpos
        roll, pitch = _roll_pitch(qpos[3:7])
        # Feet meet nothing but the ground and what lies on it.
        touching = set(self.data.contact.geom.ravel().tolist())
        return Truth(
            time=float(self.data.time),
            base=Pose(float(qpos[0]), float(qpos[1]), float(qpos[2]), roll, pitch, self._yaw),
            attitude=tuple(qpos[3:7].tolist()),
            joints=tuple(qpos[self._angles].tolist()),
            contacts=tuple(foot in touching for foot in self._feet),
            energy=float(self._servos.energy.sum()),
            ground=self._ground_below(),
        )

    def _ground_below(self) -> float:
        """Return how high the ground is under the body's middle, edges and corners, on average.

        A single point would take a block, or the ditch between two, for all of the ground.
        """
        if not self.ground.shapes:
            return self.ground.floor
        x, y = self.data.qpos[:2].tolist()
        ahead, aside = 0.5 * self._body_box.x, 0.5 * self._body_box.y
        c, s = math.cos(self._yaw), math.sin(self._yaw)
        heights = [
            self.ground.height(x + c * dx - s * dy, y + s * dx + c * dy)
            for dx in (-ahead, 0.0, ahead) for dy in (-aside, 0.0, aside)]
        return math.fsum(heights) / len(heights)


def bare_speed(world: World, seconds: float) -> float:
    """Step a copy of a world, motors held as they are, for simulated seconds; return simulated / wall time."""
    data = mujoco.MjData(world.model)
    data.qpos[:], data.qvel[:] = world.data.qpos, world.data.qvel
    data.qfrc_applied[:] = world.data.qfrc_applied
    steps = round(seconds * world.steps_per_second)
    began = time.perf_counter()
    for _ in range(steps):
        mujoco.mj_step(world.model, data)
    return seconds / (time.perf_counter() - began)


def _yaw(quat_wxyz: npt.NDArray[np.float64]) -> float:
    w, x, y, z = quat_wxyz.tolist()
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def _roll_pitch(quat_wxyz: npt.NDArray[np.float64]) -> tuple[float, float]:
    w, x, y, z = quat_wxyz.tolist()
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return roll, math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))


def _spec(model: RobotModel, friction: float, ground: Ground) -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    spec.modelname = model.name
    spec.compiler.degree = False
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    sliding = [friction, _TORSIONAL_FRICTION, _ROLLING_FRICTION]
    # The robot's geoms meet the ground (1 & 1) but not each other (their contype is 0).
    add_floor(spec, ground, sliding)
    spec.worldbody.add_light(pos=[0.5, -0.5, 2.0], dir=[-0.25, 0.25, -1.0], castshadow=True)
    body = spec.worldbody.add_body(name="base", sleep=mujoco.mjtSleepPolicy.mjSLEEP_NEVER)
    body.add_freejoint(name="base")
    box = model.body_box
    body.add_geom(
        name="body", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.5 * box.x, 0.5 * box.y, 0.5 * box.z],
        mass=model.body_mass, rgba=_BODY_RGBA, contype=0, conaffinity=1, friction=sliding)
    for leg in model.legs:
        _add_leg(body, leg, model, sliding)
    add_ground(spec, ground, sliding)
    return spec


def _add_stand(spec: mujoco.MjSpec, height: float) -> None:
    """Put the base at a height, and draw what it stands on, which touches nothing."""
    spec.body("base").pos = [0.0, 0.0, height]
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=[0.0, 0.0, 0.0, 0.0, 0.0, height], size=[_STAND_RADIUS, 0.0, 0.0],
        rgba=_STAND_RGBA, contype=0, conaffinity=0)


def _add_imu(spec: mujoco.MjSpec, mounting: tuple[float, float, float]) -> None:
    """Put a sensor of attitude, of angular velocity and of acceleration on the base."""
    quat, turn = np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(4)
    for axis, angle in zip(([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]), reversed(mounting), strict=True):
        mujoco.mju_axisAngle2Quat(turn, np.array(axis), angle)
        mujoco.mju_mulQuat(quat, quat.copy(), turn)
    spec.body("base").add_site(name="imu", quat=quat)
    sensor = mujoco.mjtSensor
    for kind in (sensor.mjSENS_FRAMEQUAT, sensor.mjSENS_GYRO, sensor.mjSENS_ACCELEROMETER):
        spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="imu")


def _add_leg(base: mujoco.MjsBody, leg: Leg, model: RobotModel, friction: list[float]) -> None:
    parent, position = base, leg.mount
    quat = [math.cos(0.5 * leg.yaw), 0.0, 0.0, math.sin(0.5 * leg.yaw)]
    for joint in leg.joints:
        # The last capsule ends where the foot's ball begins, or both would carry the load.
        end = joint.link if joint is not leg.joints[-1] else _shortened(joint.link, model.foot_radius)
        parent = parent.add_body(name=joint.name, pos=list(position), quat=quat)
        parent.add_joint(
            name=joint.name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=list(joint.axis.value), limited=True,
            range=[joint.lower - _STOP_MARGIN, joint.upper + _STOP_MARGIN])
        parent.add_geom(
            name=f"{joint.name}_link", type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=[0.0, 0.0, 0.0, *end],
            size=[joint.radius, 0, 0], mass=joint.mass, rgba=_LEG_RGBA, contype=0, conaffinity=1, friction=friction)
        position, quat = joint.link, [1.0, 0.0, 0.0, 0.0]
    parent.add_geom(
        name=f"{leg.name}_foot", type=mujoco.mjtGeom.mjGEOM_SPHERE, pos=list(position),
        size=[model.foot_radius, 0, 0], mass=model.foot_mass, rgba=_FOOT_RGBA, contype=0, conaffinity=1,
        condim=4, friction=friction)


def _shortened(link: Vec3, by: float) -> Vec3:
    scale = 1.0 - by / math.sqrt(link.x**2 + link.y**2 + link.z**2)
    return Vec3(link.x * scale, link.y * scale, link.z * scale)
