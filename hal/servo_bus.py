"""All the robot's wires as one `robotwalk.ports.ServoBus`: in flight at once, from one thread."""

import contextlib
import math
from collections.abc import Iterable, Mapping, Sequence

from hal.servo_line import ServoLine, Wired
from robotwalk.errors import BusError
from robotwalk.ports import Clock
from robotwalk.types import BusStatistics, JointState

_NS = 1_000_000_000
_SHARE_OF_PERIOD = 0.9  # of a tick that an exchange may take, whatever is missing


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
        self._max_age = dict.fromkeys((line.name for line in lines), 0.0)

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints' names, in the robot's order."""
        return self._joints

    def arm(self) -> JointState:
        """Find every servo, let it hold where it is, switch torque on (servo by servo).

        Raises:
            BusError: a servo is missing, is another model, or reports an error. Torque is then off.
        """
        try:
            return self._find_and_hold()
        except BusError:
            self.disarm()
            raise

    def exchange(self, goals: Sequence[float], period: int) -> JointState:
        """Write the goals (rad) to all joints and read all of them back, within `period` ns."""
        return self._transact(goals, period)

    def disarm(self) -> None:
        """Switch torque off. Never raises."""
        for line in self._lines:
            with contextlib.suppress(Exception):
                # Twice: nobody acknowledges a broadcast.
                line.broadcast_torque_off()
                line.broadcast_torque_off()
                self._clock.wait((), self._clock.now() + _NS // 100)

    def close(self) -> None:
        """Disarm and give the ports back. Never raises."""
        self.disarm()
        for line in self._lines:
            with contextlib.suppress(Exception):
                line.port.close()

    def statistics(self) -> Mapping[str, BusStatistics]:
        """Return what each bus carried, by its name."""
        return {
            line.name: BusStatistics(
                line.tx_bytes, line.rx_bytes, line.transactions, line.lost_replies, line.bad_frames,
                self._max_age[line.name])
            for line in self._lines
        }

    def _find_and_hold(self) -> JointState:
        for line in self._lines:
            self._find(line)
        self._heard = [self._clock.now()] * len(self._joints)
        state = self._transact(None, _NS)
        silent = [name for name, valid in zip(self._joints, state.valid, strict=True) if not valid]
        if silent:
            raise BusError(f"no position from {', '.join(silent)}")
        # The goal register may hold anything: it must hold the present position before torque is on.
        self._transact(state.position, _NS)
        for line in self._lines:
            for servo in line.servos:
                line.write_register(self._clock, servo, "torque_enable", 1)
        return state

    def _find(self, line: ServoLine) -> None:
        """Ping every servo of a wire and check that it is what the robot's file says."""
        missing: list[Wired] = []
        fast = True
        for servo in line.servos:
            who = f"{servo.joint} (id {servo.id}, bus {line.name})"
            status = line.request(self._clock, line.protocol.ping(servo.id), servo.id)
            if status is None:
                missing.append(servo)
                continue
            if status.alert:
                raise BusError(f"{who} reports a hardware error; reboot it")
            number = line.read_register(self._clock, servo, "model_number")
            if number != servo.model.model_number:
                raise BusError(
                    f"{who} should be a {servo.model.name} (model {servo.model.model_number}); model {number} answered")
            fast = fast and self._reads_fast(line, servo)
        if missing:
            names = ", ".join(f"{servo.joint} (id {servo.id})" for servo in missing)
            everyone = " Is it powered, and is the baud right?" if len(missing) == len(line.servos) else ""
            raise BusError(f"no answer on bus {line.name} from {names}.{everyone}")
        line.read_fast(fast)

    def _reads_fast(self, line: ServoLine, servo: Wired) -> bool:
        """Tell whether a servo's firmware has fast sync read."""
        first = servo.model.fast_sync_read_firmware
        return first is not None and line.read_register(self._clock, servo, "firmware_version") >= first

    def _transact(self, goals: Sequence[float] | None, period: int) -> JointState:
        start = self._clock.now()
        latest = start + round(_SHARE_OF_PERIOD * period)
        for line in self._lines:
            line.begin(goals, start)
        pending = list(self._lines)
        while pending:
            self._clock.wait([line.port for line in pending], min(latest, *(line.deadline for line in pending)))
            now = self._clock.now()
            for line in pending:
                line.collect()
            pending = [line for line in pending if not line.complete and now < min(line.deadline, latest)]
        return self._state(self._clock.now(), self._lines)

    def _state(self, now: int, lines: Iterable[ServoLine]) -> JointState:
        heard = self._heard
        for line in lines:
            for slot, position, velocity, effort in line.samples():
                self._position[slot] = position
                self._velocity[slot] = velocity
                self._effort[slot] = effort
                heard[slot] = now
        age = tuple((now - then) / _NS for then in heard)
        for line in lines:
            oldest = max(age[servo.slot] for servo in line.servos)
            self._max_age[line.name] = max(self._max_age[line.name], oldest)
        return JointState(
            tuple(self._position), tuple(self._velocity), tuple(self._effort),
            tuple(then == now for then in heard), age)
