"""The composition root: the one place where locomotion, servos and simulator meet."""

import gc
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from hal import backup as backup_file
from hal import bus_plan
from hal import quantity as quantity  # this and others named twice: what `robotwalk servo` works with
from hal.backup import Backup as Backup
from hal.calibration import Calibration
from hal.drive import response
from hal.hardware import HardwareConfig, problems
from hal.identity import Identity as Identity
from hal.maintenance import Bench as Bench
from hal.monitor import Sample as Sample
from hal.monitor import sample as sample
from hal.protocols import protocol_of
from hal.register_map import Register as Register
from hal.register_map import ServoModel
from hal.scan import Clash as Clash
from hal.scan import Finding as Finding
from hal.scan import Noise as Noise
from hal.scan import Progress as Progress
from hal.serial_transport import names_hardware, open_port
from hal.servo import Change as Change
from hal.servo import Servo as Servo
from hal.servo_bus import SerialServoBus
from hal.servo_line import ServoLine, Wired
from hal.vendor_sdk import Keep as Keep
from robotwalk import checks
from robotwalk.clock import WallClock
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
from sim_backend.adapter import AdapterName as AdapterName  # which the command line offers

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

    @property
    def bauds(self) -> dict[str, int]:
        """The baud rate of each bus."""
        return {name: bus.baud for name, bus in self.hardware.buses.items()}

    @cached_property
    def wiring(self) -> dict[str, list[Wired]]:
        """The servos of each bus, in joint order."""
        wires: dict[str, list[Wired]] = {name: [] for name in self.hardware.buses}
        limbs = [leg.name for leg in self.model.legs for _ in leg.joints]
        for slot, (limb, joint) in enumerate(zip(limbs, self.model.joints, strict=True)):
            row = self.hardware.joints[joint.name]
            servo = self.servos[row.servo]
            calibration = Calibration(
                row.direction, math.radians(row.zero_deg), servo.encoder.centre, servo.encoder.radians_per_tick)
            wires[row.bus].append(
                Wired(joint.name, limb, slot, row.id, servo, calibration, joint.lower, joint.upper))
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
class Session:
    """A robot ready to be armed."""

    blueprint: Blueprint
    robot: Robot
    bus: SerialServoBus
    clock: Clock


@dataclass(frozen=True)
class Simulation(Session):
    """A robot and the world in which it walks."""

    world: "SimulatedRobot"


def simulate(robot: str | Blueprint, *, rate_hz: int = RATE_HZ, seed: int = 0, log: Path | None = None) -> Simulation:
    """Put a robot into a simulated world, in lock-step: seated, torque off.

    Raises:
        UsageError: no such robot, an impossible rate, or a log that cannot be written.
        ConfigError: a file is wrong.
    """
    blueprint = load(robot) if isinstance(robot, str) else robot
    _check_rate(rate_hz)
    world = simulated_robot(blueprint, rate_hz, seed)
    recorder = _recorder(log, blueprint, {"rate_hz": str(rate_hz), "seed": str(seed)})
    bus = _bus(blueprint, world.clock, world.ports)
    return Simulation(blueprint, _robot(blueprint, world.clock, bus, rate_hz, recorder), bus, world.clock, world)


def simulated_robot(
    blueprint: Blueprint, rate_hz: int, seed: int, adapter: AdapterName = "none"
) -> "SimulatedRobot":
    """Build a simulated robot, seated, torque off, with nothing that controls it."""
    from sim_backend.simulation import SimulatedRobot, SimulatedServo
    from sim_backend.world import Mounting

    servos = []
    for joint in blueprint.model.joint_names:
        row = blueprint.hardware.joints[joint]
        mounting = Mounting(row.direction, math.radians(row.zero_deg))
        servos.append(SimulatedServo(row.bus, row.id, blueprint.servos[row.servo], mounting))
    seated = resting_angles(blueprint.model, 0.5 * blueprint.model.body_box.z)
    return SimulatedRobot(
        blueprint.model, servos, blueprint.bauds, seated, rate_hz=rate_hz, seed=seed, adapter=adapter)


def serve(
    robot: str, *, pty: Path | None, tcp: str | None, adapter: AdapterName, seed: int, truth: Path | None,
    seconds: float | None, ready: Callable[[dict[str, str]], None], check: Callable[[], None],
    warn: Callable[[str], None],
) -> None:
    """Serve a simulated robot in real time, as terminals in the folder `pty` or else at the address `tcp`.

    `ready` is told the URL of each bus. It ends after some `seconds`, or when `check` raises; `warn` is told if
    this computer is too slow.

    Raises:
        UsageError: no such robot, or a place or a file that cannot be used.
        ConfigError: a file is wrong.
        BusError: another server is there.
    """
    from sim_backend.pty_endpoint import open_ptys
    from sim_backend.server import serve
    from sim_backend.socket_endpoint import open_sockets, parse_address

    blueprint = load(robot)
    bauds = blueprint.bauds
    doors = open_ptys(pty, bauds) if pty is not None else open_sockets(parse_address(tcp or ""), bauds)
    world = simulated_robot(blueprint, RATE_HZ, seed, adapter)
    serve(world, blueprint.model, doors, truth=truth, seconds=seconds, ready=ready, check=check, warn=warn)


def connect(
    robot: str | Blueprint, ports: Mapping[str, str], *, real: bool = False, rate_hz: int = RATE_HZ,
    log: Path | None = None, torque: float = 1.0,
) -> Session:
    """Open a robot's serial lines, for a walk in real time. Nothing moves yet.

    Args:
        robot: its name, path or blueprint.
        ports: URLs by the names of buses, in place of those in the robot's file.
        real: whether URLs may lead to a physical robot.
        rate_hz: ticks per second.
        log: where to record every tick.
        torque: share of their largest output that the servos may use.

    Raises:
        UsageError: no such robot or bus, a rate or a log that is impossible, or a physical robot not asked for.
        ConfigError: a file is wrong.
        BusError: a port does not open.
    """
    blueprint = load(robot) if isinstance(robot, str) else robot
    _check_rate(rate_hz)
    urls = _urls(blueprint, ports, real)
    recorder = _recorder(log, blueprint, {"rate_hz": str(rate_hz), **urls})
    opened: dict[str, BytePort] = {}
    try:
        for name, url in urls.items():
            opened[name] = open_port(url, blueprint.hardware.buses[name].baud)
    except BaseException:
        for port in opened.values():
            port.close()
        raise
    gc.freeze()  # what is loaded by now stays; no collection need look at it again
    clock = WallClock()
    bus = _bus(blueprint, clock, opened)
    return Session(blueprint, _robot(blueprint, clock, bus, rate_hz, recorder, torque), bus, clock)


@contextmanager
def bench(url: str, *, baud: int, protocol: str | None, real: bool, writes: bool) -> Iterator[Bench]:
    """Open one line for the maintenance of single servos; `protocol` is the only one to be tried, if given.

    Raises:
        UsageError: no servo has this baud rate or protocol, or a physical one would be changed and was not asked for.
        BusError: the port does not open.
    """
    if writes and not real and names_hardware(url):
        raise UsageError(f"{url} may be a physical robot, and this changes or moves a servo: say --real to do it")
    models = [model for model in map(load_servo, library.names("servos")) if protocol in (None, model.protocol)]
    bauds = sorted({rate for model in models for rate in model.baud_rates})
    if baud not in bauds:
        whose = f"of {protocol}" if protocol else "that we know"
        raise UsageError(f"no servo {whose} has {baud} baud; there are {', '.join(map(str, bauds))}")
    port = open_port(url, baud)
    try:
        yield Bench(port, WallClock(), models)
    finally:
        port.close()


def read_backup(path: Path) -> Backup:
    """Read the backup of a servo.

    Raises:
        ConfigError: the file is wrong.
    """
    document = Document.read(path)
    backup = document.validate(Backup)
    if backup.model not in library.names("servos"):
        raise document.error(("model",), f"no such servo; there are {', '.join(library.names('servos'))}", backup.model)
    for name, what, got in backup_file.problems(backup, load_servo(backup.model)):
        raise document.error(("registers", name), what, got)
    return backup


def backup_text(backup: Backup, path: Path) -> str:
    """Return what to write to a file of that name: JSON if it is called so, else YAML."""
    if path.suffix == ".json":
        return backup_file.to_json(backup)
    return backup_file.to_yaml(backup, load_servo(backup.model))


def _urls(blueprint: Blueprint, ports: Mapping[str, str], real: bool) -> dict[str, str]:
    """Return the URL of every bus; a physical robot only if it was asked for."""
    buses = blueprint.hardware.buses
    for name in ports:
        if name not in buses:
            raise UsageError(f"{blueprint.model.name} has no bus {name!r}; it has {', '.join(buses)}")
    urls = {name: ports.get(name, bus.port) for name, bus in buses.items()}
    for name, url in urls.items():
        if not real and names_hardware(url):
            raise UsageError(f"{url} (bus {name}) may be a physical robot: say --real to open it")
    return urls


def _check_rate(rate_hz: int) -> None:
    if not 10 <= rate_hz <= 1000:
        raise UsageError(f"the rate should be 10 to 1000 Hz, not {rate_hz}")


def _recorder(log: Path | None, blueprint: Blueprint, about: dict[str, str]) -> Recorder | None:
    if log is None:
        return None
    return Recorder(log, blueprint.model.joint_names, {"robot": blueprint.model.name, **about})


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


def _bus(blueprint: Blueprint, clock: Clock, ports: Mapping[str, BytePort]) -> SerialServoBus:
    lines = [
        ServoLine(name, ports[name], blueprint.hardware.buses[name].baud, protocol_of(wired[0].model), wired)
        for name, wired in blueprint.wiring.items()
    ]
    return SerialServoBus(blueprint.model.joint_names, lines, clock)


def _robot(
    blueprint: Blueprint, clock: Clock, bus: SerialServoBus, rate_hz: int, recorder: Recorder | None,
    torque: float = 1.0,
) -> Robot:
    model = blueprint.model
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
    return Robot(model, tuple(blueprint.gaits), loop, bus, recorder=recorder, torque=torque)
