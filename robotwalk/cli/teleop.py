"""`robotwalk teleop`: a person or a program drives the robot, live."""

import math
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path

from robotwalk import assembly
from robotwalk.cli.drivers import Drivers
from robotwalk.cli.ending import run_to_end
from robotwalk.cli.options import Faults, Flag, Log, Rate, RobotName, Terrain, Where
from robotwalk.cli.output import abandon_stdout, complain, say, write_json
from robotwalk.command_check import check_command
from robotwalk.doctor.notify import Notify
from robotwalk.robot import Robot
from robotwalk.teleop import messages
from robotwalk.teleop.ask import Device
from robotwalk.teleop.bridge import Bridge
from robotwalk.teleop.drive import Drive
from robotwalk.teleop.tiller import Tiller
from robotwalk.teleop.told import Told
from robotwalk.types import Command


def teleop(
    robot: RobotName, /, *, drivers: Drivers = Drivers(), gait: str | None = None, rate: Rate = assembly.RATE_HZ,
    where: Where = Where(), seated: Flag = False, terrain: Terrain = None, faults: Faults = None,
    seed: int | None = None, truth: Path | None = None, view: Flag = False, log: Log = None, json: Flag = False,
) -> int:
    """Stand up and be driven: a simulated robot in real time, or with --port or --real the one on a bus.

    One driver at a time; whoever asks first has the helm until it rests for half a second. STOP is heard from anyone.

    Parameters
    ----------
    gait
        To begin with. Default: the first that it has of tripod, tetrapod, trot and wave.
    seated
        Begin with torque off, until a driver says stand; as after a boot.
    seed
        Of the simulation.
    truth
        Write what really happens in the simulation to this file, as JSON lines at 50 Hz.
    view
        Show the simulation in the browser, on this machine only (needs the extra `robotwalk[view]`).
    json
        JSON lines on stdout: one when drivers are heard, and one at the end.
    """
    simulated = {"terrain": terrain, "faults": faults, "seed": seed, "truth": truth, "view": view or None}
    ports = where.ports
    assembly.check_rate(rate)
    blueprint = where.blueprint(robot, **simulated)
    check = _check_of(blueprint)
    check(Command(gait=gait))
    tiller = Tiller(
        blueprint.model.motion, blueprint.model.heights,
        [name for name in blueprint.gaits if name not in blueprint.refused], gait or blueprint.default_gait)
    if terrain is not None:
        assembly.load_terrain(terrain)
    with ExitStack() as stack:
        systemd = stack.enter_context(closing(Notify()))
        devices: list[Device] = []
        screen = _screen(stack, blueprint.model.name, tiller, devices)

        def show(now: float, told: Told, refusal: str | None) -> None:
            systemd.alive(now)
            screen(now, told, refusal)

        for device in drivers.opened(blueprint, tiller):
            devices.append(device)
            stack.callback(device.close)
        page: str | None = None
        what = "ports are opened" if where.on_bus else "a simulated robot starts"
        show(time.monotonic(), Told(note=f"wait: {what}"), None)
        if not where.on_bus:
            served = stack.enter_context(assembly.own_device(robot, {**simulated, "hang": where.hang}))
            ports, page = served.ports, served.page
        session = assembly.connect(blueprint, ports, real=where.real, rate_hz=rate, log=log)
        assembly.add_black_box(session)
        _say_ready(devices, page, json)
        systemd.ready()
        drive = Drive(
            session.robot, Bridge(devices, check), show, f"see it at {page}" if page else "", seated=seated,
            ending=systemd.stopping)
        code, sentence = run_to_end(session.robot, drive.run)
    if sentence is not None:
        complain(sentence)
    untold = _tell(session.robot, drive, json)
    return code or untold


def _check_of(blueprint: assembly.Blueprint) -> Callable[[Command], None]:
    """Return what raises UsageError for a command that makes no sense for a robot."""
    return partial(
        check_command, model=blueprint.model, gaits=tuple(blueprint.gaits), refused=blueprint.refused)


def _screen(
    stack: ExitStack, robot: str, tiller: Tiller, devices: Sequence[Device],
) -> Callable[[float, Told, str | None], None]:
    """Return what shows the state: on a terminal a screen, else nothing."""
    if not sys.stderr.isatty():
        return lambda now, told, refusal: None
    from robotwalk.teleop.screen import Screen

    return stack.enter_context(Screen(robot, tiller, devices)).show


def _say_ready(devices: Sequence[Device], page: str | None, json: bool) -> None:
    """Say where drivers are heard, to whoever cannot see it on the screen."""
    inputs = [device.status for device in devices]
    if json:
        write_json({"ready": True, "inputs": inputs, **({"view": page} if page else {})})
        sys.stdout.flush()
    elif not sys.stderr.isatty():
        complain(f"driven by {', '.join(inputs)}{f'; see it at {page}' if page else ''}")


def _tell(robot: Robot, drive: Drive, json: bool) -> int:
    """Say what came of it; return 1 if nobody could be told, else 0."""
    told = drive.told
    try:
        if json:
            write_json({
                "robot": robot.model.name, **messages.fields(told),
                "events": [event._asdict() for event in robot.events]})
        else:
            for event in robot.events:
                if event.kind not in ("state", "interrupt"):
                    say(f"{event.t:6.2f} s  {event.text}")
            pose = told.pose
            say(f"{robot.model.name} was up for {drive.seconds:.0f} s; by its odometry it ended at x {pose.x:+.2f} m, "
                f"y {pose.y:+.2f} m, turned {math.degrees(pose.yaw):+.0f} deg")
        sys.stdout.flush()
    except OSError:
        abandon_stdout()
        return 1
    return 0
