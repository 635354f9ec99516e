"""What a robot's calibration changes."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from hal.hardware import HardwareConfig
from hal.hardware import problems as hardware_problems
from hal.joint_calibration import CalibrationConfig, apply, problems
from hal.register_map import ServoModel
from robotwalk import checks
from robotwalk.config.document import Document
from robotwalk.errors import ConfigError
from robotwalk.model import RobotModel


class Calibrated(NamedTuple):
    """A robot as it was calibrated."""

    config: CalibrationConfig
    hardware: HardwareConfig
    model: RobotModel


def calibrate(
    file: Document, document: Document, model: RobotModel, hardware: HardwareConfig, servos: Mapping[str, ServoModel]
) -> Calibrated:
    """Return a robot, whose own file is `document`, as the file of its calibration has it.

    Raises:
        ConfigError: the calibration is wrong, of another robot, or leaves too little of the joints' limits.
    """
    config = file.validate(CalibrationConfig)
    for where, what, got in problems(config, model.name, hardware):
        raise file.error(where, what, got)
    ranges = {name: row.range_deg for name, row in config.joints.items() if row.range_deg is not None}
    narrow = model.narrowed({name: (math.radians(low), math.radians(high)) for name, (low, high) in ranges.items()})
    limits = {joint.name: (math.degrees(joint.lower), math.degrees(joint.upper)) for joint in narrow.joints}
    for name, (low, high) in limits.items():
        if low >= high:
            raise file.error(("joints", name, "range_deg"), "leaves nothing of the joint's limits", list(ranges[name]))
    exact = apply(config, hardware)
    for where, what, got in hardware_problems(exact, limits, servos):
        raise file.error(where, what, got)
    try:
        checks.require_reachable(document, narrow)
    except ConfigError as error:
        raise file.error(("joints",), f"with these ranges the robot cannot stand or sit: {error}") from error
    return Calibrated(config, exact, narrow)
