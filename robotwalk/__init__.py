"""robotwalk: walk a legged servo robot, or its simulation through the same bytes.

    import robotwalk
    with robotwalk.open("hexapod") as robot:
        robot.stand()
        robot.walk(vx=0.10, wz=0.2, seconds=5)
        print(robot.state.joints.position)
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from robotwalk.errors import BusError, ConfigError, RobotwalkError, SafetyStop, UsageError

if TYPE_CHECKING:
    from robotwalk.assembly import Script
    from robotwalk.robot import Robot

__all__ = ["BusError", "ConfigError", "RobotwalkError", "SafetyStop", "UsageError", "__version__", "open"]

__version__ = "0.1.0"


def open(
    robot: str, *, real: bool = False, ports: Mapping[str, str] | None = None, rate_hz: int = 100, seed: int = 0,
    faults: "Script" = (), terrain: str = "flat",
) -> "Robot":
    """Open a robot, by default in simulation. Use it in a `with` block.

    When it stops for its safety, the last minute is saved (`robot.black_box`; None there switches that off).

    Args:
        robot: a bundled name, or the path of a YAML file.
        real: open the serial ports that its file names; it will move.
        ports: URLs by the names of buses, in place of the file's; physical ones need `real` too.
        rate_hz: ticks per second.
        seed: of the simulation; equal seeds give equal runs.
        faults: what goes wrong in the simulation: the path of a script, or a list such as
            `[{"at": 0, "fault": "drop_reply", "rate": 0.05}]`; `robotwalk list faults` explains them.
        terrain: the ground of the simulation: a name from `robotwalk list terrains`, or the path of a YAML file.

    Raises:
        UsageError: no such robot or bus, a physical port without `real`, or faults or a terrain without a simulation.
        ConfigError: a file is wrong; says where.
        BusError: a port does not open.
    """
    from robotwalk import assembly  # its imports take their time

    if (real or ports) and faults:
        raise UsageError("faults befall a simulation; there is none behind a port")
    if (real or ports) and terrain != "flat":
        raise UsageError("a terrain is that of a simulation; there is none behind a port")
    session: assembly.Session
    if real or ports:
        session = assembly.connect(robot, ports or {}, real=real, rate_hz=rate_hz)
    else:
        session = assembly.simulate(robot, rate_hz=rate_hz, seed=seed, faults=faults, terrain=terrain)
    assembly.add_black_box(session)
    return session.robot
