"""How a run of a robot ended: the exit code, and a sentence on stderr where it was not as planned."""

from collections.abc import Callable

from robotwalk.errors import SafetyStop
from robotwalk.robot import Robot


def run_to_end(robot: Robot, run: Callable[[], None]) -> tuple[int, str | None]:
    """Run a robot from chair to chair; return the exit code, and what is to be said of it.

    Raises:
        RobotwalkError: what went wrong was no safety stop.
    """
    try:
        run()
    except SafetyStop as error:
        saved = [event.text for event in robot.events if event.kind == "black_box"]
        return error.exit_code, "; ".join([str(error), *saved[-1:]])
    except KeyboardInterrupt:
        return 130, f"interrupted; the robot {ended_as(robot)}"
    except SystemExit as stop:
        return int(stop.code or 0), f"told to end; the robot {ended_as(robot)}"
    return 0, None


def ended_as(robot: Robot) -> str:
    """Return what became of a robot, in words."""
    if robot.frozen:
        return "is frozen in place, torque is on"
    return f"sat down; {robot.torque_doubt}" if robot.torque_doubt else "sat down, torque is off"
