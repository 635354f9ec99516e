"""A robot in a simulated world, in lock-step or as a device; and what shows it. MuJoCo is loaded only for that."""

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hal.hardware import FEET_PORT, IMU_PORT, STOP_PORT
from robotwalk.assembly.blueprint import Blueprint, load
from robotwalk.assembly.session import RATE_HZ, LocalSession, check_rate, engine_of, open_log, robot_of
from robotwalk.config import library
from robotwalk.errors import UsageError
from robotwalk.kinematics import resting_angles
from sim_backend.adapter import AdapterName
from sim_backend.faults.fault import Fault
from sim_backend.faults.script import Script, read_script, stage
from sim_backend.terrain.course import Terrain, read_terrain

if TYPE_CHECKING:
    from sim_backend.fake_foot_switches import SimulatedFootSwitches
    from sim_backend.fake_imu import SimulatedImu
    from sim_backend.fake_stop_board import SimulatedStopBoard
    from sim_backend.film import Film
    from sim_backend.simulation import SimulatedRobot
    from sim_backend.viewer import Viewer


FLAT = "flat"  # the name of its file


def load_terrain(terrain: str) -> Terrain:
    """Read a bundled terrain by its name, or any by the path of its file.

    Raises:
        UsageError: nothing of that name is bundled.
        ConfigError: the file is wrong.
    """
    return read_terrain(library.open_document("terrains", terrain))


@dataclass(frozen=True)
class Simulation(LocalSession):
    """A robot and the world in which it walks."""

    world: "SimulatedRobot"


def simulate(
    robot: str | Blueprint, *, rate_hz: int = RATE_HZ, seed: int = 0, log: Path | None = None, faults: Script = (),
    terrain: str = FLAT,
) -> Simulation:
    """Put a robot into a simulated world, in lock-step: seated, torque off. `faults` will befall it.

    Raises:
        UsageError: no such robot or terrain, an impossible rate, or a log that cannot be written.
        ConfigError: a file is wrong.
    """
    blueprint = load(robot) if isinstance(robot, str) else robot
    check_rate(rate_hz)
    if seed < 0:
        raise UsageError(f"a seed is a whole number from 0 on, not {seed}")
    ground = load_terrain(terrain)
    world = simulated_robot(blueprint, rate_hz, seed, faults=faults, terrain=ground)
    about = {"seed": str(seed), "terrain": ground.config.name}
    recorder = open_log(log, blueprint, rate_hz, about, {"terrain.yaml": ground.document.text})
    engine = engine_of(blueprint, world.clock, world.ports, rate_hz, recorder)
    walker, bus = robot_of(blueprint, engine, recorder), engine.bus
    return Simulation(blueprint, walker, bus, world.clock, world)


def simulated_robot(
    blueprint: Blueprint, rate_hz: int, seed: int, adapter: AdapterName = "none", faults: Script = (),
    terrain: Terrain | None = None, served: bool = False,
) -> "SimulatedRobot":
    """Build a simulated robot, seated, torque off, with nothing that controls it. `faults` will befall it.

    It is on flat ground if `terrain` is None. Only one that is `served` as a device has its stop button.

    Raises:
        ConfigError: the faults are wrong; says where.
    """
    from sim_backend.simulation import SimulatedRobot, SimulatedServo
    from sim_backend.world import Mounting

    script = _read_faults(faults, blueprint, served=served)
    servos = []
    for joint in blueprint.model.joint_names:
        row = blueprint.hardware.joints[joint]
        mounting = Mounting(row.direction, math.radians(row.zero_deg))
        servos.append(SimulatedServo(row.bus, row.id, blueprint.servos[row.servo], mounting))
    seated = resting_angles(blueprint.model, 0.5 * blueprint.model.body_box.z)
    world = SimulatedRobot(
        blueprint.model, servos, blueprint.bauds, seated, rate_hz=rate_hz, seed=seed, adapter=adapter,
        supply_v=blueprint.hardware.power.supply_v,
        internal_resistance=blueprint.hardware.power.internal_resistance_ohm,
        ground=(terrain or load_terrain(FLAT)).lay_out(0.5 * blueprint.model.body_box.x, seed),
        imu=_simulated_imu(blueprint), foot_switches=_simulated_foot_switches(blueprint),
        stop_board=_simulated_stop_board(blueprint) if served else None, hung=blueprint.hung)
    stage(world, script, seed)
    return world


def _read_faults(faults: Script, blueprint: Blueprint, *, served: bool) -> list[Fault]:
    hardware = blueprint.hardware
    wiring = {joint: row.bus for joint, row in hardware.joints.items()}
    lines = dict.fromkeys(hardware.sensors)
    if not served or hardware.stop_input is None or hardware.stop_input.input is None:
        lines.pop(STOP_PORT, None)
    return read_script(faults, wiring, list(lines))


def _simulated_imu(blueprint: Blueprint) -> "tuple[str, SimulatedImu] | None":
    """Return the name of the IMU's port, and what is to talk there; None if the robot has none."""
    from sim_backend.fake_imu import SimulatedImu

    config, model = blueprint.hardware.imu, blueprint.imu
    if config is None or model is None:
        return None
    roll, pitch, yaw = map(math.radians, config.mounting_deg)
    errors = model.errors
    return IMU_PORT, SimulatedImu(
        model.frames, config.baud, config.rate_hz or model.rate_hz, (roll, pitch, yaw),
        tilt_bias=math.radians(errors.tilt_bias_deg), tilt_noise=math.radians(errors.tilt_noise_deg),
        gyro_bias=math.radians(errors.gyro_bias_deg_s), gyro_noise=math.radians(errors.gyro_noise_deg_s),
        acceleration_noise=errors.acceleration_noise_mps2)


def _simulated_foot_switches(blueprint: Blueprint) -> "tuple[str, SimulatedFootSwitches] | None":
    """Return the name of the foot switches' port, and the board that is to talk there; None if the robot has none."""
    from sim_backend.fake_foot_switches import SimulatedFootSwitches

    config = blueprint.hardware.foot_switches
    if config is None:
        return None
    inputs = tuple(config.inputs.get(leg.name) for leg in blueprint.model.legs)
    return FEET_PORT, SimulatedFootSwitches(config.baud, config.rate_hz, inputs, config.closes_at_n)


def _simulated_stop_board(blueprint: Blueprint) -> "tuple[str, SimulatedStopBoard] | None":
    """Return the name of the stop input's own port, and the board that is to talk there; None if it has none."""
    from sim_backend.fake_stop_board import SimulatedStopBoard

    config = blueprint.hardware.stop_input
    if config is None or config.input is None:
        return None
    return STOP_PORT, SimulatedStopBoard(config.baud, config.input, config.contact == "normally_closed")


def serve(
    robot: str, *, pty: Path | None, tcp: str | None, adapter: AdapterName, seed: int, faults: Script,
    truth: Path | None, seconds: float | None, ready: Callable[[dict[str, str], str | None], None],
    check: Callable[[], None], warn: Callable[[str], None], terrain: str = FLAT, view: bool = False,
    hang: bool = False,
) -> None:
    """Serve a simulated robot in real time, as terminals in the folder `pty` or else at the address `tcp`.

    `ready` is told the URL of each bus and sensor, and of the page that shows the robot if `view` asks for one. It
    ends after some `seconds`, or when `check` raises; `warn` is told if this computer is too slow. `hang`: on a stand.

    Raises:
        UsageError: no such robot or terrain, or a place or a file that cannot be used.
        ConfigError: a file is wrong.
        BusError: another server is there.
    """
    from sim_backend.pty_endpoint import open_ptys
    from sim_backend.server import serve
    from sim_backend.socket_endpoint import open_sockets, parse_address

    blueprint, ground = load(robot), load_terrain(terrain)
    if hang:
        blueprint = blueprint.hang()
    lines = blueprint.lines
    doors = (
        open_ptys(pty, lines, unasked=tuple(blueprint.hardware.sensors)) if pty is not None
        else open_sockets(parse_address(tcp or ""), lines))
    world = simulated_robot(blueprint, RATE_HZ, seed, adapter, faults, ground, served=True)
    with contextlib.ExitStack() as stack:
        page = None
        if view:
            from sim_backend.window import Window

            page = stack.enter_context(contextlib.closing(Window(world))).url
        serve(
            world, blueprint.model, doors, truth=truth, seconds=seconds, ready=lambda urls: ready(urls, page),
            check=check, warn=warn)


def befall(simulation: Simulation, faults: Script, seed: str) -> None:
    """Let more faults befall a simulated robot, at their times or now; chances come from the seed.

    Raises:
        ConfigError: the faults are wrong; says where.
    """
    stage(simulation.world, _read_faults(faults, simulation.blueprint, served=False), seed)


def bare_physics(world: "SimulatedRobot", seconds: float) -> float:
    """Return how many times faster than real time MuJoCo alone steps a simulated robot's model."""
    from sim_backend.world import bare_speed

    return bare_speed(world.world, seconds)


def film(world: "SimulatedRobot") -> "Film":
    """Return a film of a simulated robot, still empty."""
    from sim_backend.film import Film

    return Film(world.world.model, ground=world.world.ground)


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
