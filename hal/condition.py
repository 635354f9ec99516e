"""What servos tell of themselves beside their motion: voltage, temperature, current, faults, and whether they hold.

Read in turn, one servo a tick, in the time that is left on the wire when goals and feedback are through. The request
goes out last in a tick, and its answer is fetched as the next tick begins: nobody waits for it.
"""

from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

from hal.encoding import decoder
from hal.protocol import GroupReply, ServoProtocol
from hal.register_map import Register
from hal.supply import SupplyShares
from hal.wired import Wired
from robotwalk.types import Measured, ServoCondition, ServoLimits

_NO_LIMITS = ServoLimits()
_GAP = 20  # bytes between registers, beyond which two reads are cheaper than one


class Probe(NamedTuple):
    """A read of some of a servo's registers."""

    servo: Wired
    names: tuple[str, ...]
    size: int  # bytes of the answer's data
    decode: Callable[[bytes], Sequence[int]]
    request: bytes
    reply: GroupReply


def probe(protocol: ServoProtocol, servo: Wired, address: int, fields: Sequence[tuple[Register, int]]) -> Probe:
    """Return the read of registers that lie at these offsets behind an address."""
    size = max(offset + register.size for register, offset in fields)
    names = tuple(register.name for register, _ in fields)
    return Probe(servo, names, size, decoder(fields), *protocol.single_read(servo.id, address, size))


def probes(protocol: ServoProtocol, servo: Wired) -> Iterator[Probe]:
    """Return as few reads as bring a servo's whole condition."""
    rows = sorted((servo.model[name] for name in servo.model.condition), key=lambda row: row.address)
    run: list[Register] = []
    for row in rows:
        if run and row.address - run[-1].end > _GAP:
            yield _together(protocol, servo, run)
            run = []
        run.append(row)
    yield _together(protocol, servo, run)


def _together(protocol: ServoProtocol, servo: Wired, rows: Sequence[Register]) -> Probe:
    base = rows[0].address
    return probe(protocol, servo, base, [(row, row.address - base) for row in rows])


class ConditionRota:
    """Whose condition is read next, and what was read. Servos that report a fault come first.

    Attributes:
        limp: the slots of servos that said that their torque is off.
        gathered: the reads, by slot, that bring a servo's whole condition from where it was gathered.
        tripped: the slots whose bus watchdog has tripped, or may have; see `rearm`.
        supply: how the voltages that servos told compare to the rated ones.
    """

    def __init__(self, protocol: ServoProtocol, servos: Sequence[Wired]) -> None:
        self.tripped: set[int] = set()
        self.supply = SupplyShares()
        self._rearmed: set[int] = set()  # since the last read was sent
        self._servos = tuple(servos)
        self._turns: deque[Probe] = deque()
        self._hurried: deque[Probe] = deque()
        self._counts: dict[tuple[int, str], int] = {}  # by slot and register
        self._measured: dict[tuple[int, str], Measured] = {}
        self._conditions: dict[int, ServoCondition] = {}  # by slot, made anew when something was told
        self._limits: dict[int, ServoLimits] = {}  # by slot, as far as they were asked
        self.limp: set[int] = set()
        self.gathered: dict[int, Probe] = {}
        self._turns.extend(probe for servo in servos for probe in probes(protocol, servo))

    def gather(self, probe: Probe) -> None:
        """Read a servo's condition by this alone."""
        self.gathered[probe.servo.slot] = probe
        others = [other for other in self._turns if other.servo.slot != probe.servo.slot]
        self._turns = deque(sorted((*others, probe), key=lambda each: each.servo.slot))

    def bound(self, servo: Wired, limits: ServoLimits) -> None:
        """Take note of where a servo's own protections act."""
        self._limits[servo.slot] = limits
        self._conditions.pop(servo.slot, None)

    def forget_one(self, slot: int) -> None:
        """Forget what was read of a servo that has started anew."""
        for place in [place for place in self._counts if place[0] == slot]:
            del self._counts[place], self._measured[place]
        self._conditions.pop(slot, None)
        self.supply.forget(slot)
        self.limp.discard(slot)
        self.tripped.discard(slot)

    def forget(self) -> None:
        """Forget all that was read: torque was off then, or the servo was another."""
        self.tripped.clear()
        self.supply = SupplyShares()
        self._hurried.clear()
        self._counts.clear()
        self._measured.clear()
        self._conditions.clear()
        self.limp.clear()

    def hurry(self, slot: int) -> None:
        """Read next what is wrong with a servo."""
        if any(probe.servo.slot == slot for probe in self._hurried):
            return
        self._hurried += (
            probe for probe in self._turns
            if probe.servo.slot == slot and self._says_what_is_wrong(probe))

    def next(self, deaf: Collection[int]) -> Probe | None:
        """Return the next read, None if there is nobody to ask; who is `deaf` (slots) would not answer."""
        self._rearmed.clear()
        if self._hurried:
            return self._hurried.popleft()
        for _ in range(len(self._turns)):
            self._turns.rotate(-1)
            if self._turns[-1].servo.slot not in deaf:
                return self._turns[-1]
        return None

    def note(self, probe: Probe, now: int) -> None:
        """Keep what a read brought, if it brought anything."""
        status = probe.reply.results[probe.servo.id]
        if status is None or status.error or len(status.data) != probe.size:
            return
        slot, model = probe.servo.slot, probe.servo.model
        told = dict(zip(probe.names, probe.decode(status.data), strict=True))
        torque = model.cyclic.telemetry.torque
        if self.gathered.get(slot) is probe and not any(told.values()):
            told = {torque: 0}  # it has started anew, and gathers nothing
        for name, counts in told.items():
            self._counts[slot, name] = counts
            self._measured[slot, name] = Measured(counts * model[name].si_scale, now)
        volts = model.cyclic.telemetry.voltage
        if volts in told:
            self.supply.note(probe.servo, self._measured[slot, volts].value)
        self._conditions.pop(slot, None)
        if self._counts.get((slot, torque), 1):
            self.limp.discard(slot)
        else:
            self.limp.add(slot)
        if model.watchdog is not None:
            register, armed = model.watchdog
            tripped = told.get(register.name, armed) != armed
            if tripped and slot not in self._rearmed:
                self.tripped.add(slot)

    def rearm(self) -> None:
        """Take those that have tripped for armed again; what was asked before tells nothing new of them."""
        self._rearmed |= self.tripped
        self.tripped.clear()

    def faults(self, servo: Wired) -> tuple[str, ...]:
        """Return what is wrong with a servo, in words, as far as it was asked."""
        name = servo.model.cyclic.telemetry.error
        if name is None:
            return ()  # its answers tell only that something is
        counts = self._counts.get((servo.slot, name), 0)
        if counts == 0:
            return ()
        meanings = dict(enumerate(servo.model[name].flags))
        return tuple(meanings.get(bit) or f"fault {bit}" for bit in range(8) if counts >> bit & 1)

    def conditions(self) -> Mapping[str, ServoCondition]:
        """Return what is known of each servo, by its joint."""
        return {servo.joint: self.condition(servo) for servo in self._servos}

    def condition(self, servo: Wired) -> ServoCondition:
        """Return what is known of one servo: the same objects, until it tells anew."""
        slot = servo.slot
        condition = self._conditions.get(slot)
        if condition is None:
            rows, told = servo.model.cyclic.telemetry, self._measured
            holds = self._counts.get((slot, rows.torque))
            condition = self._conditions[slot] = ServoCondition(
                told.get((slot, rows.voltage)), told.get((slot, rows.temperature)),
                None if rows.current is None else told.get((slot, rows.current)),
                None if holds is None else holds != 0, self.faults(servo), self._limits.get(slot, _NO_LIMITS))
        return condition

    def _says_what_is_wrong(self, probe: Probe) -> bool:
        name = probe.servo.model.cyclic.telemetry.error
        return name is None or name in probe.names
