"""All the robot's wires as one `robotwalk.ports.ServoBus`: in flight at once, from one thread."""

import contextlib
import math
from collections.abc import Mapping, Sequence

from hal.arming import Arming
from hal.bus_plan import SHARE_OF_TICK
from hal.disarming import disarm, disarm_watchdogs, settle
from hal.line_cycle import PATIENCE
from hal.revival import Revival
from hal.servo_line import ServoLine
from robotwalk.ports import Clock
from robotwalk.types import BusStatistics, JointState, ServoCondition

_NS = 1_000_000_000
_PATIENCE = 40_000_000  # ns past the time that the bytes take, while arming
_LONGEST_BITE = 3600.0  # s
_ADOPTION = 3  # tries at hearing everybody; the robot may be falling


class SerialServoBus:
    """Exchanges goals for states with every servo, once a tick.

    A reply that is missing, late, short or garbled costs its own joints this sample and nothing more: they
    keep their last values, marked not valid, and their age grows.
    """

    def __init__(self, joints: Sequence[str], lines: Sequence[ServoLine], clock: Clock) -> None:
        self._joints = tuple(joints)
        self._lines = tuple(lines)
        self._places = {servo.slot: (line, servo) for line in lines for servo in line.servos}
        self.notes: tuple[str, ...] = ()
        self._clock = clock
        count = len(self._joints)
        self._position, self._velocity, self._effort = [math.nan] * count, [0.0] * count, [0.0] * count
        self._heard = [0] * count  # ns
        self._valid = [False] * count
        self._max_age = dict.fromkeys((line.name for line in lines), 0.0)
        self._paused = True  # watchdogs off, no conditions read
        self._torque = 1.0  # share of the largest
        self._softer: float | None = None  # share that is to be the largest from the next exchange on
        self._exchanged = 0  # ns, when the last exchange began
        self._bite = round(_NS * min([line.watchdogs.shortest for line in lines] + [_LONGEST_BITE]))  # ns

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints' names, in the robot's order."""
        return self._joints

    @property
    def lines(self) -> tuple[ServoLine, ...]:
        """The wires."""
        return self._lines

    @property
    def alerts(self) -> Mapping[str, str]:
        """What is wrong with servos, by their joints, in words that follow "the servo of lf_coxa"."""
        found: dict[str, str] = {}
        for line in self._lines:
            cycle = line.cycle
            limp = cycle.watch.rota.limp if cycle.watch.on else frozenset()
            if not (cycle.alerts or limp):
                continue
            for servo in line.servos:
                if servo.slot in cycle.alerts:
                    faults = ", ".join(cycle.watch.rota.faults(servo)) or "overload, heat or a wrong voltage"
                    found[servo.joint] = f"reports {faults}"
                elif servo.slot in limp:
                    found[servo.joint] = "has let go: its torque is off, and nobody switched it off"
        return found

    @property
    def reseeded(self) -> tuple[int, ...]:
        """The slots of joints that the last exchange has sent to where they are: they had stopped there."""
        return tuple([slot for line in self._lines for slot in line.reseeded])

    def curable(self, slot: int) -> bool | None:
        """Tell whether what is wrong with a joint's servo may be mended by `revive`; None: that is not known yet."""
        line, servo = self._places[slot]
        watch, arming = line.cycle.watch, servo.model.arming
        if slot not in line.cycle.alerts:
            return slot in watch.rota.limp
        if servo.model.cyclic.telemetry.error is None:
            return bool(arming.torque_clears)
        faults = watch.rota.faults(servo)
        return set(faults) <= {*arming.restart_clears, *arming.torque_clears} if faults else None

    def revive(self, slot: int) -> Revival:
        """Begin to bring a joint's servo back that has let go: over the next ticks, beside the exchange."""
        line, servo = self._places[slot]
        revival = line.cycle.watch.errand = Revival(line, servo, self._torque, self._clock)
        return revival

    def soften(self, share: float) -> None:
        """Bound the output of all servos to a share of the largest, with the next exchange, until armed anew."""
        self._softer = share * self._torque

    def conditions(self) -> Mapping[str, ServoCondition]:
        """Return what each servo last told of itself, by its joint."""
        return {
            joint: condition for line in self._lines for joint, condition in line.cycle.watch.rota.conditions().items()}

    def condition(self, slot: int) -> ServoCondition:
        """Return what the servo of one joint last told of itself: the same objects, until it tells anew."""
        line, servo = self._places[slot]
        return line.cycle.watch.rota.condition(servo)

    def statistics(self) -> Mapping[str, BusStatistics]:
        """Return what each bus carried, by its name."""
        return {
            line.name: BusStatistics(
                line.wire.tx_bytes, line.wire.rx_bytes, line.cycle.transactions, line.cycle.lost_replies,
                line.bad_frames, self._max_age[line.name], line.watchdogs.trips)
            for line in self._lines
        }

    def arm(self, period: int, torque: float = 1.0) -> JointState:
        """Find every servo, let it hold where it is, switch torque on, limb by limb and gently; arm the watchdogs.

        A servo whose torque is on already may be what the robot stands on: it keeps it, and its goal becomes where
        it is.

        Args:
            period: of the cycle that shall follow, ns.
            torque: share of the largest output that the servos may use.

        Raises:
            BusError: a servo is missing, is another model, reports an error, or stands outside its joint's limits;
                or the bus is too slow for the period. Torque is then as it was before: off, unless the robot was
                found standing on it.
        """
        self._fall_silent()
        self._torque = torque
        self._heard = [self._clock.now() - _NS] * len(self._joints)
        arming = Arming(self._lines, self._clock, self._exchange_patiently)
        state = arming.find(period)
        stands = bool(arming.standing())
        try:
            state = arming.hold(state, torque)
            for line in self._lines:
                line.cycle.watch.rota.forget()  # torque was off, or it may have been
            self._resume()
            for line in self._lines:
                if line.watchdogs.due:
                    line.wire.send(line.watchdogs.armed(b""))
            settle(self._clock)
            self._max_age = dict.fromkeys(self._max_age, 0.0)  # until here nobody was in a hurry
        except BaseException:
            if not stands:
                self.disarm()
            raise
        finally:
            self.notes = tuple(arming.notes)
        return state

    def adopt(self, believed: Sequence[float]) -> JointState:
        """Have every servo hold where it is: who talked with them has died, maybe in the middle of a frame.

        Watchdogs that have tripped refuse goals, so they are disarmed; armed again once the goals are where the joints
        are, for whoever adopts them may die, too.

        Args:
            believed: rad, where those are that do not answer.
        """
        self.pause()
        settle(self._clock)
        for _ in range(_ADOPTION):
            state = self._exchange_patiently(None)
            if all(state.valid):
                break
        known = zip(state.position, self._heard, believed, strict=True)
        here = tuple([position if heard else other for position, heard, other in known])
        for _ in range(2):  # nobody acknowledges goals
            self._resume()
            self._transact(here, self._clock.now(), _NS, _PATIENCE)
        return state._replace(position=here)

    def exchange(self, goals: Sequence[float], period: int) -> JointState:
        """Write the goals (rad) to all joints and read all of them back, within `period` ns.

        The first one after a pause arms the servos' watchdogs; so does one so late that they may have tripped.
        """
        now = self._clock.now()
        if self._paused or now - self._exchanged > self._bite:
            self._resume()
        self._exchanged = now
        return self._transact(goals, now, period)

    def pause(self) -> None:
        """Let every servo hold as it does, with nobody talking to it, until the next `exchange`. Never raises."""
        self._fall_silent()
        for line in self._lines:
            disarm_watchdogs(line)

    def disarm(self) -> list[str]:
        """Switch torque off; return the joints at which that could not be confirmed. Never raises."""
        self._fall_silent()
        return disarm(self._lines, self._clock)

    def close(self) -> None:
        """Give the ports back. Never raises."""
        for line in self._lines:
            with contextlib.suppress(Exception):
                line.port.close()

    def _resume(self) -> None:
        self._paused = False
        self._exchanged = self._clock.now()
        for line in self._lines:
            line.cycle.watch.on = True
            line.watchdogs.arm_all()

    def _fall_silent(self) -> None:
        """Read no more conditions, and let what is under way come to its end."""
        self._paused = True
        if any(line.cycle.watch.on for line in self._lines):
            settle(self._clock)
        for line in self._lines:
            line.cycle.watch.rest()

    def _exchange_patiently(self, goals: Sequence[float] | None) -> JointState:
        return self._transact(goals, self._clock.now(), _NS, _PATIENCE)

    def _transact(
        self, goals: Sequence[float] | None, start: int, period: int, patience: int = PATIENCE
    ) -> JointState:
        latest = start + round(SHARE_OF_TICK * period)
        # All of them, before a wire carries any.
        frames = [line.goal_frames(goals, self._position) for line in self._lines]
        if self._softer is not None:
            caps = [line.cap_frames(self._softer, line.servos) for line in self._lines]
            frames = [cap + frame for cap, frame in zip(caps, frames, strict=True)]
            self._softer = None
        pending = [
            line for line, frame in zip(self._lines, frames, strict=True)
            if line.cycle.begin(frame, start, latest, start + period, patience)]
        now = start
        while pending:
            due = min([line.cycle.quiet_until for line in pending])
            if due > now:
                self._clock.wait((), due)  # a reply may come in many pieces: not every one is worth waking for
                now = due
            awaited = [line for line in pending if line.cycle.quiet_until <= now]
            until = min([line.cycle.deadline for line in awaited])
            if len(awaited) < len(pending):
                until = min([until, *[line.cycle.quiet_until for line in pending if line not in awaited]])
            self._clock.wait([line.port for line in awaited], until)
            now = self._clock.now()
            pending = [line for line in pending if line not in awaited or line.cycle.advance(now)]
        return self._state(self._clock.now())

    def _state(self, now: int) -> JointState:
        position, velocity, effort = self._position, self._velocity, self._effort
        heard, valid = self._heard, self._valid
        for line in self._lines:
            supply = line.cycle.watch.rota.supply.by_slot
            for slot, sample in line.cycle.outcome.items():
                if sample is None:
                    valid[slot] = False
                else:
                    if not (valid[slot] or self._paused) and line.watchdogs.may_have_tripped(
                            slot, (now - heard[slot]) / _NS):
                        line.cycle.watch.rota.tripped.add(slot)
                    position[slot], velocity[slot], driven = sample
                    effort[slot] = driven * supply.get(slot, 1.0)
                    valid[slot], heard[slot] = True, now
        age = tuple([(now - then) / _NS for then in heard])
        for line in self._lines:
            oldest = max([age[slot] for slot in line.slots])
            if oldest > self._max_age[line.name]:
                self._max_age[line.name] = oldest
        return JointState(tuple(position), tuple(velocity), tuple(effort), tuple(valid), age)
