"""`robotwalk servo monitor`: what servos measure, live."""

import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from robotwalk.assembly import workbench
from robotwalk.cli.options import Json
from robotwalk.cli.output import say, write_json
from robotwalk.cli.servo.options import Line, ServoId
from robotwalk.clock import Grid
from robotwalk.errors import UsageError

if TYPE_CHECKING:
    from rich.table import Table

_NS = 1_000_000_000
_COLUMNS = ("id", "model", "position", "velocity", "load", "supply", "temperature", "hardware")
_LARGEST_RATE = 200

Samples = Sequence[workbench.Sample | None]


def monitor(
    *servo_ids: ServoId, line: Line, rate: int = 5, seconds: float | None = None, json: Json = False
) -> None:
    """Show what servos measure, again and again. Nothing is switched on or moved.

    Parameters
    ----------
    servo_ids
        Default: all servos on the line.
    rate
        Times a second; fewer if the line cannot carry it.
    seconds
        Default: until Ctrl-C.
    """
    if not 1 <= rate <= _LARGEST_RATE:
        raise UsageError(f"--rate should be 1 to {_LARGEST_RATE} times a second, not {rate}")
    if seconds is not None and not (math.isfinite(seconds) and seconds > 0.0):
        raise UsageError(f"--seconds should be above 0, not {seconds}")
    with line.reading() as bench:
        servos = bench.servos(servo_ids)
        with _json_lines(servos) if json else _live(servos) as show:
            _watch(bench, servos, rate, seconds, show)


def _watch(
    bench: workbench.Bench, servos: list[workbench.Servo], rate: int, seconds: float | None,
    show: Callable[[float, Samples], None],
) -> None:
    """Sample on a grid of absolute deadlines."""
    began = bench.clock.now()
    ends = math.inf if seconds is None else began + seconds * _NS
    grid = Grid(rate, began)
    while grid.deadline <= ends:
        bench.clock.wait((), grid.deadline)
        at = bench.clock.now()
        show((at - began) / _NS, [workbench.sample(servo) for servo in servos])
        grid.advance(bench.clock.now())


@contextmanager
def _json_lines(servos: list[workbench.Servo]) -> Iterator[Callable[[float, Samples], None]]:
    def show(t: float, samples: Samples) -> None:
        write_json({"t": round(t, 4), "servos": [
            _fields(servo, sample) for servo, sample in zip(servos, samples, strict=True)]})
        sys.stdout.flush()

    yield show


@contextmanager
def _live(servos: list[workbench.Servo]) -> Iterator[Callable[[float, Samples], None]]:
    """Redraw a table on a terminal; elsewhere write a line for each servo."""
    if not sys.stdout.isatty():

        def write(t: float, samples: Samples) -> None:
            for servo, sample in zip(servos, samples, strict=True):
                say(f"{t:8.2f} s  id {'  '.join(_cells(servo, sample))}")
            sys.stdout.flush()

        yield write
        return
    from rich.live import Live

    with Live(auto_refresh=False) as live:
        yield lambda t, samples: live.update(_table(t, servos, samples), refresh=True)


def _table(t: float, servos: list[workbench.Servo], samples: Samples) -> "Table":
    from rich.table import Table

    table = Table(title=f"{t:.1f} s    Ctrl-C ends", title_justify="left")
    for column in _COLUMNS:
        table.add_column(column, justify="left" if column in ("model", "hardware") else "right")
    for servo, sample in zip(servos, samples, strict=True):
        table.add_row(*_cells(servo, sample))
    return table


def _cells(servo: workbench.Servo, sample: workbench.Sample | None) -> list[str]:
    if sample is None:
        return [str(servo.id), servo.model.name, "", "", "", "", "", "no answer"]
    return [
        str(servo.id), servo.model.name, f"{sample.position_deg:+.1f} deg", f"{sample.velocity_deg_s:+.1f} deg/s",
        f"{sample.load_percent:+.1f} %", f"{sample.voltage_v:.1f} V", f"{sample.temperature_c:.0f} degC",
        ", ".join(sample.errors) or "ok"]


def _fields(servo: workbench.Servo, sample: workbench.Sample | None) -> dict[str, Any]:
    if sample is None:
        return {"id": servo.id, "answered": False}
    fields = {name: round(value, 3) if isinstance(value, float) else value for name, value in sample._asdict().items()}
    return fields | {"answered": True}
