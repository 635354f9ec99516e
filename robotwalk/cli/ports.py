"""Where buses are, as people type it."""

from robotwalk.errors import UsageError

HANGING = 0.35  # of the torque, for the first motion on a stand


def by_bus(words: list[str]) -> dict[str, str]:
    """Read `BUS=URL`s. Raises UsageError if one is something else."""
    ports = {}
    for word in words:
        bus, separator, url = word.partition("=")
        if not (bus and separator and url):
            raise UsageError(f"--port should be BUS=URL, such as legs=/dev/ttyUSB0, not {word!r}")
        ports[bus] = url
    return ports
