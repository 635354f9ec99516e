"""The command line as a user runs it: its words, its output, its exit code."""

import json
import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from robotwalk.cli.main import main

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
    """Run `robotwalk` with some words in an empty folder, in a process of its own."""

    def run(*words: str) -> Result:
        done = subprocess.run(
            [*COMMAND, *words], capture_output=True, text=True, cwd=tmp_path, stdin=subprocess.DEVNULL, check=False,
            env={**os.environ, "XDG_STATE_HOME": str(tmp_path / "state")})
        assert "Traceback" not in done.stderr
        return Result(done.returncode, done.stdout, done.stderr)

    return run


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run it in this process, on a terminal of 100 columns: where nothing walks, most time goes into starting one."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))

    def run(*words: str) -> Result:
        monkeypatch.setattr("sys.argv", ["robotwalk", *words])  # from where `main` reads them, as it should
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Cyclopts application invoked without tokens")
            with pytest.raises(SystemExit) as stop:
                main()
        return Result(stop.value.code, *capsys.readouterr())

    return run
