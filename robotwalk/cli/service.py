"""`robotwalk service`: the robot offered to drivers after every boot, by systemd."""

import getpass
import os
import shutil
import sys
from pathlib import Path

from cyclopts import App

from robotwalk import assembly
from robotwalk.cli.options import Flag, Json, RobotName
from robotwalk.cli.output import say, write_json
from robotwalk.doctor.computer import Computer
from robotwalk.doctor.service import Service, service
from robotwalk.errors import RobotwalkError, UsageError

app = App(name="service", help="Have this computer offer the robot to drivers after every boot.")


@app.command
def install(
    robot: RobotName | None = None, /, *, listen: str = "127.0.0.1:8765", user: str | None = None,
    dry_run: Flag = False, json: Json = False,
) -> None:
    """Write a systemd unit and a udev rule; as root. The robot sits, torque off, until a driver says stand.

    Parameters
    ----------
    listen
        HOST:PORT on which drivers are heard.
    user
        Whose rights it has. Default: who says this, or who said sudo.
    dry_run
        Print both, and write nothing; for the hexapod, if no robot is named.
    """
    if robot is None:
        if not dry_run:
            raise UsageError("name the robot that this computer shall offer: robotwalk service install ROBOT")
        robot = "hexapod"
    blueprint = assembly.load(robot, calibrated=True)
    named = str(Path(robot).resolve()) if Path(robot).suffix in (".yaml", ".yml") else robot
    hardware = blueprint.hardware
    ports = {name: line.port for name, line in {**hardware.buses, **hardware.sensors}.items()}
    found = service(
        blueprint.model.name, user or os.environ.get("SUDO_USER") or getpass.getuser(),
        [_program(), "teleop", named, "--real", "--seated", "--input", "socket", "--listen", listen], ports, Computer())
    if not dry_run:
        _write(found)
    if json:
        write_json({
            "name": found.name, "written": not dry_run, "unknown_ports": found.unknown,
            "files": [{"path": file.path, "text": file.text} for file in (found.unit, found.rule)]})
        return
    for file in (found.unit, found.rule):
        say(f"# {file.path}\n{file.text}\n" if dry_run else f"wrote {file.path}")
    for port in found.unknown:
        say(f"# {port}: no adapter with a serial number is plugged in there, so it has no rule of its own")
    if not dry_run:
        say(f"next: systemctl daemon-reload && udevadm control --reload && udevadm trigger && "
            f"systemctl enable --now {found.name}")
        say(f"an adapter with a rule is then /dev/{found.name}-LINE, too, wherever it is plugged in")


def _program() -> str:
    """Return the whole path of `robotwalk` as it is installed with this Python."""
    beside = Path(sys.executable).with_name("robotwalk")
    found = beside if beside.exists() else shutil.which("robotwalk")
    if found is None:
        raise RobotwalkError("the program robotwalk is not installed: neither beside this Python nor on the PATH")
    return str(found)


def _write(found: Service) -> None:
    """Write both files.

    Raises:
        UsageError: one would have to be root.
        RobotwalkError: a file cannot be written.
    """
    if os.geteuid() != 0:
        raise UsageError('this takes root: sudo "$(command -v robotwalk)" service install ROBOT, or look: --dry-run')
    for file in (found.unit, found.rule):
        failure = Computer().write(file.path, file.text)
        if failure is not None:
            raise RobotwalkError(f"cannot write {file.path}: {failure}")
