"""From a cold bus to a robot that holds itself: find, examine, mend what may be mended, come to power gently.

The order is that of the reference's section 7.4. Before torque comes on every servo is known to be the model that the
robot's file names, to be set up for position control, to be within its joint's limits, and to have its own position
as its goal.
"""

import math
from collections.abc import Callable, Sequence, Set

from hal import bus_plan, indirect
from hal.bus_plan import SHARE_OF_TICK
from hal.protocol import Status
from hal.register_map import Memory
from hal.servo_line import ServoLine
from hal.wired import Wired
from robotwalk.errors import BusError
from robotwalk.ports import Clock
from robotwalk.types import JointState, ServoLimits

_NS = 1_000_000_000
_MS = 1_000_000
_BEYOND_LIMITS = 0.1  # rad that a limp joint may hang past its limits
_TRIES = 25  # at hearing everybody
_GENTLE = 0.2  # of the torque, with which a limb comes to power
_RAMP = (0.4, 0.6, 0.8)
_SETTLING = 50_000_000  # ns between steps of the start
_RESTART = 2_000_000_000  # ns within which a servo is back after a restart
_SLOW_ADAPTER = 3_000_000  # ns; a timer of 1 ms and what the operating system adds are less

Exchange = Callable[[Sequence[float] | None], JointState]


class Arming:
    """One start of a robot."""

    def __init__(self, lines: Sequence[ServoLine], clock: Clock, exchange: Exchange) -> None:
        """Take the wires, and what writes goals (None: none) and reads all joints, patiently."""
        self._found: dict[str, list[str]] = {}  # who it is true of
        self._lines = lines
        self._clock = clock
        self._exchange = exchange

    @property
    def notes(self) -> list[str]:
        """What was mended or is worth knowing, in words."""
        return [f"{what}: {', '.join(who)}" for what, who in self._found.items()]

    def find(self, period: int) -> JointState:
        """Find every servo as the robot's file says, and where its joint is; mend what is safe to mend.

        Raises:
            BusError: a servo is missing, is another model, reports an error, is set up for something else, or stands
                outside its joint's limits; or the bus is too slow for the period.
        """
        for line in self._lines:
            self._identify(line)
            for servo in line.servos:
                self._examine(line, servo)
            self._check_pace(line, period)
        state = self.everybody()
        self._check_positions(state)
        return state

    def hold(self, state: JointState, torque: float) -> JointState:
        """Let every servo hold where it is; bring those that are off to power, limb by limb and gently."""
        on = self.standing()
        off = {line: [servo for servo in line.servos if servo.slot not in on] for line in self._lines}
        for line in self._lines:
            line.cap_torque(_GENTLE * torque, off[line])
        # The goal register may hold anything: it must hold the present position before torque is on.
        self._exchange(state.position)
        for limb in dict.fromkeys(servo.limb for line in self._lines for servo in line.servos):
            for line in self._lines:
                for servo in off[line]:
                    if servo.limb == limb:
                        self._switch_on(line, servo, state.position[servo.slot])
            self._pause(_SETTLING)
        for share in _RAMP:
            for line in self._lines:
                line.cap_torque(share * torque, off[line])
            self._pause(_SETTLING)
        for line in self._lines:
            line.cap_torque(torque, line.servos)
        return self.everybody()

    def standing(self) -> Set[int]:
        """Return the slots of the servos whose torque is on: the robot may be standing on them."""
        return {servo.slot for line in self._lines for servo in line.servos if self._is_on(line, servo)}

    def everybody(self) -> JointState:
        """Read all joints, again if some do not answer: nothing presses yet."""
        began = self._clock.now()
        state = self._exchange(None)
        for _ in range(_TRIES - 1):
            if max(state.age) * _NS <= self._clock.now() - began:
                break
            state = self._exchange(None)
        return state

    def _identify(self, line: ServoLine) -> None:
        """Ping every servo of a wire and check that it is what the robot's file says."""
        missing: list[Wired] = []
        fast: set[int] = set()
        delays: list[int] = []
        latencies: list[int] = []
        for servo in line.servos:
            status, latency = line.ping(self._clock, servo)
            if status is None:
                missing.append(servo)
                continue
            if status.alert:
                self._clear(line, servo, status)
            number = line.read_register(self._clock, servo, "model_number")
            if number != servo.model.model_number:
                raise BusError(
                    f"{servo} on bus {line.name} should be a {servo.model.name} "
                    f"(model {servo.model.model_number}); model {number} answered")
            if self._reads_fast(line, servo):
                fast.add(servo.id)
            delays.append(self._return_delay(line, servo))
            latencies.append(latency - delays[-1])
        if missing:
            everyone = " Is it powered, and is the baud right?" if len(missing) == len(line.servos) else ""
            raise BusError(f"no answer on bus {line.name} from {', '.join(map(str, missing))}.{everyone}")
        line.wire.latency, line.wire.return_delay = max(min(latencies), 0), max(delays)
        line.cycle.read_fast(fast)

    def _clear(self, line: ServoLine, servo: Wired, status: Status) -> None:
        """Restart a servo that has only been overloaded; refuse any other that reports an error."""
        arming, error = servo.model.arming, servo.model.cyclic.telemetry.error
        faults: list[str] = []
        if error is not None:
            counts, flags = line.read_register(self._clock, servo, error), servo.model[error].flags
            faults = [name or f"bit {bit}" for bit, name in enumerate(flags) if counts >> bit & 1]
        words = ", ".join(faults) or "overload, heat or a wrong voltage"
        if faults and set(faults) <= set(arming.restart_clears) and not self._is_on(line, servo):
            line.restart(self._clock, servo, _RESTART)
            again, _ = line.ping(self._clock, servo)
            if again is not None and not again.alert:
                self._note(servo, f"had shut down for {words}, and was restarted")
                return
        cure = f"robotwalk servo reboot {servo.id}" if arming.restart_clears else "switch its power off and on"
        raise BusError(
            f"{servo} on bus {line.name} reports a hardware error ({words}); its torque stays off. Find the cause, "
            f"then: {cure}")

    def _reads_fast(self, line: ServoLine, servo: Wired) -> bool:
        """Tell whether a servo's firmware has fast sync read."""
        first = servo.model.fast_sync_read_firmware
        if first is None:
            return False
        version = line.read_register(self._clock, servo, "firmware_version")
        if version < first:
            self._note(servo, f"firmware {version} has no fast sync read; with {first} or later its bus is faster")
        return version >= first

    def _return_delay(self, line: ServoLine, servo: Wired) -> int:
        """Return how long a servo lets pass before it answers, ns; none, if it lets that be set now."""
        register = servo.model["return_delay_time"]
        counts = line.read_register(self._clock, servo, register.name)
        if counts and not self._is_on(line, servo):
            try:
                line.write_eeprom(self._clock, servo, register.name, 0)
            except BusError as error:
                self._note(servo, f"keeps its return delay of {counts * register.scale:g} us: {error}")
            else:
                self._note(servo, f"return_delay_time set to 0; it was {counts * register.scale:g} us")
                return 0
        return round(counts * register.si_scale * _NS)

    def _examine(self, line: ServoLine, servo: Wired) -> None:
        """See that a servo is set up to control its joint's position.

        What it forgets without power is written; what it keeps is not ours to change unasked.
        """
        arming, model = servo.model.arming, servo.model
        self._clear_watchdog(line, servo)
        for name, wanted in arming.require.items():
            found = line.read_register(self._clock, servo, name)
            if found != wanted:
                raise BusError(
                    f"{servo} on bus {line.name} has {name} = {found}; to walk it needs {wanted}: "
                    f"robotwalk servo write {servo.id} {name}={wanted} --raw")
        for name, wanted in arming.set.items():
            assert model[name].memory is Memory.RAM
            if line.read_register(self._clock, servo, name) != wanted:
                line.write_register(self._clock, servo, name, wanted)
        for name, usual in arming.explain.items():
            found = line.read_register(self._clock, servo, name)
            if found != usual:
                self._note(servo, f"{name} is {found}; the factory's is {usual}")
        self._check_range(line, servo)
        line.cycle.watch.rota.bound(servo, self._limits(line, servo))
        self._gather(line, servo)

    def _clear_watchdog(self, line: ServoLine, servo: Wired) -> None:
        """Disarm what another program armed; one that has tripped must not run to an old goal then."""
        if servo.model.watchdog is None:
            return
        register, _ = servo.model.watchdog
        counts = line.read_register(self._clock, servo, register.name)
        if counts == 0:
            return
        cyclic = servo.model.cyclic
        here = line.read_register(self._clock, servo, cyclic.position)
        line.write_register(self._clock, servo, register.name, 0)
        assert register.range is not None
        if counts > register.range[1]:
            line.write_register(self._clock, servo, cyclic.goal, here)
            self._note(servo, "had stopped, for it heard nothing any more; it holds where it is")

    def _limits(self, line: ServoLine, servo: Wired) -> ServoLimits:
        """Return where a servo's own protections act."""
        names = servo.model.cyclic.limits

        def limit(name: str | None) -> float | None:
            if name is None:
                return None
            return line.read_register(self._clock, servo, name) * servo.model[name].si_scale

        return ServoLimits(
            limit(names.hottest), limit(names.lowest_voltage), limit(names.highest_voltage),
            limit(names.largest_current))

    def _gather(self, line: ServoLine, servo: Wired) -> None:
        """Have a servo's condition read at once, where it can be gathered."""
        model = servo.model
        if model.older_firmware:
            model = model.at_firmware(line.read_register(self._clock, servo, "firmware_version"))
        gathered = indirect.gather(
            line.protocol, servo._replace(model=model),
            lambda address, size: line.read(self._clock, servo, address, size, "its indirect addresses"),
            lambda address, data: line.write(self._clock, servo, address, data, "its indirect addresses"))
        if gathered is not None:
            line.cycle.watch.rota.gather(gathered)

    def _check_range(self, line: ServoLine, servo: Wired) -> None:
        """Refuse a servo whose own limits keep it from a part of its joint's range."""
        low, high = (line.read_register(self._clock, servo, name) for name in servo.model.arming.position_limits)
        reach = sorted(servo.calibration.ticks(angle) for angle in (servo.lower, servo.upper))
        if low <= reach[0] and reach[1] <= high:
            return
        names = servo.model.arming.position_limits
        mode = " (both 0 make it turn like a wheel)" if low == high == 0 else ""
        raise BusError(
            f"{servo} on bus {line.name} is limited to counts {low} to {high}{mode}, its joint needs {reach[0]} to "
            f"{reach[1]}: robotwalk servo write {servo.id} {names[0]}={reach[0]} {names[1]}={reach[1]} --raw")

    def _check_pace(self, line: ServoLine, period: int) -> None:
        """Refuse a bus that cannot carry a cycle in its period."""
        wire, rate = line.wire, _NS // period
        plan = bus_plan.cycle_of(line.protocol, line.servos, line.cycle.readers)
        waits = {"return_delay": wire.return_delay / _NS, "latency": wire.latency / _NS}
        exchange = plan.seconds(wire.baud, rate, **waits)
        cause = f"its bytes take {1e3 * plan.seconds(wire.baud, rate):.1f} ms at this baud"
        if wire.latency > _SLOW_ADAPTER:
            cause = (
                f"the adapter holds every reply back for {wire.latency / _MS:.0f} ms (an FTDI's latency_timer is 16 ms "
                "unless set to 1 in /sys/bus/usb-serial/devices/ttyUSB*/latency_timer)")
        elif wire.return_delay:
            cause += f", and the servos wait {wire.return_delay / _MS:.1f} ms before they answer"
        if exchange > SHARE_OF_TICK / rate:
            raise BusError(
                f"bus {line.name} cannot be read at {rate} Hz: an exchange takes {1e3 * exchange:.1f} ms, for {cause}. "
                f"As it is, --rate {plan.largest_rate(wire.baud, SHARE_OF_TICK, **waits)} is the most")
        if wire.latency > _SLOW_ADAPTER:
            self._note(f"bus {line.name}", f"would be quicker, but {cause}")

    def _check_positions(self, state: JointState) -> None:
        """Refuse what cannot be a joint's angle: a missing one, or one outside its limits."""
        for line in self._lines:
            for servo in line.servos:
                angle = state.position[servo.slot]
                if math.isnan(angle) or not state.age[servo.slot] < 1.0:
                    raise BusError(f"no position from {servo} on bus {line.name}")
                if not servo.lower - _BEYOND_LIMITS <= angle <= servo.upper + _BEYOND_LIMITS:
                    raise BusError(
                        f"{servo} on bus {line.name} stands at {math.degrees(angle):.0f} deg, outside the joint's "
                        f"{math.degrees(servo.lower):.0f} to {math.degrees(servo.upper):.0f} deg; "
                        "is its direction and zero_deg right?")

    def _switch_on(self, line: ServoLine, servo: Wired, position: float) -> None:
        """Switch torque on, once the servo has shown that its goal is where it is: nobody acknowledged that."""
        name = servo.model.cyclic.goal
        goal = line.read_register(self._clock, servo, name)
        if goal != servo.calibration.ticks(position):
            raise BusError(f"{servo} on bus {line.name} did not take its position as goal: it holds {goal} in {name}")
        line.write_register(self._clock, servo, "torque_enable", 1)

    def _is_on(self, line: ServoLine, servo: Wired) -> bool:
        return line.read_register(self._clock, servo, "torque_enable") != 0

    def _note(self, who: object, what: str) -> None:
        self._found.setdefault(what, []).append(str(who))

    def _pause(self, duration: int) -> None:
        self._clock.wait((), self._clock.now() + duration)
