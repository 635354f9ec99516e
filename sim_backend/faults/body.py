"""Faults of the body, which the servos only feel."""

import math
from random import Random
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from robotwalk.types import Vec3
from sim_backend.faults.fault import End, Joint, LastingFault, Seconds

if TYPE_CHECKING:
    from sim_backend.simulation import SimulatedRobot


class StuckJoint(LastingFault):
    """A joint is jammed where it is, whatever its motor does."""

    fault: Literal["stuck_joint"]
    joint: Joint

    def begin(self, robot: "SimulatedRobot", chance: Random) -> End:
        """Let it happen to a robot now; return what ends it."""
        return robot.world.jam(robot.joints.index(self.joint))


class Push(LastingFault):
    """A level force on the middle of the body."""

    fault: Literal["push"]
    force_n: Annotated[float, Field(gt=0, description="N")]
    direction_deg: Annotated[float, Field(description="deg, where to: 0 ahead as the body faces then, 90 left")] = 0.0
    duration: Annotated[Seconds, Field(alias="for", description="s that it lasts")] = 0.1

    def begin(self, robot: "SimulatedRobot", chance: Random) -> End:
        """Let it happen to a robot now; return what ends it."""
        course = robot.truth().base.yaw + math.radians(self.direction_deg)
        force = Vec3(self.force_n * math.cos(course), self.force_n * math.sin(course), 0.0)
        robot.world.push(force)
        return lambda: robot.world.push(Vec3(-force.x, -force.y, 0.0))
