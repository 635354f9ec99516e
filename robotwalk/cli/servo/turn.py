"""`robotwalk servo wiggle`: whether a servo moves, and which way."""

import math
from typing import Annotated, Any

from cyclopts import Parameter

from robotwalk.assembly import workbench
from robotwalk.cli.options import Json
from robotwalk.cli.output import complain, say, write_json
from robotwalk.cli.servo.options import BAUD, Port, Protocol, Real, Servos
from robotwalk.errors import UsageError
from robotwalk.interrupts import Interrupts
from robotwalk.model import Axis, Joint

POSITIVE = {  # right-handed, in the leg's frame
    Axis.ROLL: "a leg that hangs down swings to its left",
    Axis.PITCH: "a leg that points outwards tips down, one that hangs down swings back",
    Axis.YAW: "a leg that points outwards turns counter-clockwise, seen from above",
}


def wiggle(
    who: str, /, *, port: Port | None = None, robot: str | None = None, by: float = 4.0, torque: float = 25.0,
    baud: Annotated[int | None, Parameter(help="The line's baud rate; default: the robot's, or 1000000.")] = None,
    protocol: Protocol = None, real: Real = False, servos: Servos = None, json: Json = False,
) -> int:
    """Turn a servo a few degrees there and back, slowly and weakly. Then torque and all else are as before.

    What the joint holds up may sink meanwhile. Ctrl-C ends it, and lets go of what was limp.

    Parameters
    ----------
    who
        An id; or with --robot the name of a joint, which keeps to its limits and begins in its positive direction.
    robot
        A bundled name, or the path of a YAML file: whose joint. --port then defaults to what it says.
    by
        Degrees to either side, 1 to 15.
    torque
        Percent of the servo's largest, 5 to 100.
    """
    _require("--by", by, 1.0, 15.0)
    _require("--torque", torque, 5.0, 100.0)
    seat = None
    spoken: str | None = protocol
    if robot is not None:
        seat = workbench.seat(robot, who, port)
        url, rate, spoken = seat.url, baud or seat.baud, protocol or seat.wired.model.protocol
    elif port is None or not who.isdecimal():
        raise UsageError("say which servo: an id and --port, or a joint's name and --robot")
    else:
        url, rate = port, baud or BAUD
    interrupts = Interrupts()
    models = seat.blueprint.servos if seat else workbench.load_servos(servos)
    with workbench.bench(url, baud=rate, protocol=spoken, real=real, writes=True, servos=models) as bench:
        servo = seat.servo(bench) if seat else bench.servo(int(who))
        interrupts.install()
        try:
            done = workbench.wiggle(
                servo, bench.clock, *_way(servo, seat, by), torque / 100.0, interrupts.check)
        finally:
            interrupts.restore()
        on = bool(servo.read("torque_enable"))
    moved = all(turn.done for turn in done.turns)
    fields = _fields(servo, seat, done)
    if json:
        write_json(fields | {"moved": moved, "torque": on})
    else:
        _tell(servo, seat, fields, on)
    if not moved:
        complain(
            f"{fields['joint'] or servo} does not move as it was told: something holds it, its gears are broken, or "
            f"{torque:g} % of torque is too little")
    return 0 if moved else 1


def _require(name: str, value: float, low: float, high: float) -> None:
    if not (math.isfinite(value) and low <= value <= high):
        raise UsageError(f"{name} should be {low:g} to {high:g}, not {value:g}")


def _way(servo: workbench.Servo, seat: workbench.Seat | None, by: float) -> tuple[int, tuple[float, float]]:
    """Return the first way to go, and the bounds, in counts."""
    encoder = servo.model.encoder
    way = round(math.radians(by) / encoder.radians_per_tick)
    if seat is None:
        low, high = (encoder.centre + math.radians(end) / encoder.radians_per_tick for end in encoder.range_deg)
        return way, (low, high)
    calibration = seat.wired.calibration
    low, high = sorted(calibration.ticks(angle) for angle in (seat.wired.lower, seat.wired.upper))
    return calibration.direction * way, (low, high)


def _fields(servo: workbench.Servo, seat: workbench.Seat | None, done: workbench.Wiggled) -> dict[str, Any]:
    """Return what came of it in the joint's degrees, or else the servo's."""
    sign = seat.wired.calibration.direction if seat else 1
    scale = sign * math.degrees(servo.model.encoder.radians_per_tick)
    turns = [{"asked_deg": round(scale * turn.asked, 2), "moved_deg": round(scale * turn.moved, 2)}
             for turn in done.turns]
    return {
        "joint": seat.wired.joint if seat else None, "id": servo.id, "model": servo.model.name, "turns": turns,
        "rest_deg": round(scale * done.rest, 2)}


def _tell(servo: workbench.Servo, seat: workbench.Seat | None, fields: dict[str, Any], on: bool) -> None:
    who = f"{seat.wired.joint}, {servo}" if seat else str(servo)
    turns = ", then ".join(f"{turn['moved_deg']:+.1f} of {turn['asked_deg']:+.1f} deg" for turn in fields["turns"])
    say(f"{who}: turned {turns}; it rests {fields['rest_deg']:+.1f} deg from where it was, torque "
        f"{'on, as before' if on else 'off'}")
    if seat is None:
        say("plus is the way in which its counts grow")
        return
    joint = joint_of(seat)
    say(f"plus, by the robot's file: {POSITIVE[joint.axis]} ({joint.axis.name.lower()}). "
        "If it went the other way, change the joint's direction")


def joint_of(seat: workbench.Seat) -> Joint:
    """Return the joint of a seat."""
    return next(joint for joint in seat.blueprint.model.joints if joint.name == seat.wired.joint)
