"""One wire's reads of conditions, beside the exchange: asked as the last thing in a tick, heard as the next begins."""

from collections.abc import Collection, Sequence
from typing import Protocol

from hal.condition import ConditionRota, Probe
from hal.protocol import ServoProtocol
from hal.wire import Wire
from hal.wired import Wired

_PATIENCE = 1_700_000  # ns past the time that the bytes take


class Errand(Protocol):
    """Something that takes many small steps on the wire, one a tick.

    Attributes:
        slot: of the servo that it is about.
        over: whether it is at its end.
    """

    slot: int
    over: bool

    @property
    def step(self) -> Probe | bytes | None:
        """What it wants now: a read, frames that nobody answers, or to wait for a tick."""
        ...

    def go_on(self, counts: Sequence[int] | None) -> None:
        """Take what the step has brought, the counts of a read if they came, and choose the next one."""
        ...


class ConditionWatch:
    """Has at most one question under way.

    Attributes:
        on: whether conditions are read at all.
        rota: whose turn it is, and what was told.
        deadline: until when the present answer is waited for, ns.
        errand: what has the time for itself, in place of the rota; None: nothing has.
    """

    def __init__(self, wire: Wire, protocol: ServoProtocol, servos: Sequence[Wired]) -> None:
        self.on = False
        self.rota = ConditionRota(protocol, servos)
        self.deadline = 0
        self.errand: Errand | None = None
        self._wire = wire
        self._asked: Probe | None = None
        self._data = b""  # that has come
        self._heard_at = 0  # ns

    def rest(self) -> None:
        """Ask nothing more, and expect nothing: others are about to use the wire."""
        self.on = False
        self._asked = self.errand = None

    @property
    def pending(self) -> bool:
        """Whether an answer is due, or has come and was not looked at yet."""
        return self._asked is not None

    def ask(self, now: int, next_tick: int, deaf: Collection[int]) -> None:
        """Ask the next servo but those who are deaf (slots), if its answer can be here by `next_tick`.

        Raises:
            BusError: the port is dead.
        """
        if not self.on:
            return
        probe = self._step_of(self.errand) if self.errand is not None else self.rota.next(deaf)
        if probe is None:
            return
        due = now + self._wire.round_trip(probe.request, probe.reply) + self._wire.latency + _PATIENCE
        if due <= next_tick:
            self._wire.send(probe.request)
            self._asked, self.deadline, self._data = probe, due, b""

    def _step_of(self, errand: "Errand") -> Probe | None:
        """Return the read that an errand wants; else do what it wants instead.

        Raises:
            BusError: the port is dead.
        """
        step = errand.step
        if isinstance(step, Probe):
            return step
        if step is not None:
            self._wire.send(step)
        self._go_on(errand, None)
        return None

    def _go_on(self, errand: "Errand", counts: Sequence[int] | None) -> None:
        errand.go_on(counts)
        if errand.over:
            self.errand = None

    def hear(self, data: bytes, now: int) -> bool:
        """Take bytes; return whether more are to be waited for."""
        assert self._asked is not None
        self._data += data
        self._heard_at = now
        return len(self._data) < self._asked.reply.size and now < self.deadline

    def digest(self) -> int:
        """Look at what has come, when there is time for that; return how many garbled frames it held."""
        probe, self._asked = self._asked, None
        if probe is None:
            return 0
        before = probe.reply.bad_frames
        probe.reply.reset()
        probe.reply.feed(self._data)
        if self.errand is not None and probe is self.errand.step:
            status = probe.reply.results[probe.servo.id]
            good = status is not None and not status.error and len(status.data) == probe.size
            self._go_on(self.errand, probe.decode(status.data) if status is not None and good else None)
        else:
            self.rota.note(probe, self._heard_at)
        return probe.reply.bad_frames - before
