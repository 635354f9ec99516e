"""The errors that robotwalk raises on purpose.

    RobotwalkError                 base; `exit_code` is what the command line exits with
    +-- UsageError (ValueError)    a value asked for makes no sense: a speed of NaN, an unknown gait
    +-- ConfigError (ValueError)   a robot, servo or gait file is wrong; says file, line and column
    +-- BusError (ConnectionError) a port does not open, or a servo does not answer as it must
    +-- ServoError (RuntimeError)  a servo answers, and refuses or does not do what it was told
    +-- SafetyStop (RuntimeError)  the robot was brought to a safe pose and will not go on by itself
        +-- Held                   somebody's `stop` holds it where it is, until `clear`

Each has a builtin second parent, so that a caller may catch it without importing this module. A reply lost
on the wire is none of these: it is ordinary, and travels in `JointState.valid` and `.age`.
"""


class RobotwalkError(Exception):
    """Base of every error raised on purpose."""

    exit_code = 1


class UsageError(RobotwalkError, ValueError):
    """What was asked for makes no sense."""

    exit_code = 2


class ConfigError(RobotwalkError, ValueError):
    """A configuration file is wrong. The text has one line per problem: `file:line:column: path: what`."""

    exit_code = 3


class BusError(RobotwalkError, ConnectionError):
    """A port or a servo is not there, or is not what the robot's configuration says."""

    exit_code = 4


class ServoError(RobotwalkError, RuntimeError):
    """A servo refuses what it was told, or has not done it."""


class SafetyStop(RobotwalkError, RuntimeError):
    """The robot was stopped for its own safety."""

    exit_code = 5


class Held(SafetyStop):
    """Somebody told the robot to stop: it holds where it is, until it is cleared."""
