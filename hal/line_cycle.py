"""What one wire does in a tick: the goals go out, then reads, one after the other, for as long as there is time.

When all that is through and time is left, one servo is asked for its condition. Its answer comes between the ticks.

A tick can spare 1.7 ms in all for servos that keep silent. Once these have passed, what has not been asked yet is
asked first in the next tick.
"""

from collections.abc import Collection, Iterator, Sequence
from itertools import chain

from hal.condition import ConditionRota, Probe
from hal.feedback import Reader, Reading, readers
from hal.goal_writer import GoalWriter
from hal.protocol import ServoProtocol
from hal.wire import Wire
from hal.wired import Sample, Wired
from robotwalk.errors import BusError

PATIENCE = 1_700_000  # ns past the time that the bytes take, for servos and adapter
_LEAST_PATIENCE = 300_000  # ns, below which no answer is worth waiting for


class LineCycle:
    """Each tick is `begin`, then `advance` whenever bytes have come or `deadline` has passed, until it returns False.

    Attributes:
        outcome: the samples of this tick, by the joints' slots; None of those that were asked in vain.
        rota: whose condition is read when; what they told.
        watches: whether conditions are read at all.
        alerts: whether the servo of a slot reported a fault when it last answered.
        deadline: until when the present answer is waited for, ns.
    """

    def __init__(self, wire: Wire, protocol: ServoProtocol, servos: Sequence[Wired]) -> None:
        self.transactions = self.lost_replies = self.bad_frames = 0
        self.deadline = 0
        self.outcome: dict[int, Sample | None] = {}
        self.alerts: dict[int, bool] = {}
        self.rota = ConditionRota(protocol, servos)
        self.watches = False
        self._probe: Probe | None = None  # sent, not yet answered
        self._deaf: set[int] = set()  # slots of those who did not answer when last asked
        self._next_tick = 0  # ns
        self._wire = wire
        self._protocol = protocol
        self._servos = tuple(servos)
        self._goals = GoalWriter(protocol, servos)
        self._agenda: Iterator[tuple[Reader, Reading]] = iter(())
        self._current: tuple[Reader, Reading] | None = None
        self._before = b""  # frames that nobody answers, to be sent with the first read
        self._expected = 0  # when the present answer should be there, ns
        self._latest = self._patience = self._bad_before = 0
        self.read_fast(())

    def read_fast(self, ids: Collection[int]) -> None:
        """Choose how feedback is read: these servos know the fast reads."""
        self.readers = readers(self._protocol, self._servos, ids)

    def goal_frames(self, goals: Sequence[float] | None) -> bytes:
        """Return what writes the goals (rad, in the robot's joint order), if any. Raises ValueError on NaN and inf."""
        return b"" if goals is None else self._goals.frames(goals)

    def rest(self) -> None:
        """Expect nothing more: others are about to use the wire."""
        self.watches = False
        self._probe = None

    def begin(self, goal_frames: bytes, now: int, latest: int, next_tick: int, patience: int) -> bool:
        """Send the goals and the first read, once the condition asked for before has come.

        Answers may come until `latest`, that to the next condition until `next_tick` (ns). Return whether any may
        come.
        """
        self.transactions += 1
        self._next_tick = next_tick
        self.outcome = {}
        self._before, self._latest, self._patience = goal_frames, latest, patience
        # Whoever had to stand back in this tick comes first in the next.
        self.readers = [*self.readers[1:], *self.readers[:1]]
        self._agenda = chain.from_iterable(map(_with_readings, self.readers))
        return self.advance(now)

    def advance(self, now: int) -> bool:
        """Take the bytes that have come, and ask on; return whether more may come.

        A dead port costs its own joints their samples, not the other wires theirs.
        """
        if self._current is None:
            return self._await_condition(now) or self._continue(now)
        reader, reading = self._current
        try:
            reading.reply.feed(self._wire.receive())
        except BusError:
            self._conclude(reader, reading)
            return False
        if not reading.reply.complete and now < self.deadline:
            return True
        if not reading.reply.complete:
            self._patience -= max(now - self._expected, 0)
        self._conclude(reader, reading)
        return self._continue(now)

    def _continue(self, now: int) -> bool:
        """Send the next request for which there is time."""
        self._current = next(self._agenda, None) if self._patience >= _LEAST_PATIENCE or self._before else None
        if self._current is None:
            self._ask_condition(now)
            return False
        reader, reading = self._current
        wire = self._wire
        expected = now + wire.duration(len(self._before)) + wire.round_trip(reading.request, reading.reply)
        if not self._before and self.outcome and expected + wire.latency > self._latest:
            self._current = None
            self._ask_condition(now)
            return False
        self._expected = expected + wire.latency + wire.latency // 4
        self.deadline = min(self._expected + self._patience, self._latest)
        reading.reply.reset()
        self._bad_before = reading.reply.bad_frames
        frames, self._before = self._before + reading.request, b""
        try:
            wire.receive()  # what came too late: no reply is taken for the next one's
            wire.send(frames)
        except BusError:
            self._conclude(reader, reading)
            return False
        return True

    def _conclude(self, reader: Reader, reading: Reading) -> None:
        """Keep what a reading brought."""
        self._current = None
        self.bad_frames += reading.reply.bad_frames - self._bad_before
        for servo, sample, alert in reader.samples(reading):
            self.outcome[servo.slot] = sample
            if sample is None:
                self.lost_replies += 1
                self._deaf.add(servo.slot)
                continue
            self._deaf.discard(servo.slot)
            if alert and not self.alerts.get(servo.slot):
                self.rota.hurry(servo.slot)
            self.alerts[servo.slot] = alert

    def _ask_condition(self, now: int) -> None:
        """Ask one servo for its condition, if the answer can be here before the next tick."""
        probe = self.rota.next(self._deaf) if self.watches else None
        if probe is None:
            return
        due = now + self._wire.round_trip(probe.request, probe.reply) + self._wire.latency + PATIENCE
        if due > self._next_tick:
            return
        probe.reply.reset()
        self._bad_before = probe.reply.bad_frames
        try:
            self._wire.send(probe.request)
        except BusError:
            return
        self._probe, self.deadline = probe, due

    def _await_condition(self, now: int) -> bool:
        """Take the answer about a condition, if one is due; return whether it may still come."""
        probe = self._probe
        if probe is None:
            return False
        try:
            probe.reply.feed(self._wire.receive())
        except BusError:
            self._probe = None
            return False
        if not probe.reply.complete and now < self.deadline:
            return True
        self._probe = None
        self.bad_frames += probe.reply.bad_frames - self._bad_before
        self.rota.note(probe, now)
        return False


def _with_readings(reader: Reader) -> Iterator[tuple[Reader, Reading]]:
    return ((reader, reading) for reading in reader.readings())
