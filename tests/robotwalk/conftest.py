"""The bundled hexapod, its gaits, and a robot whose joints are wherever the controller wants them."""

import cmath
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import pytest

from robotwalk.chain import foot_position
from robotwalk.config import library
from robotwalk.config.schema import RobotConfig
from robotwalk.controller import Controller, Wanted
from robotwalk.estimator import Estimate
from robotwalk.gait import Gait
from robotwalk.gait_rules import fitted, read_gait
from robotwalk.kinematics import resting_angles
from robotwalk.model import RobotModel
from robotwalk.supervisor import State
from robotwalk.types import Command, Pose, Vec3

RATE_HZ = 100


def load_model(name: str) -> RobotModel:
    return RobotModel.from_config(library.open_document("robots", name).validate(RobotConfig))


def load_gait(file: str, model: RobotModel) -> Gait:
    """Read a bundled gait that is for this robot's feet."""
    config = fitted(read_gait(library.open_document("gaits", file)), model.legs)
    assert config is not None
    return Gait(config, model)


class Frame(NamedTuple):
    """One tick of a robot with perfect joints."""

    wanted: Wanted
    feet_in_base: tuple[Vec3, ...]  # by generic forward kinematics
    feet: tuple[Vec3, ...]  # in odom, the body taken as level
    x: float
    y: float
    yaw: float
    height: float  # at which the planted feet would touch the ground


class PerfectRobot:
    """Runs a controller; its course is added up here, from the twists alone."""

    dt = 1.0 / RATE_HZ

    def __init__(self, model: RobotModel, gaits: Mapping[str, Gait], default_gait: str = "tripod") -> None:
        self.model = model
        self.controller = Controller(model, gaits, default_gait)
        self.controller.start(resting_angles(model, 0.5 * model.body_box.z))
        self.state = State.STAND
        self.command = Command()
        self._place, self._yaw, self._height = 0j, 0.0, 0.5 * model.body_box.z

    def tick(self) -> Frame:
        """Turn the cycle once, as `robotwalk.loop` does."""
        pose = Pose(self._place.real, self._place.imag, self._height, 0.0, 0.0, self._yaw)
        wanted = self.controller.step(self.state, self.command, Estimate(pose, 6), self.dt)
        vx, vy, wz = wanted.twist
        turn = wz * self.dt
        chord = (cmath.exp(1j * turn) - 1.0) / (1j * turn) if abs(turn) > 1e-6 else cmath.exp(0.5j * turn)
        self._place += complex(vx, vy) * self.dt * chord * cmath.exp(1j * self._yaw)
        self._yaw += turn
        feet = tuple(foot_position(leg, wanted.angles[leg.span]) for leg in self.model.legs)
        planted = [foot.z for foot, stands in zip(feet, wanted.planted, strict=True) if stands]
        self._height = self.model.foot_radius - sum(planted) / len(planted)
        on_ground = [self._place + complex(foot.x, foot.y) * cmath.exp(1j * self._yaw) for foot in feet]
        placed = tuple(Vec3(p.real, p.imag, f.z + self._height) for p, f in zip(on_ground, feet, strict=True))
        return Frame(wanted, feet, placed, self._place.real, self._place.imag, self._yaw, self._height)

    def run(self, seconds: float) -> Iterator[Frame]:
        """Yield every frame of some time."""
        for _ in range(round(seconds * RATE_HZ)):
            yield self.tick()

    def until(self, done: Callable[[Wanted], bool], longest: float = 20.0) -> list[Frame]:
        """Return the frames until something is so."""
        frames = []
        for frame in self.run(longest):
            frames.append(frame)
            if done(frame.wanted):
                return frames
        raise AssertionError(f"not within {longest} s")

    def stand_up(self) -> list[Frame]:
        """Rise."""
        self.state = State.STAND
        return self.until(lambda wanted: wanted.standing)

    def walk(self, command: Command, seconds: float) -> list[Frame]:
        """Walk by a command, standing up first if need be."""
        if self.state is not State.WALK:
            self.stand_up()
        self.state, self.command = State.WALK, command
        return list(self.run(seconds))


@pytest.fixture(scope="session")
def hexapod() -> RobotModel:
    return load_model("hexapod")


@pytest.fixture(scope="session")
def gaits(hexapod: RobotModel) -> dict[str, Gait]:
    return {name: load_gait(name, hexapod) for name in ("tripod", "ripple", "wave")}


@pytest.fixture
def robot(hexapod: RobotModel, gaits: dict[str, Gait]) -> PerfectRobot:
    """A seated robot that walks in tripod."""
    return PerfectRobot(hexapod, gaits)
