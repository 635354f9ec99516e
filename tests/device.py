"""The simulated robot as a device in a process of its own."""

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

COMMAND = [sys.executable, "-c", "from robotwalk.cli.main import main; main()"]


@contextlib.contextmanager
def served(robot: str, *where: str) -> Iterator[dict[str, str]]:
    """Run `robotwalk sim`; yield the URLs of its buses. It must end by SIGTERM, and in good order."""
    device = subprocess.Popen([*COMMAND, "sim", robot, *where], stdout=subprocess.PIPE, text=True)
    try:
        assert device.stdout is not None
        yield json.loads(device.stdout.readline())["buses"]
    finally:
        device.terminate()
        assert device.wait(20) == 143


def last_truth(path: Path) -> dict[str, Any]:
    """Return the newest whole line of a truth file, into which somebody is writing."""
    whole, _, _ = path.read_text().rpartition("\n")
    return dict(json.loads(whole.rpartition("\n")[2]))
