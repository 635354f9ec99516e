"""What really happens to a simulated robot, as JSON lines for whoever judges it."""

import json
from pathlib import Path

from robotwalk.errors import UsageError
from robotwalk.model import RobotModel
from sim_backend.real_time import RealTime
from sim_backend.simulation import SimulatedRobot
from sim_backend.witness import Witness

_RATE_HZ = 50
_DIGITS = 6  # um, urad, us


class TruthStream:
    """Writes a line at once and then every 20 ms of simulated time, flushed.

    `t` is the monotonic time of a simulated one: bytes that arrived before it have had their effect. A stall too
    long to be caught up shows as a step of `t` and in `dropped_s`.
    """

    def __init__(self, path: Path, model: RobotModel, robot: SimulatedRobot, time: RealTime) -> None:
        """Open the file and follow the robot from now on.

        Raises:
            UsageError: the file cannot be written.
        """
        try:
            self._file = path.open("w", encoding="utf-8")
        except OSError as error:
            raise UsageError(f"cannot write {path}: {error.strerror}") from error
        self._joints = model.joint_names
        self._legs = [leg.name for leg in model.legs]
        self._robot, self._time = robot, time
        self._witness = Witness(robot.world)
        self._stride = max(1, robot.world.steps_per_second // _RATE_HZ)
        self._steps = 0
        robot.observers.append(self._observe)
        self._write()

    def close(self) -> None:
        """Write no more."""
        self._robot.observers.remove(self._observe)
        self._file.close()

    def _observe(self) -> None:
        self._witness.watch()
        self._steps += 1
        if self._steps % self._stride == 0:
            self._write()

    def _write(self) -> None:
        self._file.write(json.dumps(self._line()) + "\n")
        self._file.flush()

    def _line(self) -> dict[str, object]:
        truth, now = self._robot.truth(), self._robot.clock.now()
        return {
            "t": round(1e-9 * self._time.wall(now), _DIGITS),
            "sim_t": round(1e-9 * now, _DIGITS),
            "base": {"pos": _rounded(truth.base[:3]), "quat_wxyz": _rounded(truth.attitude)},
            "joints": dict(zip(self._joints, _rounded(truth.joints), strict=True)),
            "contacts": dict(zip(self._legs, truth.contacts, strict=True)),
            "distance_m": round(self._witness.distance, _DIGITS),
            "fell": self._witness.fell,
            "dropped_s": round(1e-9 * self._time.dropped, _DIGITS),
        }


def _rounded(values: tuple[float, ...]) -> list[float]:
    return [round(value, _DIGITS) for value in values]
