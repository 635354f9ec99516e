"""What people and scripts read: tables and complaints on a terminal, one JSON object for scripts."""

import contextlib
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

SCHEMA = 1


def complain(sentence: str) -> None:
    """Say on stderr what went wrong, in a sentence; to nobody if the terminal is gone."""
    with contextlib.suppress(OSError):
        sys.stderr.write(f"robotwalk: {sentence}\n")
        sys.stderr.flush()


def say(line: str) -> None:
    """Write a line of output."""
    sys.stdout.write(f"{line}\n")


def abandon_stdout() -> None:
    """Let nobody read the rest: a pipe or a terminal is gone, and the interpreter would complain at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def write_json(fields: dict[str, Any]) -> None:
    """Write one JSON object, on one line. NaN and infinities, which JSON does not have, are refused."""
    say(json.dumps({"schema": SCHEMA, **fields}, allow_nan=False))


def write_table(title: str, columns: list[str], rows: list[list[str]]) -> None:
    """Write a table, in colour where the terminal has it."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title, title_justify="left")
    for column in columns:
        table.add_column(column)
    for row in rows:
        table.add_row(*row)
    Console().print(table)


@contextmanager
def progress_line() -> Iterator[Callable[[str, float], None]]:
    """Show a bar on a terminal's stderr; yield what sets its text and its share, 0 to 1. Elsewhere, show nothing."""
    if not sys.stderr.isatty():
        yield lambda text, share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
    progress = Progress(*columns, console=Console(stderr=True), transient=True, auto_refresh=False)
    task = progress.add_task("", total=1.0)

    def show(text: str, share: float) -> None:
        # A terminal may go while the robot walks; that stops neither the walk nor the sitting down.
        with contextlib.suppress(OSError):
            progress.update(task, description=text, completed=share, refresh=True)

    with contextlib.suppress(OSError):
        progress.start()
    try:
        yield show
    finally:
        with contextlib.suppress(OSError):
            progress.stop()
