"""What one wire does in a tick: the goals go out, then reads, one after the other, for as long as there is time.

When all that is through and time is left, one servo is asked for its condition. Its answer comes between the ticks.

A tick can spare 1.7 ms in all for servos that keep silent. Once these have passed, what has not been asked yet is
asked first in the next tick.
"""

import contextlib
from collections.abc import Collection, Iterator, Sequence
from itertools import chain

from hal.condition_watch import ConditionWatch
from hal.feedback import Reader, Reading, readers
from hal.goal_writer import GoalWriter
from hal.protocol import ServoProtocol
from hal.wire import Wire
from hal.wired import Wired
from robotwalk.errors import BusError

PATIENCE = 1_700_000  # ns past the time that the bytes take, for servos and adapter
_LEAST_PATIENCE = 300_000  # ns, below which no answer is worth waiting for


class LineCycle:
    """Each tick is `begin`, then `advance` whenever bytes have come or `deadline` has passed, until it returns False.

    Attributes:
        outcome: the samples of this tick (rad, rad/s, share), by the joints' slots; None of those asked in vain.
        watch: the reads of conditions.
        alerts: the slots of servos that reported a fault when they last answered.
        quiet_until: before when the present answer cannot be whole, ns: no need to look.
        deadline: until when it is waited for, ns.
    """

    def __init__(self, wire: Wire, protocol: ServoProtocol, servos: Sequence[Wired]) -> None:
        self.transactions = self.lost_replies = self.bad_frames = 0
        self.quiet_until = self.deadline = 0
        self.outcome: dict[int, tuple[float, float, float] | None] = {}
        self.alerts: set[int] = set()
        self.watch = ConditionWatch(wire, protocol, servos)
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
        return self._first(now)

    def advance(self, now: int) -> bool:
        """Take the bytes that have come, and ask on; return whether more may come.

        A dead port costs its own joints their samples, not the other wires theirs.
        """
        if self._current is None:
            return self._first(now)
        reader, reading = self._current
        try:
            reading.reply.feed(self._wire.receive())
        except BusError:
            self._conclude(reader, reading)
            return False
        if not reading.reply.complete:
            if now < self.deadline:
                return True
            self._patience -= max(now - self._expected, 0)
        self._conclude(reader, reading)
        return self._continue(now)

    def _first(self, now: int) -> bool:
        """Send the first request, unless the answer to the last question of the tick before is still on its way."""
        with contextlib.suppress(BusError):
            data = self._wire.receive()  # what came too late goes: no reply is taken for the next one's
            if self.watch.pending and self.watch.hear(data, now):
                self.quiet_until, self.deadline = now, self.watch.deadline
                return True
        return self._continue(now, drop=False)

    def _continue(self, now: int, *, drop: bool = True) -> bool:
        """Send the next request for which there is time, when what has come too late has been dropped."""
        self._current = next(self._agenda, None) if self._patience >= _LEAST_PATIENCE or self._before else None
        if self._current is None:
            return self._end(now)
        reader, reading = self._current
        wire, frames = self._wire, self._before + reading.request
        expected = now + wire.round_trip(frames, reading.reply)
        if not self._before and self.outcome and expected + wire.latency > self._latest:
            self._current = None
            return self._end(now)
        self.quiet_until = expected
        self._expected = expected + wire.latency + wire.latency // 4
        self.deadline = min(self._expected + self._patience, self._latest)
        reading.reply.reset()
        self._bad_before = reading.reply.bad_frames
        self._before = b""
        try:
            if drop:
                wire.receive()
            wire.send(frames)
        except BusError:
            self._conclude(reader, reading)
            return False
        self.bad_frames += self.watch.digest()  # now that the wire is busy
        return True

    def _end(self, now: int) -> bool:
        with contextlib.suppress(BusError):
            self.watch.ask(now, self._next_tick, self._deaf)
        return False

    def _conclude(self, reader: Reader, reading: Reading) -> None:
        """Keep what a reading brought."""
        self._current = None
        self.bad_frames += reading.reply.bad_frames - self._bad_before
        samples = reader.collect_usual(reading)
        if samples is not None:
            found = dict(samples)
            self.outcome.update(found)
            self._deaf -= found.keys()
            self.alerts -= found.keys()
            return
        for slot, sample, alert in reader.collect(reading):
            self.outcome[slot] = sample
            if sample is None:
                self.lost_replies += 1
                self._deaf.add(slot)
                continue
            self._deaf.discard(slot)
            if not alert:
                self.alerts.discard(slot)
            elif slot not in self.alerts:
                self.alerts.add(slot)
                self.watch.rota.hurry(slot)


def _with_readings(reader: Reader) -> Iterator[tuple[Reader, Reading]]:
    return ((reader, reading) for reading in reader.readings())
