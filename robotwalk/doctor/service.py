"""What has a computer offer a robot after each boot: a systemd unit, and a udev rule for its ports.

The robot sits with torque off until a driver says `stand`. That the loop keeps running is the guardian's business, its
parent's; systemd starts both again.
"""

import re
import shlex
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from robotwalk.doctor.computer import Computer
from robotwalk.doctor.remedy import Write
from robotwalk.doctor.rights import AWAKE, GROUP

_UNIT = """\
[Unit]
Description=robotwalk: {robot}, torque off until a driver says stand
Documentation=man:systemd.service(5)

[Service]
Type=notify
User={user}
SupplementaryGroups={group}
ExecStart={command}
# It sits down first; SIGKILL to all of it only after that.
KillMode=mixed
TimeoutStopSec=40
# What it ends with when it is told to end.
SuccessExitStatus=143
# The loop sits down by itself after 10 s without its driver.
WatchdogSec=30
Restart=on-failure
RestartSec=5
# A file that is wrong or an option that there is not gets no better by trying again.
RestartPreventExitStatus=2 3
LimitRTPRIO=80
LimitMEMLOCK=infinity
NoNewPrivileges=yes

[Install]
WantedBy=multi-user.target
"""


class Adapter(NamedTuple):
    """A USB adapter as udev knows it."""

    serial: str
    interface: str  # one adapter may have several


class Service(NamedTuple):
    """What is to be installed."""

    name: str  # of the unit
    unit: Write
    rule: Write
    unknown: tuple[str, ...]  # ports whose adapter is not plugged in, or has no serial number


def service(
    robot: str, user: str, command: Sequence[str], ports: Mapping[str, str], computer: Computer
) -> Service:
    """Return what offers a robot after each boot.

    Args:
        robot: its name.
        user: whose rights it has.
        command: that offers it, with the whole path of the program.
        ports: the robot's serial ports by the names of their lines.
        computer: where their adapters are plugged in.
    """
    name = re.sub(r"[^a-z0-9]+", "-", f"robotwalk {robot}".lower()).strip("-")
    rules = [
        f"# robotwalk: the ports of {robot}, by the serial numbers of their adapters; the latency of FTDI adapters.",
        'ACTION=="add", SUBSYSTEM=="usb-serial", DRIVER=="ftdi_sio", ATTR{latency_timer}="1"',
        AWAKE.remedy.writes[0].text]
    unknown = []
    for line, port in ports.items():
        adapter = adapter_at(computer, port)
        if adapter is None:
            unknown.append(port)
            continue
        rules.append(
            f'SUBSYSTEM=="tty", ENV{{ID_SERIAL_SHORT}}=="{adapter.serial}", '
            f'ENV{{ID_USB_INTERFACE_NUM}}=="{adapter.interface}", '
            f'SYMLINK+="{name}-{line}", GROUP="{GROUP}", MODE="0660"')
    unit = _UNIT.format(robot=robot, user=user, group=GROUP, command=shlex.join(command).replace("%", "%%"))
    return Service(
        name, Write(f"/etc/systemd/system/{name}.service", unit.rstrip()),
        Write(f"/etc/udev/rules.d/70-{name}.rules", "\n".join(rules)), tuple(unknown))


def adapter_at(computer: Computer, port: str) -> Adapter | None:
    """Return the USB adapter behind a serial port, as /sys has it; None if there is none with a serial number."""
    place = computer.there(f"/sys/class/tty/{port.removeprefix('/dev/')}/device")
    if not place.exists():
        return None
    interface = "00"
    for folder in (place.resolve(), *place.resolve().parents):
        if (folder / "bInterfaceNumber").is_file():
            interface = (folder / "bInterfaceNumber").read_text().strip()
        if (folder / "serial").is_file():
            return Adapter((folder / "serial").read_text().strip(), interface)
    return None
