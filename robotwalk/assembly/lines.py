"""A robot's serial lines, opened: by whom it is asked to be a physical one, and no other."""

from collections.abc import Mapping

from hal.serial_transport import names_hardware, open_plainly, open_port
from robotwalk.assembly.blueprint import Blueprint
from robotwalk.errors import UsageError
from robotwalk.ports import BytePort


def open_lines(blueprint: Blueprint, urls: Mapping[str, str]) -> dict[str, BytePort]:
    """Open all lines at these URLs, or none.

    Raises:
        BusError: one does not open.
    """
    opened: dict[str, BytePort] = {}
    try:
        for name, url in urls.items():
            # Only what answers to us may echo.
            sensor = name in blueprint.hardware.sensors
            opened[name] = (open_plainly if sensor else open_port)(url, blueprint.lines[name])
    except BaseException:
        close_lines(opened)
        raise
    return opened


def close_lines(ports: Mapping[str, BytePort]) -> None:
    """Give lines back."""
    for port in ports.values():
        port.close()


def urls_of(blueprint: Blueprint, ports: Mapping[str, str], real: bool) -> dict[str, str]:
    """Return the URL of every line, as `ports` or else the robot's file has it.

    Raises:
        UsageError: there is no such line, or it may lead to a physical robot, and that was not asked for.
    """
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
