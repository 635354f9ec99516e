"""A robot on a bus: locomotion, the loop and the servos joined."""

import platform
from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import robotwalk
from hal.foot_switches.serial_foot_switches import SerialFootSwitches
from hal.hardware import FEET_PORT, IMU_PORT
from hal.imu.serial_imu import SerialImu
from hal.protocols import protocol_of
from hal.servo_bus import SerialServoBus
from hal.servo_line import ServoLine
from robotwalk.assembly.blueprint import LIMP, Blueprint
from robotwalk.black_box import BlackBox, folder
from robotwalk.contact import FootSense
from robotwalk.controller import Controller
from robotwalk.end_stops import EndStops
from robotwalk.errors import UsageError
from robotwalk.feedforward import Feedforward
from robotwalk.folded import Folded
from robotwalk.limits import Gate, JointLimit
from robotwalk.loop import Loop
from robotwalk.ports import BytePort, Clock, FootSwitches, Imu, ServoBus
from robotwalk.recorder import Recorder, Row
from robotwalk.robot import Robot
from robotwalk.safety import Safety
from robotwalk.self_collision import SelfCollision
from robotwalk.tape import Tape, TapedClock, TapedPort
from robotwalk.timing import Histogram
from robotwalk.walker import Part, Walker

RATE_HZ = 100
_GOAL_LEAD = 3.0  # a goal may run this much faster than the servo, so that feed-forward is not cut
_FEELING_HZ = 80  # below, a joint's acceleration between two samples is not known well enough to feel the ground
_FULL_SPEED_WITHIN = 0.005  # s


@dataclass(frozen=True)
class Session:
    """A robot ready to be armed."""

    blueprint: Blueprint
    robot: Robot


@dataclass(frozen=True)
class LocalSession(Session):
    """One whose loop runs in this process."""

    bus: SerialServoBus
    clock: Clock


class Recording(Protocol):
    """What a loop's recorder is to it."""

    tape: Tape

    def put(self, row: Row) -> None:
        """Take a tick's row."""
        ...


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
    return Recorder(
        log, blueprint.model.joint_names, {**head_of(blueprint, rate_hz), **about}, buses=tuple(blueprint.lines),
        files={**blueprint.files.texts(), **(more or {})})


def head_of(blueprint: Blueprint, rate_hz: int) -> dict[str, str]:
    """Return what goes into the head of every log."""
    return {
        "robot": blueprint.model.name, "robotwalk": robotwalk.__version__, "python": platform.python_version(),
        "rate_hz": str(rate_hz), **({"hung": "true"} if blueprint.hung else {})}


def add_black_box(session: Session, where: Path | None = None) -> None:
    """Have the last minute of a session kept, and saved to a folder when its robot stops for its safety.

    Args:
        session: not begun yet.
        where: the folder; None: that of the user's state, `robotwalk.black_box.folder`.
    """
    blueprint, robot = session.blueprint, session.robot
    robot.black_box = BlackBox(
        where or folder(), head_of(blueprint, robot.loop.rate_hz), blueprint.files.texts(),
        blueprint.model.joint_names, robot.loop.rate_hz)


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


@dataclass(frozen=True)
class Engine:
    """A robot's loop, and what it reads and writes."""

    loop: Loop
    bus: SerialServoBus
    imu: SerialImu | None
    switches: SerialFootSwitches | None


def engine_of(
    blueprint: Blueprint, clock: Clock, ports: Mapping[str, BytePort], rate_hz: int, recording: Recording | None = None,
    histograms: tuple[Histogram, Histogram, Histogram] | None = None,
) -> Engine:
    """Join the loop around a robot's opened lines; it counts its times in `histograms`, if they are given."""
    if recording is not None:
        ports = {name: TapedPort(name, port, clock, recording.tape) for name, port in ports.items()}
        clock = TapedClock(clock, recording.tape)
    bus = bus_of(blueprint, clock, ports)
    record, tape = (recording.put, recording.tape) if recording else (None, None)
    imu, switches = imu_of(blueprint, clock, ports), foot_switches_of(blueprint, clock, ports)
    loop = loop_of(blueprint, clock, bus, imu, switches, rate_hz, record, tape, histograms)
    return Engine(loop, bus, imu, switches)


def robot_of(
    blueprint: Blueprint, engine: Engine, recorder: Recorder | None = None,
) -> Robot:
    """Return the robot of a loop in this process."""
    return Robot(
        blueprint.model, tuple(blueprint.gaits), engine.loop, engine.bus, imu=engine.imu,
        foot_switches=engine.switches, recorder=recorder, torque=blueprint.torque, refused=blueprint.refused)


def gate_of(blueprint: Blueprint) -> Gate:
    """Return the gate before a robot's servos."""
    limits = [
        JointLimit(
            joint.lower, joint.upper, _GOAL_LEAD * drive.max_speed, _GOAL_LEAD * drive.max_speed / _FULL_SPEED_WITHIN)
        for joint, drive in zip(blueprint.model.joints, blueprint.drives, strict=True)]
    collision = SelfCollision(
        blueprint.model, [limit.speed for limit in limits], [limit.acceleration for limit in limits])
    return Gate(blueprint.model.joint_names, limits, collision)


def loop_of(
    blueprint: Blueprint, clock: Clock, bus: ServoBus, imu: Imu | None, switches: FootSwitches | None, rate_hz: int,
    record: Callable[[Row], None] | None = None, tape: Tape | None = None,
    histograms: tuple[Histogram, Histogram, Histogram] | None = None,
) -> Loop:
    """Join the stages into a loop around a bus, an IMU and foot switches, if there are any."""
    model = blueprint.model
    by_load = rate_hz >= _FEELING_HZ
    feels = model.contact is not None and (by_load or switches is not None)

    def regroup(dead: Set[int]) -> Walker:
        """Return what walks on without the legs of dead joints."""
        lost = {leg.name for leg in model.legs if dead & set(range(len(model.joints))[leg.span])}
        left, gaits, slots, legs = blueprint.without(lost)
        part = Part(slots, legs, Folded(model, lost, dead))
        return Walker(left, Controller(left, gaits, LIMP), gaits, part=part)

    return Loop(
        rate_hz=rate_hz,
        clock=clock,
        bus=bus,
        imu=imu,
        switches=switches,
        walker=Walker(
            model, Controller(model, blueprint.gaits, blueprint.default_gait), blueprint.gaits,
            FootSense(model, blueprint.drives, 1.0 / rate_hz, by_load=by_load) if feels else None),
        feedforward=Feedforward(blueprint.drives, lag=model.leads.lag, load=model.leads.load),
        end_stops=EndStops(
            [(joint.lower, joint.upper) for joint in model.joints], blueprint.drives, 1.0 / rate_hz),
        gate=gate_of(blueprint),
        safety=Safety(model, bus, rate_hz, blueprint.drives),
        record=record,
        tape=tape,
        regroup=regroup,
        histograms=histograms,
    )
