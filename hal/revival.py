"""A servo that has let go is brought back, step by step, beside the exchange.

    find      it answers; what is wrong with it is something that may be cleared
    restart   where a restart clears it; else torque off, which clears it where nothing else does
    restore   it is the model that it was, and has in its RAM what arming had put there
    hold      its goal is where it is; torque comes on, gently, and then all of it

Meanwhile the exchange sends it to where it is in every tick. Nothing waits: one step a tick, in the time in which
conditions are read otherwise. Writes go out as sync writes, which nobody answers, and are read back.
"""

from collections.abc import Generator, Sequence

from hal import indirect
from hal.condition import Probe, probe
from hal.encoding import pack
from hal.servo_line import ServoLine
from hal.wired import Wired
from robotwalk.ports import Clock

_PATIENCE = 1_500_000_000  # ns that a servo may be silent, or its limp shaft move; starting takes less
_TRIES = 5  # at a write
_GENTLE = (0.2, 0.5, 1.0)  # shares of the torque
_SETTLING = 5  # ticks between them
_NEAR = 8  # counts that a limp shaft may have moved since it was last read

Step = Probe | bytes | None
_Steps = Generator[Step, Sequence[int] | None, None]
_Read = Generator[Step, Sequence[int] | None, int | None]


class _FailedError(Exception):
    """It cannot be brought back, for this reason."""


class Revival:
    """Brings one servo back. An errand of its line's watch; `over` at its end.

    Attributes:
        step: see `hal.condition_watch.Errand`.
        over: whether it is at its end.
        failure: why the servo could not be brought back, in words; None if it was, or not yet.
    """

    def __init__(self, line: ServoLine, servo: Wired, torque: float, clock: Clock) -> None:
        """Begin; `torque` is the share of its largest output that the servo may use."""
        self.over = False
        self.failure: str | None = None
        self.slot = servo.slot
        self._line, self._servo, self._clock = line, servo, clock
        self._torque = torque
        self._steps = self._revive()
        self.step: Step = next(self._steps)

    def go_on(self, counts: Sequence[int] | None) -> None:
        """Take what the step has brought; choose the next one."""
        try:
            self.step = self._steps.send(counts)
        except StopIteration:
            self.over = True
        except _FailedError as failed:
            self.over, self.failure = True, str(failed)

    def _revive(self) -> _Steps:
        servo, arming, telemetry = self._servo, self._servo.model.arming, self._servo.model.cyclic.telemetry
        faults: set[str] = set()
        if telemetry.error is not None:
            counts = yield from self._wait_for(telemetry.error)
            flags = servo.model[telemetry.error].flags
            faults = {name or f"bit {bit}" for bit, name in enumerate(flags) if counts >> bit & 1}
        else:
            yield from self._wait_for(telemetry.torque)
        if not faults <= {*arming.restart_clears, *arming.torque_clears}:
            raise _FailedError(f"it reports {', '.join(sorted(faults))}")
        if faults & set(arming.restart_clears):
            yield self._line.protocol.reboot(servo.id)
        else:
            yield from self._write(telemetry.torque, 0)
        model_number = yield from self._wait_for("model_number")
        if model_number != servo.model.model_number:
            raise _FailedError(f"model {model_number} answers in its place")
        yield from self._restore()
        for share in _GENTLE:
            yield from self._cap(share * self._torque)
            if share is _GENTLE[0]:
                yield from self._hold()
                self._line.watchdogs.arm_again({servo.slot})
            for _ in range(_SETTLING):
                yield None
        if telemetry.error is not None and (yield from self._wait_for(telemetry.error)):
            raise _FailedError("its fault is there again")
        self._line.cycle.watch.rota.forget_one(servo.slot)

    def _restore(self) -> _Steps:
        """Write what it forgets without power."""
        for name, counts in self._servo.model.arming.set.items():
            yield from self._write(name, counts)
        gathered = self._line.cycle.watch.rota.gathered.get(self._servo.slot)
        if gathered is not None:
            address, data = indirect.mapping(gathered.servo.model)
            yield self._line.protocol.sync_write(address, len(data), [(self._servo.id, data)])

    def _cap(self, share: float) -> _Steps:
        register = self._servo.model[self._servo.model.cyclic.torque_cap]
        assert register.range is not None
        yield from self._write(register.name, round(share * register.range[1]))

    def _hold(self) -> _Steps:
        """Switch torque on, once its goal is where it is."""
        servo, cyclic = self._servo, self._servo.model.cyclic
        deadline = self._clock.now() + _PATIENCE
        while self._clock.now() < deadline:  # a limp leg may still sink
            goal = yield from self._read(cyclic.goal)
            here = yield from self._read(cyclic.position)
            if goal is not None and here is not None and abs(goal - here) <= _NEAR:
                yield from self._write(cyclic.telemetry.torque, 1)
                return
        raise _FailedError(f"{cyclic.goal} of {servo} does not take its position")

    def _wait_for(self, name: str) -> Generator[Step, Sequence[int] | None, int]:
        """Read a register as soon as the servo answers."""
        deadline = self._clock.now() + _PATIENCE
        while True:
            counts = yield from self._read(name)
            if counts is not None:
                return counts
            if self._clock.now() >= deadline:
                raise _FailedError("it does not answer")

    def _read(self, name: str) -> _Read:
        register = self._servo.model[name]
        counts = yield probe(self._line.protocol, self._servo, register.address, [(register, 0)])
        return None if counts is None else counts[0]

    def _write(self, name: str, value: int) -> _Steps:
        register = self._servo.model[name]
        for _ in range(_TRIES):
            yield self._line.protocol.sync_write(
                register.address, register.size, [(self._servo.id, pack(register, value))])
            if (yield from self._read(name)) == value:
                return
        raise _FailedError(f"it does not take {name} = {value}")
