"""What more than one command is told."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from robotwalk import assembly
from robotwalk.cli.ports import by_bus
from robotwalk.errors import UsageError

Flag = Annotated[bool, Parameter(negative="")]
Names = Annotated[list[str] | None, Parameter(negative="")]
Json = Annotated[bool, Parameter(name="--json", negative="", help="One JSON object on stdout.")]
RobotName = Annotated[str, Parameter(help="A bundled name (see `robotwalk list robots`), or the path of a YAML file.")]
Rate = Annotated[int, Parameter(help="Ticks per second.")]
Terrain = Annotated[str | None, Parameter(help=(
    "The ground of the simulation: a name from `robotwalk list terrains`, or the path of a YAML file. Default: flat."))]
Faults = Annotated[Path | None, Parameter(help=(
    "What goes wrong in the simulation, and when: a YAML file (see `robotwalk list faults`)."))]
Log = Annotated[Path | None, Parameter(help="Record every tick to this MCAP file, for PlotJuggler or Foxglove.")]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Where:
    """Where a robot is that a command moves: on a bus if one of these says so, else in simulation.

    Attributes:
        port: BUS=URL: the robot is on this line; it moves in real time. Once for each bus; imu=URL is the IMU's,
            feet=URL the foot switches', stop=URL that of a stop button with a port of its own.
        real: Open the ports that the robot's file names, or physical ones given by --port. The robot will move.
        hang: The robot is on a stand, its feet off the ground: a third of the torque, and nothing is felt for.
    """

    port: list[str] | None = None
    real: Flag = False
    hang: Flag = False

    @property
    def on_bus(self) -> bool:
        """Whether it is not simulated."""
        return bool(self.port) or self.real

    @property
    def ports(self) -> dict[str, str]:
        """The URLs by bus. Raises UsageError if one is something else than BUS=URL."""
        return by_bus(self.port or [])

    def blueprint(self, robot: str, **simulated: object) -> assembly.Blueprint:
        """Read a robot as it is there; `simulated` are options that a simulation alone has, None where not given.

        Raises:
            UsageError: options exclude each other, or no robot is bundled under that name.
            ConfigError: a file is wrong.
        """
        for option, value in simulated.items():
            if self.on_bus and value is not None:
                raise UsageError(f"--{option} is for a simulation; there is none behind a port")
        blueprint = assembly.load(robot, calibrated=self.on_bus)
        return blueprint.hang() if self.hang else blueprint
