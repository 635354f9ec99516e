"""Everything that watches over the robot, joined: what they make of a tick, and what may be done then.

Each watcher tells of one kind of trouble. The supervisor alone decides on the state.
"""

from collections.abc import Collection, Sequence
from typing import NamedTuple

from robotwalk.agreement import Agreement
from robotwalk.controller import Wanted
from robotwalk.falls import FallWatch
from robotwalk.governor import Governed, Governor
from robotwalk.model import RobotModel
from robotwalk.overruns import Late, Overruns
from robotwalk.ports import ServoBus
from robotwalk.recovery import Recovery
from robotwalk.stale_joints import NOBODY, StaleJoints, Staleness
from robotwalk.stuck_joints import StuckJoints
from robotwalk.supervisor import State, Supervisor
from robotwalk.types import STILL, Command, DriveResponse, ImuState, JointState, Twist


class Verdict(NamedTuple):
    """What may be done in this tick."""

    state: State
    command: Command  # as far as it may be obeyed
    holding: tuple[int, ...] = ()  # joints whose goals are held
    news: tuple[tuple[str, str], ...] = ()  # what is worth an event: its kind, and what happened in words
    dead: frozenset[int] = frozenset()  # joints without whose legs the robot is to go on from now on
    fell: bool = False  # just now: every joint is to go on from where it is, softly
    waits: bool = False  # the gait is to wait for joints


class Safety:
    """Watches over one robot.

    Attributes:
        supervisor: keeps the state.
        driver: what is done about one who is silent; the loop does it.
        efforts_tell: whether feet may be felt by what servos say of their effort: not with an empty battery, and not
            on the way down for a fault, when nothing is believed that need not be.
    """

    def __init__(
        self, model: RobotModel, bus: ServoBus, rate_hz: int, drives: Sequence[DriveResponse]
    ) -> None:
        self.supervisor = Supervisor()
        self.efforts_tell = True
        self._bus = bus
        self._joints = model.joint_names
        self._limbs = [leg.name for leg in model.legs for _ in leg.joints]
        self._config = model.safety
        self.driver = model.safety.driver
        self._lowest = model.heights.lowest
        self._stale = StaleJoints(model.safety.stale)
        self._governor = Governor(model.joint_names, model.safety.governor, bus.condition)
        self._falls = FallWatch(model, drives, model.safety.fall, 1.0 / rate_hz)
        self._overruns = Overruns(model.safety.overruns, rate_hz)
        self._recovery = Recovery(model.joint_names, bus, model.safety.recovery, rate_hz)
        self._stuck = StuckJoints(drives, 1.0 / rate_hz, load=model.leads.load)
        self._silent: dict[int, str] = {}  # joints that do not answer, and since when, in words
        self._alerted = Agreement()
        self._unclear = Agreement(rate_hz)  # for a second it was not to be learnt what is wrong
        self._out: frozenset[int] = frozenset()  # all joints of legs that take no part any more
        self._dead: frozenset[int] = frozenset()  # those among them whose servos are
        self._eased: tuple[Command, Command] | None = None  # a command, and what is left of it

    def step(
        self, joints: JointState, goals: Sequence[float], command: Command, wanted: Wanted,
        imu: ImuState | None = None, missed: int = 0, behind: Collection[int] = (),
    ) -> Verdict:
        """Look at what was measured, once a tick.

        Args:
            joints: as measured.
            goals: that were sent just before.
            command: the driver's.
            wanted: by the controller, for these measurements.
            imu: as heard, if there is one.
            missed: ticks that were left out before this one.
            behind: joints that are on their way back to where they are wanted.
        """
        late = self._overruns.step(missed)
        supervisor, governed, seated = self.supervisor, self._governor.step(), wanted.seated
        up = supervisor.state in (State.STAND, State.WALK)
        fell = self._falls.step(imu, joints, wanted, up=up)
        if fell is not None and supervisor.state in (State.STOP, State.READY, State.HELD, State.FAULT):
            fell = None
        stale = self._stale.step(joints.age if not self._out else [
            0.0 if slot in self._out else age for slot, age in enumerate(joints.age)])
        patients, trouble = self._find(stale.silent, joints)
        if supervisor.state in (State.FAULT, State.STOP, State.HELD):
            patients.clear()
        stuck = self._find_stuck(patients, joints, goals, wanted)
        treated = self._recovery.step(patients, seated=seated and supervisor.state is State.MEND, hopeless=stuck)
        dead: frozenset[int] = frozenset()
        if treated.lost:
            dead = self._spare(treated.lost.keys()) if supervisor.state is State.MEND and seated else frozenset()
            if not dead:
                trouble = trouble or next(iter(treated.lost.values()))
        state = supervisor.step(
            fell or trouble or governed.trouble or late.trouble, seated=seated, standing=wanted.standing,
            helping=treated.helping, passes=fell is not None)
        if state in (State.FAULT, State.STOP, State.HELD):
            self._recovery.dismiss()
        self.efforts_tell = not governed.weak and state not in (State.FAULT, State.MEND)
        news = treated.news + self._told(governed, late, dead)
        if governed.eased:
            command = self._ease(command)
        elif late.slow:
            command = command._replace(twist=_slower(command.twist, self._config.overruns.pace))
        waits = (bool(behind) or stale is not NOBODY) and self._waits(stale, behind, state)
        if stale.holding and state is not State.FAULT:
            return Verdict(state, command._replace(twist=STILL, heading=None), stale.holding, news, dead, waits=waits)
        return Verdict(state, command, news=news, dead=dead, fell=fell is not None, waits=waits)

    def _waits(self, stale: Staleness, behind: Collection[int], state: State) -> bool:
        """Tell whether the gait has to wait: for legs that hear nothing, or are far from where they are wanted.

        It does not wait for a single one, whose servo may have let go; nor, on its way down for a fault, for any that
        may never be heard again.
        """
        if state is not State.FAULT and (stale.deaf or self._several(stale.holding)):
            return True
        recovery = self._recovery
        return self._several([slot for slot in behind if slot not in recovery.patients and slot not in recovery.lost])

    def _several(self, slots: Collection[int]) -> bool:
        """Tell whether joints of more than one leg that takes part are among these."""
        return len({self._limbs[slot] for slot in slots if slot not in self._out}) > 1

    def _find(self, silent: tuple[int, ...], joints: JointState) -> tuple[dict[int, str], str | None]:
        """Return whose servos may be helped, and what cannot be: why, in words."""
        if silent or self._silent:
            self._silent = {
                slot: self._silent.get(slot)
                or f"joint {self._joints[slot]} has not answered for {joints.age[slot]:.2f} s"
                for slot in sorted(silent, key=lambda slot: -joints.age[slot])}
        found = dict(self._silent)
        if len(silent) > 1 and self._several(silent):
            return {}, next(iter(found.values()))  # a wire is cut, or the power is off
        alerts = self._bus.alerts
        if self._out:
            alerts = {joint: what for joint, what in alerts.items() if self._joints.index(joint) not in self._out}
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

    def _find_stuck(
        self, patients: dict[int, str], joints: JointState, goals: Sequence[float], wanted: Wanted
    ) -> tuple[int, ...]:
        """Return the joints that do not move as they are sent, and add them to the `patients`."""
        if self.supervisor.state is not State.WALK:
            self._stuck.reset()
            return ()
        stuck = tuple(slot for slot in self._stuck.step(goals, wanted.torques, joints) if slot not in self._out)
        for slot in stuck:
            patients.setdefault(slot, f"joint {self._joints[slot]} is stuck: it does not move as it is sent")
        return stuck

    def _told(self, governed: Governed, late: Late, dead: frozenset[int]) -> tuple[tuple[str, str], ...]:
        """Return what is worth an event, of all but the joints' treatment."""
        news: tuple[tuple[str, str], ...] = ()
        if governed.news is not None:
            news += (("governor", governed.news),)
        if dead:
            limbs = " and ".join(dict.fromkeys(self._limbs[slot] for slot in sorted(self._out)))
            news += (("legs", f"going on without {limbs}"),)
        if late.news is not None:
            news += (("late", late.news),)
        return news

    def _spare(self, lost: Collection[int]) -> frozenset[int]:
        """Take the legs of lost joints out, if enough are left; return all dead joints so far, or none."""
        limbs = {self._limbs[slot] for slot in (*lost, *self._out)}
        enough = self._config.recovery.walk_on_with_legs
        if enough is None or len(set(self._limbs)) - len(limbs) < enough:
            return frozenset()
        self._out = frozenset(slot for slot, limb in enumerate(self._limbs) if limb in limbs)
        self._dead = self._dead.union(lost)
        self._recovery.let_go()
        self._falls.spare(self._out)
        return self._dead

    def _ease(self, command: Command) -> Command:
        """Return a command, slower and lower. It stays the same object while the command does."""
        if self._eased is None or self._eased[0] is not command:
            config, twist = self._config.governor, _slower(command.twist, self._config.governor.pace)
            height = self._lowest if config.lower else command.height
            self._eased = command, command._replace(twist=twist, height=height)
        return self._eased[1]


def _slower(twist: Twist, pace: float) -> Twist:
    return Twist(pace * twist.vx, pace * twist.vy, pace * twist.wz)
