"""What a walk is judged by: MuJoCo's truth, and the targets that the controller sets the feet."""

import math
from typing import NamedTuple

import numpy as np

from robotwalk import assembly
from robotwalk.loop import Tick
from robotwalk.support import Masses
from robotwalk.types import Vec3

from ..joint_watch import JointWatch, Worst

_FALLEN_TILT = math.radians(45.0)
_OFF = 0.05  # s without contact that end a stand, and s of contact that make one


class Slip(NamedTuple):
    """How far a foot's material went over the ground in one step."""

    distance: float  # m, the farthest from where it was at touchdown
    way: float  # m, all of it, to and fro
    time: float  # s since the sequence began, of the lift-off
    leg: str


class Stand:
    """One foot's contact with the ground, from touchdown to lift-off."""

    def __init__(self) -> None:
        self.x = self.y = 0.0  # m that its material has moved over the ground
        self.way = self.farthest = 0.0  # m
        self.on = self.off = 0.0  # s with contact, and since


class FootWatch:
    """Integrates the velocity of the foot's material at its lowest point over each stand.

    The foot is a ball that rolls: its contact point moves with rolling, which is no slip. Contact that is too short
    for a stand, as when a foot brushes the ground on its way, is added to the stand that follows.
    """

    def __init__(self, leg: str, radius: float) -> None:
        """Begin in the air; the foot is a ball of that radius, m."""
        self._leg = leg
        self._radius = radius
        self._stand = Stand()
        self._centre: np.ndarray | None = None
        self._turn = np.eye(3)
        self.slips: list[Slip] = []

    def add(self, centre: np.ndarray, turn: np.ndarray, touching: bool, dt: float, now: float) -> None:
        """Take the foot's place and attitude after a tick of `dt` s."""
        stand = self._stand
        if touching:
            if self._centre is not None:
                move = centre - self._centre
                spin = turn @ self._turn.T
                # The foot turns by a few degrees at most in a tick: its rotation vector is the skew part.
                dx = move[0] - self._radius * 0.5 * (spin[0, 2] - spin[2, 0])
                dy = move[1] + self._radius * 0.5 * (spin[2, 1] - spin[1, 2])
                stand.x += dx
                stand.y += dy
                stand.way += math.hypot(dx, dy)
                stand.farthest = max(stand.farthest, math.hypot(stand.x, stand.y))
            stand.on += dt
            stand.off = 0.0
            self._centre, self._turn = centre.copy(), turn.copy()
        else:
            self._centre = None
            stand.off += dt
            if stand.off >= _OFF and stand.on >= _OFF:
                self.end(now)

    def end(self, now: float) -> None:
        """Close the stand under way."""
        if self._stand.on >= _OFF:
            self.slips.append(Slip(self._stand.farthest, self._stand.way, now, self._leg))
            self._stand = Stand()


class Judge:
    """Watches one simulated robot."""

    def __init__(self, simulation: assembly.Simulation) -> None:
        model, world = simulation.blueprint.model, simulation.world.world
        self._simulation, self._model = simulation, model
        self._data = world.data
        self._joints = JointWatch(simulation)
        self._geoms = [world.model.geom(f"{leg.name}_foot").id for leg in model.legs]
        self._feet = [FootWatch(leg.name, model.foot_radius) for leg in model.legs]
        self._masses = Masses(model)
        self._targets: list[Vec3] | None = None
        self._dt = 1.0 / simulation.robot.loop.rate_hz
        self.began = 0.0
        self.driving = False
        self.speed = self.tilt = Worst()
        self.fell: Worst | None = None
        simulation.robot.observers.append(self._watch)

    @property
    def now(self) -> float:
        """Since the sequence began, s."""
        return self._simulation.clock.now() * 1e-9 - self.began

    @property
    def joint(self) -> Worst:
        """The farthest that any joint was beyond its limits, rad, at any time."""
        worst = self._joints.worst
        return worst._replace(time=worst.time - self.began)

    @property
    def slips(self) -> list[Slip]:
        """All steps of all feet."""
        return [slip for foot in self._feet for slip in foot.slips]

    def begin(self) -> None:
        """Judge the body and the feet from now on; joints are judged at all times."""
        self.driving, self.began = True, self._simulation.clock.now() * 1e-9

    def end(self) -> None:
        """Judge them no more."""
        for foot in self._feet:
            foot.end(self.now)
        self.driving = False

    def _watch(self, tick: Tick) -> None:
        self._targets_of(tick)
        if not self.driving or self._simulation.robot.loop.low:
            return
        truth = self._simulation.world.truth()
        tilt = math.acos(min(math.cos(truth.base.roll) * math.cos(truth.base.pitch), 1.0))
        if tilt > self.tilt.value:
            self.tilt = Worst(tilt, self.now)
        height = truth.base.z - truth.ground
        if self.fell is None and (tilt > _FALLEN_TILT or height < 0.5 * self._model.heights.stand):
            self.fell = Worst(tilt, self.now, f"tilt {math.degrees(tilt):.0f} deg, height {1e3 * height:.0f} mm")
        for foot, geom, touching in zip(self._feet, self._geoms, truth.contacts, strict=True):
            foot.add(self._data.geom_xpos[geom], self._data.geom_xmat[geom].reshape(3, 3), touching, self._dt, self.now)

    def _targets_of(self, tick: Tick) -> None:
        if not tick.wanted.legs:
            self._targets = None
            return
        _, targets = self._masses.centre_and_feet(tick.wanted.angles)
        if self._targets is not None:
            for leg, now, before in zip(self._model.legs, targets, self._targets, strict=True):
                speed = math.dist(now, before) / self._dt
                if speed > self.speed.value:
                    self.speed = Worst(speed, self.now, leg.name)
        self._targets = targets
