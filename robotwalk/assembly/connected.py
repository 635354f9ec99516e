"""A robot on serial lines, in real time: its loop in a process of its own, which this one starts and guards.

A new interpreter, not a fork: what is forked shares its pages with its parent, and each first write to one, of a
reference count even, is a page fault in the loop; it would inherit a caller's threads as locks that nobody holds; and
all that a command has loaded would be locked into memory.
"""

import contextlib
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from hal.hardware import FEET_PORT, IMU_PORT, STOP_PORT
from robotwalk.assembly.blueprint import Blueprint, load
from robotwalk.assembly.lines import close_lines, open_lines, urls_of
from robotwalk.assembly.session import (
    RATE_HZ,
    LocalSession,
    Session,
    bus_of,
    check_rate,
    engine_of,
    gate_of,
    open_log,
    robot_of,
)
from robotwalk.assembly.stop_reader import StopReader, unreadable, watch_of
from robotwalk.clock import WallClock
from robotwalk.kinematics import resting_angles
from robotwalk.ports import BytePort
from robotwalk.process.driver import RemoteLoop, RemoteSensor
from robotwalk.process.guardian import Guardian
from robotwalk.process.log_feed import emptier
from robotwalk.process.mailbox import packed
from robotwalk.process.messages import REPORT, Brief
from robotwalk.process.rescue import bring_down
from robotwalk.process.shared import Mailbox, create
from robotwalk.process.stop_input import StopWatch
from robotwalk.recorder import Recorder
from robotwalk.robot import Robot


def connect(
    robot: str | Blueprint, ports: Mapping[str, str], *, real: bool = False, rate_hz: int = RATE_HZ,
    log: Path | None = None,
) -> Session:
    """Open a robot's serial lines and start its loop, for a walk in real time. Nothing moves yet.

    Args:
        robot: its name, path or blueprint.
        ports: URLs by the names of buses, of the IMU as "imu", of the foot switches as "feet", of a stop input's own
            port as "stop", in place of those in the robot's file.
        real: whether URLs may lead to a physical robot.
        rate_hz: ticks per second.
        log: where to record every tick.

    Raises:
        UsageError: no such robot or bus, a rate or a log that is impossible, or a physical robot not asked for.
        ConfigError: a file is wrong.
        BusError: a port does not open.
        RobotwalkError: the loop's process does not start.
    """
    blueprint = load(robot, calibrated=True) if isinstance(robot, str) else robot
    check_rate(rate_hz)
    urls = urls_of(blueprint, ports, real)
    opened = open_lines(blueprint, urls)
    try:
        recorder = open_log(log, blueprint, rate_hz, urls)
        loop = _start(blueprint, urls, opened, rate_hz, recorder)
    except BaseException:
        close_lines(opened)
        raise
    sensors = {line: RemoteSensor(loop, line) for line in blueprint.hardware.sensors}
    walker = Robot(
        blueprint.model, tuple(blueprint.gaits), loop, loop, imu=sensors.get(IMU_PORT),
        foot_switches=sensors.get(FEET_PORT), recorder=recorder, torque=blueprint.torque, refused=blueprint.refused)
    for sentence in loop.status.lacking:
        walker.note("real_time", sentence)
    lacking = unreadable(blueprint.hardware.stop_input, urls)
    if lacking is not None:
        walker.note("stop_input", lacking)
    return Session(blueprint, walker)


def attach(robot: str | Blueprint, ports: Mapping[str, str], *, rate_hz: int = RATE_HZ) -> LocalSession:
    """Open a robot's serial lines for a loop in this process, which nobody guards: for tools that look at the bus.

    Raises:
        UsageError, ConfigError, BusError: as `connect` does.
    """
    blueprint = load(robot, calibrated=True) if isinstance(robot, str) else robot
    check_rate(rate_hz)
    clock = WallClock()
    engine = engine_of(blueprint, clock, open_lines(blueprint, urls_of(blueprint, ports, real=False)), rate_hz)
    return LocalSession(blueprint, robot_of(blueprint, engine), engine.bus, clock)


def _start(
    blueprint: Blueprint, urls: Mapping[str, str], opened: Mapping[str, BytePort], rate_hz: int,
    recorder: Recorder | None,
) -> RemoteLoop:
    """Start the process of the loop, who guards it, and who reads its stop input."""
    config = None if unreadable(blueprint.hardware.stop_input, urls) else blueprint.hardware.stop_input
    with contextlib.ExitStack() as undo:
        shared, path = create(blueprint.model.name)
        undo.callback(path.unlink, missing_ok=True)
        undo.callback(os.close, shared)
        mailbox = Mailbox(shared)
        reader = StopReader(config, urls, opened, shared) if config is not None else None
        if reader is not None:
            undo.callback(reader.close)
        doorbell = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        undo.callback(os.close, doorbell)
        lines = {name: (urls[name], port.fileno()) for name, port in opened.items() if name != STOP_PORT}
        brief = Brief(
            os.getpid(), blueprint.files.texts(), lines, shared, doorbell, rate_hz, recorded=recorder is not None,
            stop_input=config is not None, hung=blueprint.hung)
        process = subprocess.Popen(
            [sys.executable, "-m", "robotwalk.assembly.loop_process", blueprint.model.name],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, start_new_session=True,
            pass_fds=[
                shared, doorbell, *([reader.lease] if reader is not None else []),
                *(descriptor for _, descriptor in lines.values())])
        undo.callback(process.wait)
        undo.callback(process.kill)
        assert process.stdin is not None
        with contextlib.suppress(BrokenPipeError), process.stdin:
            process.stdin.write(packed(brief))
        guardian = Guardian(
            process, mailbox, lambda: _rescue(blueprint, opened, mailbox, watch_of(config, mailbox)),
            emptier(mailbox.log, recorder))
        undo.callback(guardian.stand_down)

        def give_back() -> None:
            if reader is not None:
                reader.close()
            close_lines(opened)
            os.close(shared)

        loop = RemoteLoop(rate_hz, mailbox, path, doorbell, process, guardian, give_back)
        undo.pop_all()
        return loop


def _rescue(
    blueprint: Blueprint, ports: Mapping[str, BytePort], mailbox: Mailbox, watch: StopWatch,
) -> list[str]:
    """Bring a robot down whose loop is gone. Never raises."""
    clock = WallClock()
    bus = bus_of(blueprint, clock, ports)
    seat = resting_angles(blueprint.model, blueprint.model.heights.sit)
    try:
        message = mailbox.telemetry.newest()
        believed = REPORT.unpack(message.data).tick.goals if message is not None else seat
        return bring_down(bus, clock, gate_of(blueprint), believed, seat, watch)
    except Exception:
        return bus.disarm()
