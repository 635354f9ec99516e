"""Where buses are, as people type it."""

from collections.abc import Sequence

from robotwalk.errors import UsageError


def by_bus(words: Sequence[str]) -> dict[str, str]:
    """Read `BUS=URL`s. Raises UsageError if one is something else."""
    ports = {}
    for word in words:
        bus, separator, url = word.partition("=")
        if not (bus and separator and url):
            raise UsageError(f"--port should be BUS=URL, such as legs=/dev/ttyUSB0, not {word!r}")
        ports[bus] = url
    return ports
