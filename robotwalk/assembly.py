"""The composition root: the one place where locomotion, servos and simulator meet."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from hal import bus_plan
from hal.calibration import Calibration
from hal.drive import response
from hal.hardware import HardwareConfig, problems
from hal.protocols import protocol_of
from hal.register_map import ServoModel
from hal.servo_bus import SerialServoBus
from hal.servo_line import ServoLine, Wired
from robotwalk import checks
from robotwalk.config import library
from robotwalk.config.document import Document
from robotwalk.config.schema import GaitConfig, RobotConfig
from robotwalk.controller import Controller
from robotwalk.errors import UsageError
from robotwalk.estimator import Odometry
from robotwalk.feedforward import Feedforward
from robotwalk.gait import Gait
from robotwalk.kinematics import resting_angles
from robotwalk.limits import Gate, JointLimit
from robotwalk.loop import Loop
from robotwalk.model import RobotModel
from robotwalk.ports import BytePort, Clock
from robotwalk.recorder import Recorder
from robotwalk.robot import Robot
from robotwalk.supervisor import Supervisor
from robotwalk.types import DriveResponse

if TYPE_CHECKING:
    # MuJoCo is loaded only where something is simulated.
    from sim_backend.film import Film
    from sim_backend.simulation import SimulatedRobot
    from sim_backend.viewer import Viewer

RATE_HZ = 100
_STALE_AFTER = 0.5  # s without an answer from a joint before the robot sits down
_GOAL_LEAD = 3.0  # a goal may run this much faster than the servo, so that feed-forward is not cut
_FULL_SPEED_WITHIN = 0.005  # s


@dataclass(frozen=True)
class Blueprint:
    """A robot as its files describe it, every check passed that needs no motion."""

    document: Document
    model: RobotModel
    gaits: Mapping[str, Gait]
    hardware: HardwareConfig
    servos: Mapping[str, ServoModel]

    @property
    def default_gait(self) -> str:
        """Tripod with six legs or more, trot with four, wave otherwise; else the first that fits."""
        legs = len(self.model.legs)
        usual = "tripod" if legs >= 6 else "trot" if legs == 4 else "wave"
        return usual if usual in self.gaits else next(iter(self.gaits))

    @cached_property
    def wiring(self) -> dict[str, list[Wired]]:
        """The servos of each bus, in joint order."""
        wires: dict[str, list[Wired]] = {name: [] for name in self.hardware.buses}
        for index, joint in enumerate(self.model.joint_names):
            row = self.hardware.joints[joint]
            servo = self.servos[row.servo]
            calibration = Calibration(
                row.direction, math.radians(row.zero_deg), servo.encoder.centre, servo.encoder.radians_per_tick)
            wires[row.bus].append(Wired(joint, index, row.id, servo, calibration))
        return wires

    @cached_property
    def drives(self) -> tuple[DriveResponse, ...]:
        """How each joint follows its goals."""
        return tuple(response(self.servos[self.hardware.joints[name].servo]) for name in self.model.joint_names)


def load(robot: str) -> Blueprint:
    """Read a robot and all that it refers to.

    Raises:
        UsageError: no robot is bundled under that name.
        ConfigError: a file is wrong.
    """
    document = library.open_document("robots", robot)
    config = document.validate(RobotConfig)
    checks.require_consistent(document, config)
    model = RobotModel.from_config(config)
    checks.require_reachable(document, model)
    hardware = document.validate(HardwareConfig, at=("hardware",))
    servos = {name: load_servo(name) for name in library.names("servos")}
    limits = {
        joint.name: (math.degrees(joint.lower), math.degrees(joint.upper)) for joint in model.joints}
    for path, what, got in problems(hardware, limits, servos):
        raise document.error(("hardware", *path), what, got)
    return Blueprint(document, model, load_gaits(model), hardware, servos)


def load_servo(name: str) -> ServoModel:
    """Read a bundled servo model."""
    return library.open_document("servos", name).validate(ServoModel)


def load_gaits(model: RobotModel) -> dict[str, Gait]:
    """Read every bundled gait that is for this robot's feet."""
    gaits = {}
    for name in library.names("gaits"):
        document = library.open_document("gaits", name)
        config = document.validate(GaitConfig)
        checks.require_sound_gait(document, config)
        if set(config.swing) == {leg.name for leg in model.legs}:
            gaits[name] = Gait(config, model)
    return gaits


class BusLoad(NamedTuple):
    """What a tick costs on one bus."""

    name: str
    baud: int
    servos: int
    wire_s: float
    share: float  # of the tick
    largest_rate_hz: int  # that leaves a fifth of the wire free


def bus_loads(blueprint: Blueprint, rate_hz: int) -> list[BusLoad]:
    """Plan each bus's exchange with return delay 0 and, where every servo may have it, fast sync read."""
    loads = []
    for name, wired in blueprint.wiring.items():
        baud = blueprint.hardware.buses[name].baud
        models = [servo.model for servo in wired]
        fast = all(model.fast_sync_read_firmware is not None for model in models)
        plan = bus_plan.cyclic(protocol_of(models[0]), models, fast=fast)
        seconds = bus_plan.wire_seconds(plan, baud)
        loads.append(BusLoad(name, baud, len(wired), seconds, seconds * rate_hz, int(0.8 / seconds)))
    return loads


@dataclass(frozen=True)
class Simulation:
    """A robot and the world in which it walks."""

    blueprint: Blueprint
    robot: Robot
    world: "SimulatedRobot"


def simulate(robot: str | Blueprint, *, rate_hz: int = RATE_HZ, seed: int = 0, log: Path | None = None) -> Simulation:
    """Put a robot into a simulated world, in lock-step: seated, torque off.

    Raises:
        UsageError: no such robot, an impossible rate, or a log that cannot be written.
        ConfigError: a file is wrong.
    """
    from sim_backend.simulation import SimulatedRobot, SimulatedServo
    from sim_backend.world import Mounting

    blueprint = load(robot) if isinstance(robot, str) else robot
    if not 10 <= rate_hz <= 1000:
        raise UsageError(f"the rate should be 10 to 1000 Hz, not {rate_hz}")
    servos = []
    for joint in blueprint.model.joint_names:
        row = blueprint.hardware.joints[joint]
        mounting = Mounting(row.direction, math.radians(row.zero_deg))
        servos.append(SimulatedServo(row.bus, row.id, blueprint.servos[row.servo], mounting))
    bauds = {name: bus.baud for name, bus in blueprint.hardware.buses.items()}
    seated = resting_angles(blueprint.model, 0.5 * blueprint.model.body_box.z)
    world = SimulatedRobot(blueprint.model, servos, bauds, seated, rate_hz=rate_hz, seed=seed)
    recorder = None
    if log is not None:
        about = {"robot": blueprint.model.name, "rate_hz": str(rate_hz), "seed": str(seed)}
        recorder = Recorder(log, blueprint.model.joint_names, about)
    return Simulation(blueprint, _robot(blueprint, world.clock, world.ports, rate_hz, recorder), world)


def bare_physics(world: "SimulatedRobot", seconds: float) -> float:
    """Return how many times faster than real time MuJoCo alone steps a simulated robot's model."""
    from sim_backend.world import bare_speed

    return bare_speed(world.world, seconds)


def film(world: "SimulatedRobot") -> "Film":
    """Return a film of a simulated robot, still empty."""
    from sim_backend.film import Film

    return Film(world.world.model)


def check_film(path: Path) -> None:
    """Check that a film can be saved there.

    Raises:
        UsageError: it cannot.
    """
    from sim_backend.film import check_writable

    check_writable(path)


def viewer(world: "SimulatedRobot") -> "Viewer":
    """Return a window in the browser onto a simulated robot.

    Raises:
        UsageError: the extra `robotwalk[view]` is not installed.
    """
    from sim_backend.viewer import Viewer

    return Viewer(world.world.model, world.world.data)


def _robot(
    blueprint: Blueprint, clock: Clock, ports: Mapping[str, BytePort], rate_hz: int, recorder: Recorder | None
) -> Robot:
    model = blueprint.model
    lines = [
        ServoLine(name, ports[name], blueprint.hardware.buses[name].baud, protocol_of(wired[0].model), wired)
        for name, wired in blueprint.wiring.items()
    ]
    bus = SerialServoBus(model.joint_names, lines, clock)
    limits = [
        JointLimit(
            joint.lower, joint.upper, _GOAL_LEAD * drive.max_speed, _GOAL_LEAD * drive.max_speed / _FULL_SPEED_WITHIN)
        for joint, drive in zip(model.joints, blueprint.drives, strict=True)
    ]
    loop = Loop(
        rate_hz=rate_hz,
        clock=clock,
        bus=bus,
        controller=Controller(model, blueprint.gaits, blueprint.default_gait),
        odometry=Odometry(model),
        feedforward=Feedforward(blueprint.drives),
        gate=Gate(model.joint_names, limits),
        supervisor=Supervisor(_STALE_AFTER),
        record=recorder.put if recorder else None,
    )
    return Robot(model, tuple(blueprint.gaits), loop, bus, recorder)
