"""Whether a command makes sense for a robot."""

import math
from collections.abc import Mapping, Sequence

from robotwalk.errors import UsageError
from robotwalk.model import RobotModel
from robotwalk.types import Command

LONGEST_WALK = 86400.0  # s, a day
LONGEST_PERIOD = 60.0  # s, of a gait


def check_duration(seconds: float) -> None:
    """Raise UsageError if no walk can last so long."""
    if not 0.0 <= seconds <= LONGEST_WALK:
        raise UsageError(f"a walk lasts 0 to {LONGEST_WALK:.0f} s, not {seconds}")


def check_command(command: Command, model: RobotModel, gaits: Sequence[str], refused: Mapping[str, str]) -> None:
    """Raise UsageError if a command makes no sense for a robot of these `gaits`; others are `refused`, and why."""
    numbers = [*command.twist, *command.posture, command.heading or 0.0, command.height or 0.0, command.period or 1.0]
    if not all(math.isfinite(number) for number in numbers):
        raise UsageError(f"a command needs finite numbers, not {command}")
    if command.gait is not None and command.gait in refused:
        raise UsageError(f"{model.name} cannot {command.gait}: {refused[command.gait]}")
    if command.gait is not None and command.gait not in gaits:
        raise UsageError(f"{model.name} has no gait {command.gait!r}; it has {', '.join(gaits)}")
    if command.period is not None and not 0.0 < command.period <= LONGEST_PERIOD:
        raise UsageError(f"a gait's period is over 0 and up to {LONGEST_PERIOD:.0f} s, not {command.period}")
    heights = model.heights
    if command.height is not None and not heights.lowest <= command.height <= heights.highest:
        raise UsageError(
            f"height {command.height} m is outside {heights.lowest} to {heights.highest} m of {model.name}")
