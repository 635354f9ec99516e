"""A robot on a bus: locomotion, the loop and the servos joined; over serial lines, in real time."""

import gc
import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import robotwalk
from hal.foot_switches.serial_foot_switches import SerialFootSwitches
from hal.hardware import FEET_PORT, IMU_PORT
from hal.imu.serial_imu import SerialImu
from hal.protocols import protocol_of
from hal.serial_transport import names_hardware, open_plainly, open_port
from hal.servo_bus import SerialServoBus
from hal.servo_line import ServoLine
from robotwalk.assembly.blueprint import Blueprint, load
from robotwalk.clock import WallClock
from robotwalk.contact import FootSense
from robotwalk.controller import Controller
from robotwalk.errors import UsageError
from robotwalk.estimator import Odometry
from robotwalk.feedforward import Feedforward
from robotwalk.limits import Gate, JointLimit
from robotwalk.loop import Loop
from robotwalk.ports import BytePort, Clock, FootSwitches, Imu, ServoBus
from robotwalk.recorder import Recorder, Row
from robotwalk.robot import Robot
from robotwalk.safety import Safety
from robotwalk.tape import Tape, TapedClock, TapedPort

RATE_HZ = 100
_GOAL_LEAD = 3.0  # a goal may run this much faster than the servo, so that feed-forward is not cut
_FEELING_HZ = 80  # below, a joint's acceleration between two samples is not known well enough to feel the ground
_FULL_SPEED_WITHIN = 0.005  # s


@dataclass(frozen=True)
class Session:
    """A robot ready to be armed."""

    blueprint: Blueprint
    robot: Robot
    bus: SerialServoBus
    clock: Clock


def connect(
    robot: str | Blueprint, ports: Mapping[str, str], *, real: bool = False, rate_hz: int = RATE_HZ,
    log: Path | None = None, torque: float = 1.0,
) -> Session:
    """Open a robot's serial lines, for a walk in real time. Nothing moves yet.

    Args:
        robot: its name, path or blueprint.
        ports: URLs by the names of buses, of the IMU as "imu", of the foot switches as "feet", in place of those in
            the robot's file.
        real: whether URLs may lead to a physical robot.
        rate_hz: ticks per second.
        log: where to record every tick.
        torque: share of their largest output that the servos may use.

    Raises:
        UsageError: no such robot or bus, a rate or a log that is impossible, or a physical robot not asked for.
        ConfigError: a file is wrong.
        BusError: a port does not open.
    """
    blueprint = load(robot, calibrated=True) if isinstance(robot, str) else robot
    check_rate(rate_hz)
    urls = _urls(blueprint, ports, real)
    opened: dict[str, BytePort] = {}
    try:
        for name, url in urls.items():
            # Only what answers to us may echo.
            sensor = name in blueprint.hardware.sensors
            opened[name] = (open_plainly if sensor else open_port)(url, blueprint.lines[name])
        recorder = open_log(log, blueprint, rate_hz, urls)
    except BaseException:
        for port in opened.values():
            port.close()
        raise
    gc.freeze()  # what is loaded by now stays; no collection need look at it again
    clock = WallClock()
    robot_there, bus = robot_of(blueprint, clock, opened, rate_hz, recorder, torque)
    return Session(blueprint, robot_there, bus, clock)


def _urls(blueprint: Blueprint, ports: Mapping[str, str], real: bool) -> dict[str, str]:
    """Return the URL of every line; a physical robot only if it was asked for."""
    hardware, lines = blueprint.hardware, blueprint.lines
    for name in ports:
        if name not in lines:
            raise UsageError(f"{blueprint.model.name} has no bus {name!r}; it has {', '.join(lines)}")
    urls = {name: ports.get(name, line.port) for name, line in (hardware.buses | hardware.sensors).items()}
    for name, url in urls.items():
        if not real and names_hardware(url):
            what = name if name in hardware.sensors else f"bus {name}"
            raise UsageError(f"{url} ({what}) may be a physical robot: say --real to open it")
    return urls


def check_rate(rate_hz: int) -> None:
    """Raise UsageError if a rate is out of the question."""
    if not 10 <= rate_hz <= 1000:
        raise UsageError(f"the rate should be 10 to 1000 Hz, not {rate_hz}")


def open_log(
    log: Path | None, blueprint: Blueprint, rate_hz: int, about: dict[str, str],
    more: Mapping[str, str] | None = None,
) -> Recorder | None:
    """Return what records a run to the file `log`, if one is wanted.

    `about` goes into its head; `more` are texts to be kept in it, by their names, beside the robot's files.
    """
    if log is None:
        return None
    head = {
        "robot": blueprint.model.name, "robotwalk": robotwalk.__version__, "python": platform.python_version(),
        "rate_hz": str(rate_hz), **about}
    return Recorder(
        log, blueprint.model.joint_names, head, buses=tuple(blueprint.lines),
        files={**blueprint.files.texts(), **(more or {})})


def bus_of(blueprint: Blueprint, clock: Clock, ports: Mapping[str, BytePort]) -> SerialServoBus:
    """Put a robot's servos on its opened lines."""
    lines = [
        ServoLine(name, ports[name], blueprint.hardware.buses[name].baud, protocol_of(wired[0].model), wired)
        for name, wired in blueprint.wiring.items()
    ]
    return SerialServoBus(blueprint.model.joint_names, lines, clock)


def imu_of(blueprint: Blueprint, clock: Clock, ports: Mapping[str, BytePort]) -> SerialImu | None:
    """Put a robot's IMU on its opened line, if it has one."""
    config, model = blueprint.hardware.imu, blueprint.imu
    if config is None or model is None:
        return None
    return SerialImu(ports[IMU_PORT], clock, model.frames, config)


def foot_switches_of(
    blueprint: Blueprint, clock: Clock, ports: Mapping[str, BytePort]
) -> SerialFootSwitches | None:
    """Put a robot's foot switches on their opened line, if it has any."""
    config = blueprint.hardware.foot_switches
    if config is None:
        return None
    return SerialFootSwitches(ports[FEET_PORT], clock, [leg.name for leg in blueprint.model.legs], config)


def robot_of(
    blueprint: Blueprint, clock: Clock, ports: Mapping[str, BytePort], rate_hz: int, recorder: Recorder | None,
    torque: float = 1.0,
) -> tuple[Robot, SerialServoBus]:
    """Join everything around a robot's opened lines; `torque` is the share that the servos may use."""
    if recorder is not None:
        ports = {name: TapedPort(name, port, clock, recorder.tape) for name, port in ports.items()}
        clock = TapedClock(clock, recorder.tape)
    bus = bus_of(blueprint, clock, ports)
    record, tape = (recorder.put, recorder.tape) if recorder else (None, None)
    imu, switches = imu_of(blueprint, clock, ports), foot_switches_of(blueprint, clock, ports)
    loop = loop_of(blueprint, clock, bus, imu, switches, rate_hz, record, tape)
    robot = Robot(
        blueprint.model, tuple(blueprint.gaits), loop, bus, imu=imu, foot_switches=switches, recorder=recorder,
        torque=torque, refused=blueprint.refused)
    return robot, bus


def loop_of(
    blueprint: Blueprint, clock: Clock, bus: ServoBus, imu: Imu | None, switches: FootSwitches | None, rate_hz: int,
    record: Callable[[Row], None] | None = None, tape: Tape | None = None,
) -> Loop:
    """Join the stages into a loop around a bus, an IMU and foot switches, if there are any."""
    model = blueprint.model
    by_load = rate_hz >= _FEELING_HZ
    feels = model.contact is not None and (by_load or switches is not None)
    limits = [
        JointLimit(
            joint.lower, joint.upper, _GOAL_LEAD * drive.max_speed, _GOAL_LEAD * drive.max_speed / _FULL_SPEED_WITHIN)
        for joint, drive in zip(model.joints, blueprint.drives, strict=True)
    ]
    return Loop(
        rate_hz=rate_hz,
        model=model,
        clock=clock,
        bus=bus,
        imu=imu,
        switches=switches,
        controller=Controller(model, blueprint.gaits, blueprint.default_gait),
        odometry=Odometry(model),
        feedforward=Feedforward(blueprint.drives),
        gate=Gate(model.joint_names, limits),
        safety=Safety(model, bus, rate_hz),
        record=record,
        tape=tape,
        sense=FootSense(model, blueprint.drives, by_load=by_load) if feels else None,
    )
