"""`robotwalk sim`: the simulated robot as a device, for any program that speaks to servos."""

import json
import math
import sys
from pathlib import Path

from robotwalk import assembly
from robotwalk.cli.options import Flag, RobotName
from robotwalk.cli.output import complain, say
from robotwalk.errors import UsageError
from robotwalk.interrupts import Interrupts


def sim(
    robot: RobotName, /, *, pty: Path | None = None, tcp: str | None = None, adapter: assembly.AdapterName = "none",
    truth: Path | None = None, duration: float | None = None, terrain: str = assembly.FLAT, seed: int = 0,
    faults: Path | None = None, view: Flag = False, hang: Flag = False,
) -> None:
    """Serve the simulated robot as a device in real time: seated, torque off, one serial port per bus.

    One JSON line on stdout says when it serves, and where. It serves until --duration is over or a signal comes.

    Parameters
    ----------
    pty
        Make a pseudo terminal for each bus and link it as DIR/BUS. Its servos hear what is sent at their baud rate.
        A robot that has an IMU also gets DIR/imu, on which that talks; one that has foot switches, DIR/feet.
    tcp
        Instead, listen at HOST:PORT, the next bus at the port after it. Only on this computer.
    adapter
        What delays the replies as a USB adapter does, or echoes as a bare UART.
    truth
        Write what really happens to this file, as JSON lines at 50 Hz.
    duration
        Seconds; default: until told to end.
    terrain
        The ground: a name from `robotwalk list terrains`, or the path of a YAML file.
    seed
        Of the simulation.
    faults
        What goes wrong, and when: a YAML file (see `robotwalk list faults`). It serves from 0.1 simulated seconds on.
    view
        Show it in the browser, on this machine only (needs the extra `robotwalk[view]`).
    hang
        On a stand, its feet off the ground.
    """
    if (pty is None) == (tcp is None):
        raise UsageError("say where to serve: either --pty DIR or --tcp HOST:PORT")
    if duration is not None and not (math.isfinite(duration) and duration > 0.0):
        raise UsageError(f"--duration should be a number of seconds above 0, not {duration}")
    if seed < 0:
        raise UsageError(f"--seed should not be negative, not {seed}")
    interrupts = Interrupts()
    interrupts.install()
    try:
        assembly.serve(
            robot, pty=pty, tcp=tcp, adapter=adapter, seed=seed, faults=faults or (), truth=truth, seconds=duration,
            ready=_announce, check=interrupts.check, warn=complain, terrain=terrain, view=view, hang=hang)
    finally:
        interrupts.restore()


def _announce(buses: dict[str, str], page: str | None) -> None:
    say(json.dumps({"ready": True, "buses": buses, **({"view": page} if page else {})}))
    sys.stdout.flush()
