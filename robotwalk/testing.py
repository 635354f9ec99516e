"""A robot of your own, simulated, for tests of yours: what it was told, what befell it, and what it really did.

    def test_it_walks_half_a_metre(fake_robot):
        with fake_robot("my_robot.yaml") as fake:
            fake.robot.stand()
            fake.robot.walk(vx=0.1, seconds=5)
            assert fake.distance_m == pytest.approx(0.5, rel=0.1)

The fixture comes with the package (`robotwalk.pytest_plugin`); this works without pytest, too.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from robotwalk import assembly
from robotwalk.journey import Journey, Summary
from robotwalk.loop import Tick
from robotwalk.robot import Robot
from robotwalk.supervisor import State
from robotwalk.types import Pose


class FakeRobot:
    """A simulated robot below whose wire servos are fakes, to the byte, and a body that MuJoCo moves.

    Attributes:
        robot: what a program has in its hands: stand, walk, sit, state. Leaving the `with` block seats it.
    """

    def __init__(
        self, robot: str | Path, *, rate_hz: int = 100, seed: int = 0, faults: assembly.Script = (),
        terrain: str | Path = "flat",
    ) -> None:
        """Seat a robot of that file, or bundled name, torque off; equal seeds give equal runs, faults included.

        Raises:
            UsageError: no such robot or terrain, or an impossible rate.
            ConfigError: a file is wrong; says where.
        """
        self._simulation = assembly.simulate(
            str(robot), rate_hz=rate_hz, seed=seed, faults=faults, terrain=str(terrain))
        self._seed = seed
        self._befallen = 0
        self.robot: Robot = self._simulation.robot
        self._journey: Journey | None = None
        self.robot.observers.append(self._watch)

    def __enter__(self) -> Self:
        self.robot.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.robot.__exit__(kind, error, trace)

    def befall(self, fault: str, **keys: Any) -> None:
        """Let a fault happen now: `befall("dead_servo", joint="lf_tibia")`; `robotwalk list faults` tells their keys.

        A key that Python reserves takes a line below it: `for_=0.3`.

        Raises:
            ConfigError: there is no such fault, or it does not fit the robot.
        """
        self._befallen += 1
        entry = {"at": self.seconds, "fault": fault, **{key.rstrip("_"): value for key, value in keys.items()}}
        assembly.befall(self._simulation, [entry], f"{self._seed} now {self._befallen}")

    @property
    def seconds(self) -> float:
        """The simulated time, s."""
        return self._simulation.clock.now() * 1e-9

    @property
    def base(self) -> Pose:
        """Where the body really is, m and rad, in the world."""
        return self._simulation.world.truth().base

    @property
    def joints(self) -> Mapping[str, float]:
        """The joints' true angles, rad."""
        return dict(zip(self.robot.model.joint_names, self._simulation.world.truth().joints, strict=True))

    @property
    def contacts(self) -> Mapping[str, bool]:
        """Which legs' feet really touch the ground."""
        legs = (leg.name for leg in self.robot.model.legs)
        return dict(zip(legs, self._simulation.world.truth().contacts, strict=True))

    @property
    def energy_j(self) -> float:
        """What all servos drew so far, J."""
        return self._simulation.world.truth().energy

    @property
    def torque(self) -> Mapping[str, bool]:
        """Which servos' torque is really on, by their joints."""
        world = self._simulation.world
        return {
            joint: bool(servo.table["torque_enable"]) for joint, servo in zip(world.joints, world.servos, strict=True)}

    def restart_measuring(self) -> None:
        """Begin anew to measure what the properties below tell."""
        self._journey = None

    @property
    def distance_m(self) -> float:
        """How far it really walked along its own x axis, m."""
        return self._walked.distance

    @property
    def displacement(self) -> Pose:
        """Where it came to, seen from where it began to walk, m and rad."""
        return self._walked.displacement

    @property
    def heading_change_deg(self) -> float:
        """How far it turned to the left, whole turns included, deg."""
        return math.degrees(self._walked.displacement.yaw)

    @property
    def max_tilt_deg(self) -> float:
        """The largest tilt of the body while it walked, deg."""
        return math.degrees(self._walked.max_tilt)

    @property
    def min_height_m(self) -> float:
        """The lowest that the base was above the ground under it while it walked, m."""
        return self._walked.min_height

    @property
    def fell(self) -> bool:
        """Whether it tilted beyond 45 deg or dropped to half its height while it walked."""
        return self._walked.fell

    @property
    def _walked(self) -> Summary:
        journey = self._journey or self._begin()
        return journey.summary()

    @property
    def _place(self) -> tuple[Pose, float]:
        """Where the body is, and how high the ground is under it."""
        truth = self._simulation.world.truth()
        return truth.base, truth.ground

    def _begin(self) -> Journey:
        return Journey(*self._place, direction=0.0, nominal_height=self.robot.model.heights.stand)

    def _watch(self, tick: Tick) -> None:
        if self._journey is not None:
            if tick.state in (State.WALK, State.STAND) and not self.robot.loop.low:
                self._journey.add(*self._place)
        elif tick.state is State.WALK:
            self._journey = self._begin()
