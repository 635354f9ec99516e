"""A simulated robot in a process of its own, for a driver that has no robot: what `robotwalk sim --pty` serves."""

import contextlib
import ctypes
import json
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from robotwalk.errors import BusError

_PR_SET_PDEATHSIG = 1  # linux/prctl.h
_COMMAND = (sys.executable, "-c", "from robotwalk.cli.main import main; main()", "sim")


class OwnDevice(NamedTuple):
    """Where a device is."""

    ports: dict[str, str]  # URLs by the names of buses and sensors
    page: str | None  # that shows it


@contextlib.contextmanager
def own_device(robot: str, options: Mapping[str, object]) -> Iterator[OwnDevice]:
    """Serve a simulated robot for as long as the block lasts, or this process; yield where it is.

    `options` are those of `robotwalk sim`, by their names; None or False leaves one out.

    Raises:
        BusError: it does not start, as its words on stderr tell.
    """
    words: list[str] = []
    for name, value in options.items():
        if value not in (None, False):
            words += [f"--{name}"] if value is True else [f"--{name}", str(value)]
    with tempfile.TemporaryDirectory(prefix="robotwalk-") as folder:
        # In a session of its own: a Ctrl-C or a hang-up of the terminal is for the driver, which seats the robot first.
        device = subprocess.Popen(
            [*_COMMAND, robot, "--pty", str(Path(folder) / "lines"), *words], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, text=True, start_new_session=True, preexec_fn=_end_with_parent)
        try:
            assert device.stdout is not None
            line = device.stdout.readline()
            if not line:
                raise BusError("the simulated robot did not start")
            told = json.loads(line)
            yield OwnDevice(told["buses"], told.get("view"))
        finally:
            device.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                device.wait(5.0)
            device.kill()
            device.wait()


def _end_with_parent() -> None:
    """Have the kernel end this process once its parent is gone, however that ended."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, ctypes.c_ulong(signal.SIGTERM))
