"""`robotwalk walk`: stand up, walk, stop, sit; and say what came of it."""

import math
import sys
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from robotwalk import assembly
from robotwalk.cli.ending import run_to_end
from robotwalk.cli.outing import Outing, Plan, require_possible
from robotwalk.cli.output import abandon_stdout, complain, progress_line, say, write_json
from robotwalk.cli.ports import place
from robotwalk.config.route import Route, read_route
from robotwalk.errors import SafetyStop, UsageError
from robotwalk.track import Track

Flag = Parameter(negative="")
_DURATION = 10.0  # s
_LONGER = 2.0  # times what a way takes at the commanded speed, and _DURATION more, before it is given up


def walk(
    robot: str,
    /,
    *,
    gait: str | None = None,
    speed: float = 0.1,
    direction: float = 0.0,
    heading: float | None = None,
    turn: float | None = None,
    goto: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    path: Path | None = None,
    height: float | None = None,
    period: float | None = None,
    duration: float | None = None,
    rate: int = assembly.RATE_HZ,
    seed: int = 0,
    terrain: str | None = None,
    faults: Path | None = None,
    port: list[str] | None = None,
    real: Annotated[bool, Flag] = False,
    hang: Annotated[bool, Flag] = False,
    log: Path | None = None,
    black_box: Path | None = None,
    gif: Path | None = None,
    view: Annotated[bool, Flag] = False,
    json: Annotated[bool, Flag] = False,
) -> int:
    """Stand up, walk, stop and sit: in simulation through the robot's real bytes, or with --port or --real on a bus.

    Parameters
    ----------
    robot
        A bundled name (see `robotwalk list robots`), or the path of a YAML file.
    gait
        A name from `robotwalk list gaits`. Default: the first that it has of tripod, tetrapod, trot and wave.
    speed
        Metres per second.
    direction
        Of travel relative to the body, degrees: 0 ahead, 90 to the left.
    heading
        Where the body shall face, degrees to the left of its start. It turns there and holds it.
    turn
        A turning rate instead, degrees per second to the left.
    goto
        X,Y: walk straight to there, metres ahead and to the left of the start, and end. The heading is kept, or is
        that of --heading. Where it is the robot knows from its legs alone.
    path
        Walk along the waypoints of this YAML file instead, and end at the last.
    height
        Of the body above the ground, metres.
    period
        Of the gait, seconds, as far as strides and servos allow. Default: as slow as the speed allows.
    duration
        Seconds of walking; standing up and sitting down come on top. Default: 10; with --goto or --path, where it is
        the most that the way may take, 10 more than twice what it takes at that speed.
    rate
        Ticks per second.
    seed
        Of the simulation. Equal seeds give equal runs.
    terrain
        The ground of the simulation: a name from `robotwalk list terrains`, or the path of a YAML file. Default: flat.
    faults
        What goes wrong in the simulation, and when: a YAML file (see `robotwalk list faults`).
    port
        BUS=URL: walk what is on this line, in real time. Once for each bus; imu=URL is the IMU's, feet=URL
        the foot switches', stop=URL that of a stop button with a port of its own.
    real
        Open the ports that the robot's file names, or physical ones given by --port. The robot will move.
    hang
        The robot is on a stand, its feet off the ground: a third of the torque, and nothing is felt for.
    log
        Record every tick to this MCAP file, for PlotJuggler or Foxglove.
    black_box
        Where the last minute goes if the robot stops for its safety, a folder. Default: that of the user's state,
        ~/.local/state/robotwalk.
    gif
        Leave an animated picture of the walk here.
    view
        Show the walk in the browser, on this machine only (needs the extra `robotwalk[view]`).
    json
        One JSON object on stdout.
    """
    route = _route(goto, path)
    _require_one_way(route, heading, turn, direction)
    _require_finite(speed=speed, direction=direction, heading=heading, turn=turn, height=height, period=period,
        duration=duration)
    where = place(port, real=real, gif=gif, view=view or None, faults=faults, terrain=terrain)
    if gif is not None:
        assembly.check_film(gif)
    blueprint = assembly.load(robot, calibrated=where.on_bus)
    if hang:
        blueprint = blueprint.hang()
    plan = Plan(
        speed=abs(speed), direction=math.radians(direction + (180.0 if speed < 0.0 else 0.0)),
        heading=None if heading is None else math.radians(heading),
        turn=math.radians(turn or 0.0), height=height, duration=_DURATION if duration is None else duration, gait=gait,
        period=period)
    if route is not None:
        plan = _by_route(plan, route, speed, duration)
    require_possible(plan, blueprint)
    session: assembly.Session
    if where.on_bus:
        session = assembly.connect(blueprint, where.ports, real=real, rate_hz=rate, log=log)
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


def _route(goto: str | None, path: Path | None) -> Route | None:
    """Return where to go, if the command line tells."""
    if goto is not None and path is not None:
        raise UsageError("--goto and --path exclude each other")
    if path is not None:
        return read_route(path)
    if goto is None:
        return None
    try:
        x, y = (float(number) for number in goto.split(","))
    except ValueError as error:
        raise UsageError(f"--goto should be X,Y in metres, such as 1.5,-0.3, not {goto!r}") from error
    if not (math.isfinite(x) and math.isfinite(y)) or x == y == 0.0:
        raise UsageError(f"--goto should be finite and somewhere else than the start, not {goto!r}")
    return Route(((x, y),))


def _require_one_way(route: Route | None, heading: float | None, turn: float | None, direction: float) -> None:
    """Raise UsageError if two options tell where to go, or to face."""
    if turn is not None and heading is not None:
        raise UsageError("--turn and --heading exclude each other: one is a rate, the other an angle to hold")
    if route is not None and (turn is not None or direction != 0.0):
        raise UsageError("--goto and --path tell where to go: leave out --direction and --turn")
    if route is not None and route.ahead and heading is not None:
        raise UsageError("--heading and the `facing: ahead` of --path exclude each other")


def _by_route(plan: Plan, route: Route, speed: float, duration: float | None) -> Plan:
    """Return a plan that goes along a route, in the time that it may take."""
    if speed <= 0.0:
        raise UsageError(f"--speed should be above 0 with --goto and --path, not {speed}")
    x, y = route.waypoints[0]
    if duration is None:
        duration = _LONGER * Track(route.points).length / speed + _DURATION
    return plan._replace(route=route, direction=math.atan2(y, x), duration=duration)


def _require_finite(**options: float | None) -> None:
    for name, value in options.items():
        if value is not None and not math.isfinite(value):
            raise UsageError(f"--{name} should be a finite number, not {value}")


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
