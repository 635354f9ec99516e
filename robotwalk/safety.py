"""Everything that watches over the robot, joined: what they make of a tick, and what may be done then.

Each watcher tells of one kind of trouble. The supervisor alone decides on the state.
"""

from collections.abc import Mapping
from typing import NamedTuple

from robotwalk.agreement import Agreement
from robotwalk.config.safety import SafetyConfig
from robotwalk.stale_joints import StaleJoints
from robotwalk.supervisor import State, Supervisor
from robotwalk.types import STILL, Command, JointState


class Verdict(NamedTuple):
    """What may be done in this tick."""

    state: State
    command: Command  # as far as it may be obeyed
    holding: tuple[int, ...] = ()  # joints whose goals are held


class Safety:
    """Watches over one robot.

    Attributes:
        supervisor: keeps the state.
    """

    def __init__(self, joints: tuple[str, ...], config: SafetyConfig | None = None) -> None:
        self.supervisor = Supervisor()
        self._stale = StaleJoints(joints, (config or SafetyConfig()).stale)
        self._alerted = Agreement()

    def step(self, joints: JointState, alerts: Mapping[str, str], command: Command, *, seated: bool) -> Verdict:
        """Look at what was measured, once a tick.

        Args:
            joints: as measured.
            alerts: what is wrong with servos, by their joints, in words that follow "the servo of lf_coxa".
            command: the driver's.
            seated: whether the body is down.
        """
        stale = self._stale.step(joints.age)
        trouble = stale.trouble
        if self._alerted.step(bool(alerts)) and trouble is None:
            trouble = "; ".join(f"the servo of {joint} {words}" for joint, words in alerts.items()) or None
        state = self.supervisor.step(trouble, seated=seated)
        if stale.holding and state is not State.FAULT:
            return Verdict(state, command._replace(twist=STILL, heading=None), stale.holding)
        return Verdict(state, command)
