"""What befalls the body, and a person who presses the stop button for that: the servos only feel it."""

import math
from collections.abc import Collection, Iterator, Mapping
from random import Random
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from robotwalk.types import Vec3
from sim_backend.faults.fault import End, Joint, LastingFault, Seconds

if TYPE_CHECKING:
    from sim_backend.simulation import SimulatedRobot


_STOP_LINE = "stop"  # what the line of the stop input is called


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


class PressStop(LastingFault):
    """A person presses the stop button, of a robot on a bus whose stop input is a board's."""

    fault: Literal["press_stop"]

    def begin(self, robot: "SimulatedRobot", chance: Random) -> End:
        """Let it happen to a robot now; return what ends it."""
        assert robot.stop_board is not None, "the script was checked"
        board = robot.stop_board
        board.pressed = True

        def end() -> None:
            board.pressed = False
        return end

    def complaints(
        self, wiring: Mapping[str, str], other_lines: Collection[str] = ()
    ) -> Iterator[tuple[str, str, Any]]:
        """Yield key, problem and value where it does not fit a robot."""
        if _STOP_LINE not in other_lines:
            yield "fault", (
                "nobody reads a button here: it needs a `stop_input` of a board in the robot's file, and `robotwalk "
                "sim`"), self.kind()
