"""`robotwalk walk`: stand up, walk, stop, sit; and say what came of it."""

import sys
from pathlib import Path
from typing import Any

from robotwalk import assembly
from robotwalk.cli.ending import run_to_end
from robotwalk.cli.options import Faults, Flag, Json, Log, Rate, RobotName, Terrain, Where
from robotwalk.cli.outing import Outing, require_possible
from robotwalk.cli.output import abandon_stdout, complain, progress_line, say, write_json
from robotwalk.cli.way import Way
from robotwalk.errors import SafetyStop


def walk(
    robot: RobotName, /, *, way: Way = Way(), rate: Rate = assembly.RATE_HZ, seed: int = 0, terrain: Terrain = None,
    faults: Faults = None, where: Where = Where(), log: Log = None, black_box: Path | None = None,
    gif: Path | None = None, view: Flag = False, json: Json = False,
) -> int:
    """Stand up, walk, stop and sit: in simulation through the robot's real bytes, or with --port or --real on a bus.

    Parameters
    ----------
    seed
        Of the simulation. Equal seeds give equal runs.
    black_box
        Where the last minute goes if the robot stops for its safety, a folder. Default: that of the user's state,
        ~/.local/state/robotwalk.
    gif
        Leave an animated picture of the walk here.
    view
        Show the walk in the browser, on this machine only (needs the extra `robotwalk[view]`).
    """
    plan, ports = way.plan(), where.ports
    if gif is not None:
        assembly.check_film(gif)
    blueprint = where.blueprint(robot, gif=gif, view=view or None, faults=faults, terrain=terrain)
    require_possible(plan, blueprint)
    session: assembly.Session
    if where.on_bus:
        session = assembly.connect(blueprint, ports, real=where.real, rate_hz=rate, log=log)
    else:
        session = assembly.simulate(
            blueprint, rate_hz=rate, seed=seed, log=log, faults=faults or (), terrain=terrain or assembly.FLAT)
    assembly.add_black_box(session, black_box)
    outing = Outing(session, plan, film=gif is not None, view=view)
    code = _go(session, outing)
    code = _tell(outing.report(), json, code)
    if gif is not None:
        _draw(outing, gif)
    return code


def _go(session: assembly.Session, outing: Outing) -> int:
    """Walk; return the exit code. Whatever ends the walk, what was measured until then is kept."""
    with progress_line() as progress:
        code, sentence = run_to_end(session.robot, lambda: outing.run(progress))
    if sentence is not None:
        complain(sentence)
    return code


def _tell(fields: dict[str, Any], json: bool, code: int) -> int:
    """Say what came of it; return the exit code, now that all is known."""
    try:
        if json:
            write_json(fields)
        else:
            _show(fields)
        sys.stdout.flush()
    except OSError:
        abandon_stdout()
        code = code or 1
    if code == 0 and fields["fell"]:
        complain("the robot fell")
        code = SafetyStop.exit_code
    goal = fields["goal"]
    if code == 0 and goal is not None and not goal["reached"]:
        complain(f"the goal was not reached within {fields['duration_s']:.1f} s, {goal['miss_m']:.2f} m are missing")
        code = 1
    return code


def _draw(outing: Outing, path: Path) -> None:
    try:
        with progress_line() as progress:
            outing.save_film(path, lambda share: progress(f"drawing {path}", share))
    except KeyboardInterrupt:
        complain(f"interrupted; {path} was not drawn")
        raise


def _show(fields: dict[str, Any]) -> None:
    """Say it to a person."""
    for event in fields["events"]:
        if event["kind"] not in ("state", "interrupt"):
            say(f"{event['t']:6.2f} s  {event['text']}")
    moved, bus = fields["displacement"], fields["bus"]
    lost = sum(line["lost_replies"] for line in bus.values())
    trips = sum(line["watchdog_trips"] for line in bus.values())
    say(f"{fields['robot']}, {fields['gait']}: {fields['distance_m']:.3f} m in {fields['duration_s']:.1f} s "
        f"({fields['speed_mps']:.3f} m/s)")
    say(f"  ended at x {moved['x']:+.3f} m, y {moved['y']:+.3f} m, turned {moved['yaw_deg']:+.1f} deg")
    if fields["goal"] is not None:
        goal = fields["goal"]
        say(f"  {1e2 * goal['miss_m']:.1f} cm from the goal at x {goal['x']:+.3f} m, y {goal['y']:+.3f} m"
            f"{'' if goal['reached'] else ', not reached'}")
    tilt = f"largest tilt {fields['max_tilt_deg']:.1f} deg, " if fields["max_tilt_deg"] is not None else ""
    say(f"  {tilt}lowest {1e3 * fields['min_height_m']:.0f} mm, "
        f"{'FELL' if fields['fell'] else 'no fall'}")
    say(f"  {fields['ticks']} ticks at {fields['rate_hz']} Hz, {lost} lost replies, "
        f"{f'{trips} servos had stopped for want of any instruction, ' if trips else ''}"
        f"{fields['realtime_factor']:.1f} times real time")
