"""Everything that watches over the robot, joined: what they make of a tick, and what may be done then.

Each watcher tells of one kind of trouble. The supervisor alone decides on the state.
"""

from typing import NamedTuple

from robotwalk.agreement import Agreement
from robotwalk.governor import Governor
from robotwalk.model import RobotModel
from robotwalk.ports import ServoBus
from robotwalk.recovery import Recovery
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
        self._joints = model.joint_names
        self._limbs = [leg.name for leg in model.legs for _ in leg.joints]
        self._config = model.safety
        self._lowest = model.heights.lowest
        self._stale = StaleJoints(model.safety.stale)
        self._governor = Governor(model.joint_names, model.safety.governor, bus.condition, 1.0 / rate_hz)
        self._recovery = Recovery(model.joint_names, bus, model.safety.recovery)
        self._silent: dict[int, str] = {}  # joints that do not answer, and since when, in words
        self._alerted = Agreement()
        self._unclear = Agreement(rate_hz)  # for a second it was not to be learnt what is wrong
        self._eased: tuple[Command, Command] | None = None  # a command, and what is left of it

    def step(self, joints: JointState, command: Command, *, seated: bool, standing: bool) -> Verdict:
        """Look at what was measured, once a tick.

        Args:
            joints: as measured.
            command: the driver's.
            seated: whether the body is down.
            standing: whether it is up, all feet at rest.
        """
        supervisor, governed = self.supervisor, self._governor.step()
        stale = self._stale.step(joints.age)
        patients, trouble = self._find(stale.silent, joints)
        if supervisor.state in (State.FAULT, State.STOP):
            patients.clear()
        treated = self._recovery.step(patients, seated=seated and supervisor.state is State.MEND)
        if treated.lost:
            trouble = trouble or next(iter(treated.lost.values()))
        state = supervisor.step(
            trouble or governed.trouble, seated=seated, standing=standing, helping=treated.helping)
        if state in (State.FAULT, State.STOP):
            self._recovery.dismiss()
        self.efforts_tell = not governed.weak and state not in (State.FAULT, State.MEND)
        news = treated.news
        if governed.news is not None:
            news += (("governor", governed.news),)
        if governed.eased:
            command = self._ease(command)
        if stale.holding and state is not State.FAULT:
            return Verdict(state, command._replace(twist=STILL, heading=None), stale.holding, news)
        return Verdict(state, command, news=news)

    def _find(self, silent: tuple[int, ...], joints: JointState) -> tuple[dict[int, str], str | None]:
        """Return whose servos may be helped, and what cannot be: why, in words."""
        self._silent = {
            slot: self._silent.get(slot) or f"joint {self._joints[slot]} has not answered for {joints.age[slot]:.2f} s"
            for slot in sorted(silent, key=lambda slot: -joints.age[slot])}
        found = dict(self._silent)
        if len({self._limbs[slot] for slot in silent}) > 1:
            return {}, next(iter(found.values()))  # a wire is cut, or the power is off
        alerts = self._bus.alerts
        if not self._alerted.step(bool(alerts)):
            return found, None
        beyond, unknown = [], False
        for joint, what in alerts.items():
            slot, words = self._joints.index(joint), f"the servo of {joint} {what}"
            if slot in self._recovery.patients:
                continue
            curable = self._bus.curable(slot)
            if curable:
                found.setdefault(slot, words)
            elif curable is None and not self._unclear.holds:
                unknown = True
            else:
                beyond.append(words)
        self._unclear.step(unknown)
        return found, "; ".join(beyond) or None

    def _ease(self, command: Command) -> Command:
        """Return a command, slower and lower. It stays the same object while the command does."""
        if self._eased is None or self._eased[0] is not command:
            config, twist = self._config.governor, Twist(*(self._config.governor.pace * v for v in command.twist))
            height = self._lowest if config.lower else command.height
            self._eased = command, command._replace(twist=twist, height=height)
        return self._eased[1]
