"""What `robotwalk calibrate` has found out about a robot's joints: the schema of a `.calibration.yaml`.

It overrides the zeros and directions of the robot's file, and narrows its limits; it never widens them.
"""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from hal.hardware import HardwareConfig, Problem
from hal.schema import Row


class JointCalibration(Row):
    """How one servo sits in its joint."""

    servo: str  # the model, for which alone this holds
    direction: Literal[1, -1]
    zero_deg: Annotated[float, Field(ge=-360.0, le=360.0)]  # the joint's angle where the servo reads its centre
    range_deg: tuple[float, float] | None = None  # the joint's angles at its two ends; null: not looked for
    verified: bool = False  # whether it has moved back to its zero by itself
    time: str  # ISO 8601


class CalibrationConfig(Row):
    """The file."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    robot: str
    joints: dict[str, JointCalibration]


def apply(config: CalibrationConfig, hardware: HardwareConfig) -> HardwareConfig:
    """Return a robot's hardware with its calibration in place of what its file says."""
    joints = {
        name: wiring.model_copy(update={"direction": row.direction, "zero_deg": row.zero_deg})
        if (row := config.joints.get(name)) else wiring
        for name, wiring in hardware.joints.items()}
    return hardware.model_copy(update={"joints": joints})


def problems(config: CalibrationConfig, robot: str, hardware: HardwareConfig) -> Iterator[Problem]:
    """Find what is not of this robot, or makes no sense."""
    if config.robot != robot:
        yield Problem(("robot",), f"this is no calibration of {robot}", config.robot)
    for name, row in config.joints.items():
        path = ("joints", name)
        wiring = hardware.joints.get(name)
        if wiring is None:
            yield Problem(path, f"{robot} has no such joint; it has {', '.join(hardware.joints)}", None)
        elif wiring.servo != row.servo:
            yield Problem(
                (*path, "servo"), f"{name} has an {wiring.servo} by the robot's file: calibrate it anew", row.servo)
        if row.range_deg is not None and row.range_deg[0] >= row.range_deg[1]:
            yield Problem((*path, "range_deg"), "expected the lower end before the upper", list(row.range_deg))
