"""All the robot's wires as one `robotwalk.ports.ServoBus`: in flight at once, from one thread."""

import contextlib
import math
from collections.abc import Mapping, Sequence, Set

from hal import bus_plan
from hal.bus_plan import SHARE_OF_TICK
from hal.line_cycle import PATIENCE
from hal.servo_line import ServoLine
from hal.wired import Wired
from robotwalk.errors import BusError
from robotwalk.ports import Clock
from robotwalk.types import BusStatistics, JointState

_NS = 1_000_000_000
_MS = 1_000_000
_BEYOND_LIMITS = 0.1  # rad that a limp joint may hang past its limits
_PATIENCE = 40_000_000  # ns past the time that the bytes take, while arming
_TRIES = 3
_GENTLE = 0.2  # of the torque, with which a limb comes to power
_RAMP = (0.4, 0.6, 0.8)
_SETTLING = 50_000_000  # ns between steps of the start
_QUIET = 10_000_000  # ns after which no reply is under way any more


class SerialServoBus:
    """Exchanges goals for states with every servo, once a tick.

    A reply that is missing, late, short or garbled costs its own joints this sample and nothing more: they
    keep their last values, marked not valid, and their age grows.
    """

    def __init__(self, joints: Sequence[str], lines: Sequence[ServoLine], clock: Clock) -> None:
        self._joints = tuple(joints)
        self._lines = tuple(lines)
        self._clock = clock
        count = len(self._joints)
        self._position, self._velocity, self._effort = [math.nan] * count, [0.0] * count, [0.0] * count
        self._heard = [0] * count  # ns
        self._valid = [False] * count
        self._max_age = dict.fromkeys((line.name for line in lines), 0.0)

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints' names, in the robot's order."""
        return self._joints

    @property
    def lines(self) -> tuple[ServoLine, ...]:
        """The wires."""
        return self._lines

    @property
    def alerts(self) -> list[str]:
        """The joints whose servos reported a fault of their hardware in the last exchange."""
        return [
            servo.joint for line in self._lines for servo in line.servos if line.cycle.alerts.get(servo.slot, False)]

    def arm(self, period: int, torque: float = 1.0) -> JointState:
        """Find every servo, let it hold where it is, switch torque on, limb by limb and gently.

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
        state = self._find(period)
        on = {servo.slot for line in self._lines for servo in line.servos if self._is_on(line, servo)}
        try:
            self._hold(state, on, torque)
        except BaseException:
            if not on:
                self.disarm()
            raise
        return self._read_patiently()

    def exchange(self, goals: Sequence[float], period: int) -> JointState:
        """Write the goals (rad) to all joints and read all of them back, within `period` ns."""
        return self._transact(goals, period)

    def disarm(self) -> list[str]:
        """Switch torque off; return the joints at which that could not be confirmed. Never raises."""
        doubtful: list[str] = []
        for line in self._lines:
            try:
                doubtful += self._let_go(line)
            except Exception:
                doubtful += [servo.joint for servo in line.servos]
        return doubtful

    def close(self) -> None:
        """Give the ports back. Never raises."""
        for line in self._lines:
            with contextlib.suppress(Exception):
                line.port.close()

    def _let_go(self, line: ServoLine) -> list[str]:
        """Switch a wire's torque off, twice since nobody acknowledges a broadcast, and look whether it is."""
        for _ in range(2):
            self._pause(_QUIET)
            line.broadcast_torque_off()
        self._pause(_QUIET)
        for index, servo in enumerate(line.servos):
            try:
                if self._is_on(line, servo):
                    line.write_register(self._clock, servo, "torque_enable", 0)
            except BusError:
                # The others are hardly to be heard either, and somebody waits.
                return [other.joint for other in line.servos[index:]]
        return []

    def statistics(self) -> Mapping[str, BusStatistics]:
        """Return what each bus carried, by its name."""
        return {
            line.name: BusStatistics(
                line.wire.tx_bytes, line.wire.rx_bytes, line.cycle.transactions, line.cycle.lost_replies,
                line.bad_frames, self._max_age[line.name])
            for line in self._lines
        }

    def _find(self, period: int) -> JointState:
        """Find every servo as the robot's file says, and where its joint is. Nothing is changed but settings."""
        for line in self._lines:
            self._identify(line)
            self._check_pace(line, period)
        self._heard = [self._clock.now()] * len(self._joints)
        state = self._read_patiently()
        self._check_positions(state)
        return state

    def _hold(self, state: JointState, on: Set[int], torque: float) -> None:
        """Let every servo hold where it is; bring those that are off to power, limb by limb and gently."""
        for line in self._lines:
            line.cap_torque(_GENTLE * torque, [servo for servo in line.servos if servo.slot not in on])
        # The goal register may hold anything: it must hold the present position before torque is on.
        self._transact(state.position, _NS, _PATIENCE)
        for limb in dict.fromkeys(servo.limb for line in self._lines for servo in line.servos):
            for line in self._lines:
                for servo in line.servos:
                    if servo.limb == limb and servo.slot not in on:
                        self._switch_on(line, servo, state.position[servo.slot])
            self._pause(_SETTLING)
        for share in _RAMP:
            for line in self._lines:
                line.cap_torque(share * torque, [servo for servo in line.servos if servo.slot not in on])
            self._pause(_SETTLING)
        for line in self._lines:
            line.cap_torque(torque, line.servos)

    def _read_patiently(self) -> JointState:
        """Read all joints, again if some do not answer: nothing presses yet."""
        for _ in range(_TRIES - 1):
            state = self._transact(None, _NS, _PATIENCE)
            if all(state.valid):
                return state
        return self._transact(None, _NS, _PATIENCE)

    def _switch_on(self, line: ServoLine, servo: Wired, position: float) -> None:
        """Switch torque on, once the servo has shown that its goal is where it is: nobody acknowledged that."""
        name = servo.model.cyclic.goal
        goal = line.read_register(self._clock, servo, name)
        if goal != servo.calibration.ticks(position):
            raise BusError(f"{servo} on bus {line.name} did not take its position as goal: it holds {goal} in {name}")
        line.write_register(self._clock, servo, "torque_enable", 1)

    def _is_on(self, line: ServoLine, servo: Wired) -> bool:
        return line.read_register(self._clock, servo, "torque_enable") != 0

    def _pause(self, duration: int) -> None:
        self._clock.wait((), self._clock.now() + duration)

    def _check_positions(self, state: JointState) -> None:
        """Refuse what cannot be a joint's angle: a missing one, or one outside its limits."""
        for line in self._lines:
            for servo in line.servos:
                angle = state.position[servo.slot]
                if not state.valid[servo.slot]:
                    raise BusError(f"no position from {servo} on bus {line.name}")
                if not servo.lower - _BEYOND_LIMITS <= angle <= servo.upper + _BEYOND_LIMITS:
                    raise BusError(
                        f"{servo} on bus {line.name} stands at {math.degrees(angle):.0f} deg, outside the joint's "
                        f"{math.degrees(servo.lower):.0f} to {math.degrees(servo.upper):.0f} deg; "
                        "is its direction and zero_deg right?")

    def _check_pace(self, line: ServoLine, period: int) -> None:
        """Refuse a bus that cannot carry a cycle in its period."""
        wire, rate = line.wire, _NS // period
        plan = bus_plan.cycle_of(line.protocol, line.servos, line.cycle.readers)
        waits = {"return_delay": wire.return_delay / _NS, "latency": wire.latency / _NS}
        exchange = plan.seconds(wire.baud, rate, **waits)
        if exchange <= SHARE_OF_TICK / rate:
            return
        on_wire = plan.seconds(wire.baud, rate)
        cause = f"its bytes take {1e3 * on_wire:.1f} ms at this baud"
        if exchange > 2.0 * on_wire:
            cause = (
                f"the adapter holds every reply back for {wire.latency / _MS:.0f} ms (an FTDI's latency_timer is 16 ms "
                "unless set to 1 in /sys/bus/usb-serial/devices/ttyUSB*/latency_timer)")
        raise BusError(
            f"bus {line.name} cannot be read at {rate} Hz: an exchange takes {1e3 * exchange:.1f} ms, for {cause}. "
            f"As it is, --rate {plan.largest_rate(wire.baud, SHARE_OF_TICK, **waits)} is the most")

    def _identify(self, line: ServoLine) -> None:
        """Ping every servo of a wire and check that it is what the robot's file says."""
        missing: list[Wired] = []
        fast: set[int] = set()
        latencies = []
        for servo in line.servos:
            status, latency = line.ping(self._clock, servo)
            if status is None:
                missing.append(servo)
                continue
            latencies.append(latency)
            if status.alert:
                raise BusError(
                    f"{servo} on bus {line.name} reports a hardware error (overload, heat or voltage); "
                    "its torque stays off until it is rebooted")
            number = line.read_register(self._clock, servo, "model_number")
            if number != servo.model.model_number:
                raise BusError(
                    f"{servo} on bus {line.name} should be a {servo.model.name} "
                    f"(model {servo.model.model_number}); model {number} answered")
            if self._reads_fast(line, servo):
                fast.add(servo.id)
            line.settle(self._clock, servo)
        if missing:
            everyone = " Is it powered, and is the baud right?" if len(missing) == len(line.servos) else ""
            raise BusError(f"no answer on bus {line.name} from {', '.join(map(str, missing))}.{everyone}")
        line.wire.latency = min(latencies)
        line.cycle.read_fast(fast)

    def _reads_fast(self, line: ServoLine, servo: Wired) -> bool:
        """Tell whether a servo's firmware has fast sync read."""
        first = servo.model.fast_sync_read_firmware
        return first is not None and line.read_register(self._clock, servo, "firmware_version") >= first

    def _transact(self, goals: Sequence[float] | None, period: int, patience: int = PATIENCE) -> JointState:
        start = self._clock.now()
        latest = start + round(SHARE_OF_TICK * period)
        frames = [line.cycle.goal_frames(goals) for line in self._lines]  # all of them, before a wire carries any
        pending = [
            line for line, frame in zip(self._lines, frames, strict=True)
            if line.cycle.begin(frame, start, latest, patience)]
        while pending:
            self._clock.wait([line.port for line in pending], min(line.cycle.deadline for line in pending))
            now = self._clock.now()
            pending = [line for line in pending if line.cycle.advance(now)]
        return self._state(self._clock.now())

    def _state(self, now: int) -> JointState:
        heard, valid = self._heard, self._valid
        for line in self._lines:
            for slot, sample in line.cycle.outcome.items():
                valid[slot] = sample is not None
                if sample is not None:
                    self._position[slot], self._velocity[slot], self._effort[slot] = sample
                    heard[slot] = now
        age = tuple((now - then) / _NS for then in heard)
        for line in self._lines:
            oldest = max(age[servo.slot] for servo in line.servos)
            self._max_age[line.name] = max(self._max_age[line.name], oldest)
        return JointState(
            tuple(self._position), tuple(self._velocity), tuple(self._effort), tuple(valid), age)
