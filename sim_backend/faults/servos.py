"""Faults of servos: their power, their protections, their firmware."""

import math
from random import Random
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from sim_backend.faults.fault import End, Fault, Joint, LastingFault, Seconds, ServoFault

if TYPE_CHECKING:
    from sim_backend.simulation import SimulatedRobot


class BrownOut(ServoFault):
    """Servos lose power and start afresh: limp and deaf meanwhile, then with the registers of a start, torque off.

    After the outage a servo stays silent for the time that its model needs to start (`reboot_s`).
    """

    fault: Literal["brown_out"]
    duration: Annotated[Seconds, Field(alias="for", description="s without power")] = 0.05

    def begin(self, robot: "SimulatedRobot", chance: Random) -> None:
        """Let it happen to a robot now."""
        for index in self.indices(robot):
            robot.servos[index].lose_power(robot.clock.now(), self.duration)


class DeadServo(LastingFault):
    """A servo is silent and limp. If that passes, it starts as after a brown-out."""

    fault: Literal["dead_servo"]
    joint: Joint

    def begin(self, robot: "SimulatedRobot", chance: Random) -> End:
        """Let it happen to a robot now; return what ends it."""
        servo = robot.servos[robot.joints.index(self.joint)]
        servo.lose_power(robot.clock.now(), math.inf)
        return lambda: servo.lose_power(robot.clock.now(), 0.0)


class Overload(LastingFault):
    """A servo takes its motor for overloaded, until its protection trips in its own time and way."""

    fault: Literal["overload"]
    joint: Joint

    def begin(self, robot: "SimulatedRobot", chance: Random) -> End:
        """Let it happen to a robot now; return what ends it."""
        index = robot.joints.index(self.joint)
        robot.physics.strained.add(index)
        return lambda: robot.physics.strained.discard(index)


class Overheat(LastingFault):
    """A servo measures a temperature that its motor does not have; its protection acts on it."""

    fault: Literal["overheat"]
    joint: Joint
    temperature_c: Annotated[float, Field(ge=-40, le=200, description="degC measured")] = 95.0

    def begin(self, robot: "SimulatedRobot", chance: Random) -> End:
        """Let it happen to a robot now; return what ends it."""
        index, temperatures = robot.joints.index(self.joint), robot.physics.temperature_c
        before = float(temperatures[index])
        temperatures[index] = self.temperature_c

        def end() -> None:
            temperatures[index] = before
        return end


class VoltageDrop(ServoFault):
    """Servos get less voltage, or more: weaker motors, and a protection that may act."""

    fault: Literal["voltage_drop"]
    supply_v: Annotated[float, Field(ge=0, le=60, description="V at the servos")]

    def begin(self, robot: "SimulatedRobot", chance: Random) -> End:
        """Let it happen to a robot now; return what ends it."""
        indices, supply = self.indices(robot), robot.physics.supply_v
        before = supply[indices]
        supply[indices] = self.supply_v

        def end() -> None:
            supply[indices] = before
        return end


class WrongFirmware(Fault):
    """A servo has another version of its firmware, and with it lacks or has fast sync read."""

    fault: Literal["wrong_firmware"]
    joint: Joint
    version: Annotated[int, Field(ge=0, le=255, description="what the servo reports; of two parts, the first")]

    def begin(self, robot: "SimulatedRobot", chance: Random) -> None:
        """Let it happen to a robot now."""
        robot.servos[robot.joints.index(self.joint)].run_firmware(self.version)
