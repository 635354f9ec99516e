"""Looks at every joint's true angle after every step of the physics.

A joint whose servo is limp goes where it is pressed to, which is its mechanical stop at the farthest; it is no fault of
the controller's while it comes back from there. While a servo is limp, the body may come down on another joint, too,
before that is known: one that gives way though its motor pushes it back with all it has is overpowered, and no fault
either. Every other joint is to stay within the limits of the robot's file.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from robotwalk import assembly

STOP = math.radians(5.0)  # the simulated robot's mechanical stops lie so far behind its limits
_GIVE = math.radians(0.25)  # of a stop that is struck
_FIRST = 7  # of MuJoCo's angles; before it are the body's place and attitude
_FORCES = 6  # before those of the joints are the body's
_FULL = 0.98  # of the supply's voltage: all that a motor has


class Worst(NamedTuple):
    """The largest of a series, and when and where it was."""

    value: float = -math.inf
    time: float = 0.0
    where: str = ""


class JointWatch:
    """Keeps the farthest that any joint of a simulated robot was beyond its limits.

    Attributes:
        worst: rad, of all joints; time in s of the simulation.
        beyond: deg and s of the worst, by the joints that held or moved by themselves, were not overpowered, and yet
            were beyond their limits.
        past_stops: deg beyond the limits and s, by joints that were pressed past their stops.
    """

    def __init__(self, simulation: assembly.Simulation) -> None:
        """Look from now on."""
        model = simulation.blueprint.model
        self.worst = Worst()
        self.beyond: dict[str, tuple[float, float]] = {}
        self.past_stops: dict[str, tuple[float, float]] = {}
        self._clock, self._data, self._servos = simulation.clock, simulation.world.world.data, simulation.world.servos
        self._names = model.joint_names
        self._lower = np.array([joint.lower for joint in model.joints])
        self._upper = np.array([joint.upper for joint in model.joints])
        self._joints = slice(_FIRST, _FIRST + len(model.joints))
        self._physics = simulation.world.physics
        self._excused: set[int] = set()  # went there limp, or overpowered
        simulation.world.observers.append(self._look)

    def _look(self) -> None:
        angles = self._data.qpos[self._joints]
        beyond = np.maximum(angles - self._upper, self._lower - angles)
        index = int(beyond.argmax())
        if beyond[index] > self.worst.value:
            self.worst = Worst(float(beyond[index]), self._clock.now() * 1e-9, self._names[index])
        if beyond[index] <= 0.0:
            self._excused.clear()
            return
        outside = set(np.flatnonzero(beyond > 0.0).tolist())
        limp = [not servo.table["torque_enable"] for servo in self._servos]
        self._excused = {
            slot for slot in outside
            if slot in self._excused or limp[slot] or (any(limp) and self._overpowered(slot, angles))}
        for slot in outside - self._excused:
            self._keep(self.beyond, slot, beyond[slot])
        for slot in np.flatnonzero(beyond > STOP + _GIVE).tolist():
            self._keep(self.past_stops, slot, beyond[slot])

    def _overpowered(self, slot: int, angles: npt.NDArray[np.float64]) -> bool:
        """Tell whether the motor of a joint beyond its limits pushes it back with all it has."""
        inwards = 1.0 if angles[slot] < self._lower[slot] else -1.0
        pushes = inwards * self._data.qfrc_applied[_FORCES + slot] > 0.0
        return bool(pushes and abs(self._physics.duty[slot]) >= _FULL)

    def _keep(self, worst: dict[str, tuple[float, float]], slot: int, angle: float) -> None:
        here = math.degrees(angle), self._clock.now() * 1e-9
        worst[self._names[slot]] = max(here, worst.get(self._names[slot], here))
