"""What `robotwalk calibrate` works on: a robot's joints on their lines, and the file that it writes."""

import io
import math
import shutil
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from hal.joint_calibration import CalibrationConfig, JointCalibration
from hal.maintenance.calibrate import Found as Found
from hal.maintenance.calibrate import Hand as Hand
from hal.maintenance.calibrate import direction as direction
from hal.maintenance.calibrate import found as found
from hal.maintenance.calibrate import is_proven as is_proven
from hal.maintenance.calibrate import prove as prove
from robotwalk.assembly.workbench import Seat, seat
from robotwalk.config import library
from robotwalk.config.document import Document
from robotwalk.errors import UsageError

_HEAD = """\
# How the servos of {robot} sit in its joints, as `robotwalk calibrate` has found out. It counts instead of the
# zeros and directions in the robot's file, and narrows its limits. Comments are kept; the file before this one is
# beside it.
schema: 1
robot: {robot}
joints: {{}}
"""


def seats(robot: str, joints: tuple[str, ...], ports: Mapping[str, str]) -> list[Seat]:
    """Return these joints of a robot, or all, each on its line; not yet calibrated.

    Raises:
        UsageError: no such robot, joint or bus.
        ConfigError: a file is wrong.
    """
    from robotwalk.assembly.blueprint import load

    blueprint = load(robot)
    for bus in ports:
        if bus not in blueprint.hardware.buses:
            raise UsageError(
                f"{blueprint.model.name} has no bus {bus!r}; it has {', '.join(blueprint.hardware.buses)}")
    names = joints or blueprint.model.joint_names
    found_seats = []
    for name in names:
        row = blueprint.hardware.joints.get(name)
        found_seats.append(seat(robot, name, ports.get(row.bus) if row else None, calibrated=False))
    return found_seats


def reference_deg(seat: Seat) -> float:
    """Return the angle to which a joint is put by hand: 0 if it can be there, else a right angle, else its middle."""
    low, high = math.degrees(seat.wired.lower), math.degrees(seat.wired.upper)
    return next((angle for angle in (0.0, 90.0, -90.0) if low <= angle <= high), round(0.5 * (low + high)))


class CalibrationFile:
    """A robot's calibration, joint by joint. What people wrote into it stays as it is."""

    def __init__(self, robot: str, name: str) -> None:
        """Open it, or begin one, for the robot of that name in its file.

        Raises:
            ConfigError: there is one that is wrong; says where.
        """
        self.path = library.calibration_path(robot)
        self.saved: Path | None = None  # the file as it was before
        self._yaml = YAML()
        self._yaml.width = 4096
        text = _HEAD.format(robot=name)
        if self.path.exists():
            text = self.path.read_text()
            Document.parse(text, str(self.path)).validate(CalibrationConfig)
        self._content: Any = self._yaml.load(text)

    def put(self, seat: Seat, found: Found, *, verified: bool) -> None:
        """Write what was found about a joint, at once; the file as it was before is kept beside it.

        Raises:
            UsageError: the file cannot be written.
        """
        row = JointCalibration(
            servo=seat.wired.model.name, direction=found.direction, zero_deg=found.zero_deg, range_deg=found.range_deg,
            verified=verified, time=datetime.now().astimezone().isoformat(timespec="seconds"))
        fields = {key: list(value) if isinstance(value, tuple) else value for key, value in row.model_dump().items()}
        known = self._content["joints"].get(seat.wired.joint)
        if known is None:
            self._content["joints"][seat.wired.joint] = fields
        else:
            known.update(fields)
        text = io.StringIO()
        self._yaml.dump(self._content, text)
        try:
            self._write(text.getvalue())
        except OSError as error:
            raise UsageError(f"cannot write {self.path}: {error.strerror}") from error

    def _write(self, text: str) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        if self.path.exists() and self.saved is None:
            stamp = datetime.now().strftime("%Y-%m-%dT%H-%M-%S")
            self.saved = self.path.with_name(f"{self.path.name}.{stamp}")
            shutil.copy2(self.path, self.saved)
        fresh = self.path.with_name(f".{self.path.name}.new")
        fresh.write_text(text)
        fresh.replace(self.path)  # all of it or nothing
