"""Everything that watches over the robot, joined: what they make of a tick, and what may be done then.

Each watcher tells of one kind of trouble. The supervisor alone decides on the state.
"""

from typing import NamedTuple

from robotwalk.agreement import Agreement
from robotwalk.governor import Governor
from robotwalk.model import RobotModel
from robotwalk.ports import ServoBus
from robotwalk.stale_joints import StaleJoints
from robotwalk.supervisor import State, Supervisor
from robotwalk.types import STILL, Command, JointState, Twist


class Verdict(NamedTuple):
    """What may be done in this tick."""

    state: State
    command: Command  # as far as it may be obeyed
    holding: tuple[int, ...] = ()  # joints whose goals are held
    news: tuple[tuple[str, str], ...] = ()  # what is worth an event: its kind, and what happened in words


class Safety:
    """Watches over one robot.

    Attributes:
        supervisor: keeps the state.
        efforts_tell: whether feet may be felt by what servos say of their effort: not with an empty battery, and not
            on the way down for a fault, when nothing is believed that need not be.
    """

    def __init__(self, model: RobotModel, bus: ServoBus, rate_hz: int) -> None:
        self.supervisor = Supervisor()
        self.efforts_tell = True
        self._bus = bus
        self._config = model.safety
        self._lowest = model.heights.lowest
        self._stale = StaleJoints(model.joint_names, model.safety.stale)
        self._governor = Governor(model.joint_names, model.safety.governor, bus.condition, 1.0 / rate_hz)
        self._alerted = Agreement()
        self._eased: tuple[Command, Command] | None = None  # a command, and what is left of it

    def step(self, joints: JointState, command: Command, *, seated: bool) -> Verdict:
        """Look at what was measured, once a tick.

        Args:
            joints: as measured.
            command: the driver's.
            seated: whether the body is down.
        """
        stale, governed = self._stale.step(joints.age), self._governor.step()
        state = self.supervisor.step(stale.trouble or self._alerts() or governed.trouble, seated=seated)
        self.efforts_tell = not governed.weak and state is not State.FAULT
        news = (("governor", governed.news),) if governed.news is not None else ()
        if governed.eased:
            command = self._ease(command)
        if stale.holding and state is not State.FAULT:
            return Verdict(state, command._replace(twist=STILL, heading=None), stale.holding, news)
        return Verdict(state, command, news=news)

    def _alerts(self) -> str | None:
        """Return what is wrong with servos, in words, once that is sure."""
        alerts = self._bus.alerts
        if not self._alerted.step(bool(alerts)):
            return None
        return "; ".join(f"the servo of {joint} {words}" for joint, words in alerts.items()) or None

    def _ease(self, command: Command) -> Command:
        """Return a command, slower and lower. It stays the same object while the command does."""
        if self._eased is None or self._eased[0] is not command:
            config, twist = self._config.governor, Twist(*(self._config.governor.pace * v for v in command.twist))
            height = self._lowest if config.lower else command.height
            self._eased = command, command._replace(twist=twist, height=height)
        return self._eased[1]
