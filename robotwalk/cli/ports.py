"""Where buses are, as people type it."""

from typing import NamedTuple

from robotwalk.errors import UsageError


class Place(NamedTuple):
    """Where a robot is that a command moves."""

    ports: dict[str, str]  # URLs by bus
    on_bus: bool  # else in simulation


def place(port: list[str] | None, *, real: bool, **simulated: object) -> Place:
    """Read --port and --real; `simulated` are the options that a simulation alone has, None where not given.

    Raises:
        UsageError: they exclude each other.
    """
    ports = by_bus(port or [])
    on_bus = bool(ports) or real
    for option, value in simulated.items():
        if on_bus and value is not None:
            raise UsageError(f"--{option} is for a simulation; there is none behind a port")
    return Place(ports, on_bus)


def by_bus(words: list[str]) -> dict[str, str]:
    """Read `BUS=URL`s. Raises UsageError if one is something else."""
    ports = {}
    for word in words:
        bus, separator, url = word.partition("=")
        if not (bus and separator and url):
            raise UsageError(f"--port should be BUS=URL, such as legs=/dev/ttyUSB0, not {word!r}")
        ports[bus] = url
    return ports
