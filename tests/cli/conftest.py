"""The command line as a user runs it: a process, its output, its exit code."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

COMMAND = [sys.executable, "-c", "from robotwalk.cli.main import main; main()"]


class Result(NamedTuple):
    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        fields = json.loads(self.out)
        assert self.out.count("\n") == 1, "exactly one JSON object, on one line"
        return fields


Run = Callable[..., Result]


@pytest.fixture
def robotwalk(tmp_path: Path) -> Run:
    """Run `robotwalk` with some words in an empty folder."""

    def run(*words: str) -> Result:
        done = subprocess.run(
            [*COMMAND, *words], capture_output=True, text=True, cwd=tmp_path, stdin=subprocess.DEVNULL, check=False,
            env={**os.environ, "XDG_STATE_HOME": str(tmp_path / "state")})
        assert "Traceback" not in done.stderr
        return Result(done.returncode, done.stdout, done.stderr)

    return run
