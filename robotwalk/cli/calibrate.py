"""`robotwalk calibrate`: zero, direction and range of each joint, found with a hand on the leg."""

import math
import select
import sys
from typing import Annotated

from cyclopts import Parameter

from robotwalk.assembly import calibrating, workbench
from robotwalk.cli.output import complain, say
from robotwalk.cli.ports import by_bus
from robotwalk.cli.servo.turn import POSITIVE, joint_of
from robotwalk.errors import BusError, ServoError, UsageError
from robotwalk.interrupts import Interrupts

_NOW_OR_NEVER = 3  # tries at a step that did not work out


def calibrate(
    robot: str, /, *joints: str, port: list[str] | None = None, torque: float = 25.0,
    skip_range: Annotated[bool, Parameter(negative="", help="Do not look for the ends of each joint's range.")] = False,
    real: Annotated[bool, Parameter(negative="", help="Allow this on a physical robot.")] = False,
) -> int:
    """Find out how each servo sits in its joint, and write it to a file of its own, joint by joint.

    Torque is off; you move the legs. In the end each joint moves back to where you put it first, slowly and weakly,
    if you let it. Answer with Enter; `s` leaves the joint as it was, `q` ends. What is done is saved.

    Parameters
    ----------
    robot
        A bundled name, or the path of a YAML file; the calibration is kept beside that, or in your configuration.
    joints
        Default: all.
    port
        BUS=URL: where a bus is, in place of what the robot's file says.
    torque
        Percent of the servo's largest for moving back, 5 to 50.
    """
    if not (math.isfinite(torque) and 5.0 <= torque <= 50.0):
        raise UsageError(f"--torque should be 5 to 50, not {torque:g}")
    seats = calibrating.seats(robot, joints, by_bus(port or []))
    file = calibrating.CalibrationFile(robot, seats[0].blueprint.model.name)
    say(f"{len(seats)} joint{'s' * (len(seats) != 1)}; the calibration goes to {file.path}")
    done, interrupts = 0, Interrupts()
    interrupts.install()
    try:
        for seat in seats:
            done += _calibrate(seat, file, torque / 100.0, skip_range, real, interrupts)
    except EOFError:
        say("")
    finally:
        interrupts.restore()
        if file.saved:
            say(f"what was before is in {file.saved}; to undo: mv {file.saved} {file.path}")
        elif done:
            say(f"there was no calibration before; to undo: rm {file.path}")
    say(f"{done} of {len(seats)} joints calibrated")
    return 0 if done == len(seats) else 1


def _calibrate(
    seat: workbench.Seat, file: calibrating.CalibrationFile, share: float, skip_range: bool, real: bool,
    interrupts: Interrupts,
) -> bool:
    """Take one joint through all steps. Raises EOFError when nobody answers any more, or wants to end."""
    wired, at_deg = seat.wired, calibrating.reference_deg(seat)
    axis = joint_of(seat).axis
    with workbench.bench(
            seat.url, baud=seat.baud, protocol=wired.model.protocol, real=real, writes=True,
            servos=seat.blueprint.servos) as bench:
        servo = seat.servo(bench)
        hand = calibrating.Hand(servo, bench.clock)
        say(f"\n{wired.joint}, {servo}: by the file {math.degrees(wired.lower):.0f} to "
            f"{math.degrees(wired.upper):.0f} deg")
        for _ in range(_NOW_OR_NEVER):
            try:
                if not _ask(f"put it to {at_deg:g} deg, hold it still, and press Enter", hand, interrupts):
                    return False
                at = hand.still()
                if not _ask(f"move it 20 deg or so the positive way ({POSITIVE[axis]}), then Enter", hand, interrupts):
                    return False
                way = calibrating.direction(servo, at, hand.look())
                reach = None
                if not skip_range:
                    hand.forget_range()
                    if not _ask("move it to one end of its range, then to the other, then Enter", hand, interrupts):
                        return False
                    reach = min(hand.lowest, at), max(hand.highest, at)
                found = calibrating.found(servo, at, at_deg, way, reach)
            except ServoError as error:
                complain(f"{error}")
                continue
            break
        else:
            return False
        ends = "" if found.range_deg is None else f", range {found.range_deg[0]:.1f} to {found.range_deg[1]:.1f} deg"
        say(f"  direction {found.direction:+d}, zero {found.zero_deg:.2f} deg{ends}")
        verified = _prove(servo, bench, hand, at, share, interrupts)
        file.put(seat, found, verified=verified)
    return True


def _prove(
    servo: workbench.Servo, bench: workbench.Bench, hand: calibrating.Hand, at: int, share: float,
    interrupts: Interrupts,
) -> bool:
    """Have the joint move back by itself, if its owner lets it."""
    if not _ask("hands off: Enter lets it move back to where it began, slowly and weakly; s does without", hand,
                interrupts):
        return False
    try:
        off = calibrating.prove(servo, bench.clock, at, share, interrupts.check)
    except (BusError, ServoError) as error:
        complain(f"it could not be moved: {error}")
        return False
    if calibrating.is_proven(off):
        say(f"  it came back to within {math.degrees(abs(off)):.1f} deg: verified")
        return True
    complain(f"it stopped {math.degrees(off):+.1f} deg from where it began: saved, but not verified")
    return False


def _ask(what: str, hand: calibrating.Hand, interrupts: Interrupts) -> bool:
    """Ask for something to be done, and follow the joint until it is. Return whether it was not declined."""
    say(f"  {what}")
    sys.stdout.flush()

    def answered() -> bool:
        interrupts.check()
        return bool(select.select([sys.stdin], [], [], 0)[0])

    hand.follow(answered)
    line = sys.stdin.readline()
    if not line or line.strip().lower() == "q":
        raise EOFError
    return line.strip().lower() != "s"
