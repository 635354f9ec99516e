"""robotwalk: walk a legged servo robot, or its simulation through the same bytes.

    import robotwalk
    with robotwalk.open("hexapod") as robot:
        robot.stand()
        robot.walk(vx=0.10, wz=0.2, seconds=5)
        print(robot.state.joints.position)
"""

from typing import TYPE_CHECKING

from robotwalk.errors import BusError, ConfigError, RobotwalkError, SafetyStop, UsageError

if TYPE_CHECKING:
    from robotwalk.robot import Robot

__all__ = ["BusError", "ConfigError", "RobotwalkError", "SafetyStop", "UsageError", "__version__", "open"]

__version__ = "0.1.0"


def open(robot: str, *, rate_hz: int = 100, seed: int = 0) -> "Robot":
    """Open a robot in simulation: a bundled name, or the path of a YAML file. Use it in a `with` block.

    Args:
        robot: name or path.
        rate_hz: ticks per second.
        seed: of the simulation; equal seeds give equal runs.

    Raises:
        UsageError: no such robot.
        ConfigError: a file is wrong; says where.
    """
    from robotwalk.assembly import simulate  # MuJoCo takes its time to load

    return simulate(robot, rate_hz=rate_hz, seed=seed).robot
