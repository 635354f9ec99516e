"""A bench over the servos of a simulated robot: shafts that turn, with legs on them."""

from collections.abc import Callable
from typing import NamedTuple

from hal.maintenance.bench import Bench
from hal.maintenance.servo import Servo
from robotwalk import assembly
from sim_backend.simulated_clock import SimulatedClock
from sim_backend.simulation import SimulatedRobot

from .rig import MODELS

ROBOT = {"xl430-w250": "hexapod", "sts3215": "quadruped"}
SHOULDER = {"xl430-w250": "lf_coxa", "sts3215": "lf_hip"}  # id 1


class Body(NamedTuple):
    robot: SimulatedRobot
    bench: Bench
    blueprint: assembly.Blueprint

    @property
    def clock(self) -> SimulatedClock:
        return self.robot.clock

    def servo(self, joint: str) -> Servo:
        return self.bench.servo(self.blueprint.hardware.joints[joint].id)

    def table(self, joint: str) -> dict[str, int]:
        return self.robot.servos[self.blueprint.model.joint_names.index(joint)].table

    def angle(self, joint: str) -> float:
        return self.robot.truth().joints[self.blueprint.model.joint_names.index(joint)]

    def weld(self, joint: str) -> None:
        """Hold a joint with more than any servo has."""
        self.robot.world.jam(self.blueprint.model.joint_names.index(joint))

    def each_step(self, action: Callable[[], None]) -> None:
        self.robot.observers.append(action)


def body(name: str) -> Body:
    """The robot of one servo model, seated and limp."""
    blueprint = assembly.load(ROBOT[name])
    robot = assembly.simulated_robot(blueprint, 100, 0)
    robot.clock.wait((), 100_000_000)
    return Body(robot, Bench(robot.ports["legs"], robot.clock, MODELS), blueprint)
