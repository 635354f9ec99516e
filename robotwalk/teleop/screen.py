"""What the person at the terminal sees: 80 columns and 24 lines are enough."""

import contextlib
import math
import select
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Self

from rich.console import Console, Group
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from robotwalk.teleop.ask import Device
from robotwalk.teleop.tiller import Tiller
from robotwalk.teleop.told import Told
from robotwalk.types import Measured, ServoCondition

_PERIOD = 0.2  # s between two pictures; over SSH each is 2 kB
_BAR = 24  # columns
_COLOURS = {"stand": "green", "walk": "green", "fault": "red", "held": "red", "stop": "white"}


class Screen:
    """Redraws itself a few times a second while the terminal takes it; a terminal that hangs misses pictures."""

    def __init__(self, robot: str, tiller: Tiller, devices: Sequence[Device]) -> None:
        """Prepare the screen of a robot and of the devices that drive it."""
        self._robot = robot
        self._tiller = tiller
        self._devices = devices
        self._console = Console(stderr=True, markup=False, highlight=False)
        self._live = Live(
            console=self._console, screen=True, auto_refresh=False, redirect_stdout=False, redirect_stderr=False)
        self._began: float | None = None
        self._next = -math.inf

    def __enter__(self) -> Self:
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with contextlib.suppress(OSError):
            self._live.stop()

    def show(self, now: float, told: Told, news: str | None) -> None:
        """Draw, if it is time; `news` comes before what is told."""
        if self._began is None:
            self._began = now
        if now < self._next:
            return
        self._next = now + _PERIOD
        with contextlib.suppress(OSError):
            if select.select([], [self._console.file], [], 0.0)[1]:
                self._live.update(self.picture(now - self._began, told, news or told.note), refresh=True)

    def picture(self, seconds: float, told: Told, news: str) -> Panel:
        """Return the picture, `seconds` after the start."""
        tiller = self._tiller
        rows = Table.grid(padding=(0, 2))
        rows.add_column(style="bold", min_width=8, no_wrap=True)
        rows.add_column(no_wrap=True, overflow="ellipsis")
        state = Text(f" {told.state.upper()} ", style=f"bold reverse {_COLOURS.get(told.state, 'yellow')}")
        driver = f"{told.driver} drives" if told.driver else "nobody drives"
        rows.add_row("state", Text.assemble(state, f"  {tiller.gait}, {driver}"))
        speed, turn = math.hypot(told.twist.vx, told.twist.vy), math.degrees(told.twist.wz)
        full = math.degrees(tiller.turn)
        rows.add_row("speed", f"{speed:5.3f} m/s    {_bar(speed / tiller.speed)} of {tiller.speed:.3f}")
        rows.add_row("turn", f"{turn:+5.1f} deg/s  {_bar(abs(turn) / full)} of {full:.0f}")
        pose, lean = told.pose, tiller.posture
        by = "held while you go" if tiller.by_heading else "free"
        rows.add_row("heading", f"{math.degrees(pose.yaw):+.1f} deg ({by}), at x {pose.x:+.2f} y {pose.y:+.2f} m")
        rows.add_row("body", f"height {1e3 * tiller.height:.0f} mm, roll {math.degrees(lean.roll):+.0f}, "
            f"pitch {math.degrees(lean.pitch):+.0f}, yaw {math.degrees(lean.yaw):+.0f} deg")
        rows.add_row()
        rows.add_row("servos", _worst(told))
        rows.add_row("bus", _traffic(told))
        wake, exchange, compute = (1e-3 * each.p99 for each in (told.wake, told.exchange, told.compute))
        rows.add_row("loop", f"{told.rate_hz} Hz, {told.missed} of {told.ticks + told.missed} missed, "
            f"p99 wake {wake:.1f} bus {exchange:.1f} tick {compute:.1f} ms")
        rows.add_row()
        for number, device in enumerate(self._devices):
            rows.add_row("" if number else "input", device.status)
        rows.add_row("", Text(news, style="bold yellow", overflow="ellipsis", no_wrap=True))
        lines = "\n".join(line for device in self._devices for line in device.help)
        keys = Text(lines, style="dim", no_wrap=True, overflow="ellipsis")
        clock = f"{int(seconds) // 60:02d}:{int(seconds) % 60:02d}"
        return Panel(
            Group(rows, keys), title=f"robotwalk teleop {self._robot}", subtitle=clock, title_align="left",
            subtitle_align="right")


def _bar(share: float) -> str:
    full = round(min(max(share, 0.0), 1.0) * _BAR)
    return "█" * full + "·" * (_BAR - full)


def _traffic(told: Told) -> str:
    """Return what all buses lost, and the one that lost most."""
    lost = sum(bus.lost_replies for bus in told.buses.values())
    bad = sum(bus.bad_frames for bus in told.buses.values())
    exchanges = sum(bus.transactions for bus in told.buses.values())
    most = max(told.buses, key=lambda name: told.buses[name].lost_replies, default="")
    where = f", most on {most}" if lost and len(told.buses) > 1 else ""
    return f"{lost} lost replies in {exchanges} exchanges, {bad} bad frames{where}"


def _worst(told: Told) -> str:
    """Return the hottest servo and the one with the lowest voltage."""
    hot = _extreme(told, lambda condition: condition.temperature, 1.0)
    low = _extreme(told, lambda condition: condition.voltage, -1.0)
    heat = f"hottest {hot[1]:.0f} degC {hot[0]}" if hot else "heat not heard yet"
    volts = f"lowest {low[1]:.1f} V {low[0]}" if low else "voltage not heard yet"
    return f"{heat}, {volts}"


def _extreme(
    told: Told, what: Callable[[ServoCondition], Measured | None], sign: float
) -> tuple[str, float] | None:
    """Return the joint of which something is largest (or with sign -1 smallest), and that."""
    known = {joint: measured.value for joint, each in told.conditions.items() if (measured := what(each))}
    if not known:
        return None
    joint = max(known, key=lambda name: sign * known[name])
    return joint, known[joint]
