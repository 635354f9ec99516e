"""Who is on a line, at the baud rate that it has.

Where a protocol gives each id a time slot after a broadcast ping, one such ping finds everybody. Elsewhere ids are
pinged one by one, and each gets just the time of its answer; an adapter may hand that over later, so what comes
late still counts. An id about which something was garbled is asked once more, alone.
"""

from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from hal.maintenance.dialects import Dialects
from hal.maintenance.dialogue import Dialogue, Heard
from hal.maintenance.identity import Identity, identify
from hal.protocol import Status

IDS = range(253)
_PING_SIZE, _STATUS_SIZE = 12, 14  # bytes: of a ping and its shortest answer; of the longest answer to a ping
_RETURN_DELAY = 520_000  # ns, the longest that a servo can be set to, and a little
_TURNAROUND = 1_500_000  # ns for a USB adapter that does not hold replies back
_LATE = 20_000_000  # ns after the last ping, for one that does
_HELD_BACK = 10  # ids that may have been pinged since the one whose answer is found to be garbled now
_QUIET = 5_000_000  # ns without a byte, before anybody is asked


class Progress(NamedTuple):
    """How far a scan of one baud rate, in one protocol, has come."""

    protocol: str
    baud: int
    share: float


class Clash(NamedTuple):
    """An id whose answers show that something is wrong."""

    id: int
    protocol: str
    baud: int

    def __str__(self) -> str:
        return (
            f"id {self.id} at {self.baud} baud ({self.protocol}) answers twice or garbled: two servos have that id, "
            "or a cable is loose. Connect one of them alone and give it another id")


class Noise(NamedTuple):
    """Bytes that come though nobody was asked."""

    baud: int

    def __str__(self) -> str:
        return f"at {self.baud} baud bytes come though nobody was asked: something else talks, or the line floats"


Finding = Progress | Identity | Clash | Noise


def scan(dialects: Dialects) -> Iterator[Finding]:
    """Look for servos of known models that sound alike, at the baud rate that the port has."""
    dialogue = dialects.any
    protocol, baud = dialects.name, dialogue.port.baud
    yield Progress(protocol, baud, 0.0)
    dialogue.port.read()
    if dialogue.listen(_QUIET).garbled:
        yield Noise(baud)
        return
    roll = _RollCall(dialogue)
    slot = dialogue.protocol.PING_SLOT_NS
    if slot is not None:
        roll.ask_everybody(slot)
    if slot is None or roll.garbled:
        for servo_id in roll.ask_each():
            yield Progress(protocol, baud, servo_id / len(IDS))
    roll.ask_suspects()
    for servo_id in sorted(roll.clashes | set(roll.statuses)):
        if servo_id in roll.clashes:
            yield Clash(servo_id, protocol, baud)
        else:
            yield identify(dialects, roll.statuses[servo_id])


class _RollCall:
    """Who has answered so far."""

    def __init__(self, dialogue: Dialogue) -> None:
        self.statuses: dict[int, Status] = {}
        self.clashes: set[int] = set()
        self.garbled = False
        self._suspects: set[int] = set()
        self._dialogue = dialogue

    def ask_everybody(self, slot: int) -> None:
        """Ping all at once; hear them for all slots, and longer by what their answers take."""
        dialogue = self._dialogue
        heard = dialogue.exchange(dialogue.protocol.ping(dialogue.protocol.BROADCAST_ID), slot * len(IDS))
        self._note(heard)
        # At a low baud rate answers outlast their slots and push back those behind them.
        while heard.statuses:
            heard = dialogue.listen(dialogue.wire_ns(_STATUS_SIZE * len(heard.statuses)) + _LATE)
            self._note(heard)

    def ask_each(self) -> Iterator[int]:
        """Ping, one by one, the ids that have not answered; yield where it has come to."""
        dialogue = self._dialogue
        duration = dialogue.wire_ns(_PING_SIZE) + _RETURN_DELAY + _TURNAROUND
        for servo_id in [servo_id for servo_id in IDS if servo_id not in self.statuses]:
            dialogue.port.write(dialogue.protocol.ping(servo_id))
            self._note(dialogue.listen(duration), servo_id)
            yield servo_id
        self._note(dialogue.listen(_LATE), IDS[-1])

    def ask_suspects(self) -> None:
        """Ping each id again of which something doubtful was heard."""
        for servo_id in sorted(self._suspects):
            heard = self._dialogue.ping(servo_id)
            if heard.alone(servo_id):
                self.statuses[servo_id] = heard.statuses[0]
            elif not heard.silent:
                self.clashes.add(servo_id)

    def _note(self, heard: Heard, pinged: int | None = None) -> None:
        self.garbled |= heard.garbled
        if heard.garbled and pinged is not None:
            self._suspects.update(range(max(0, pinged - _HELD_BACK), pinged + 1))
        counts = Counter(status.id for status in heard.statuses)
        self._suspects.update(servo_id for servo_id in counts if counts[servo_id] > 1 or servo_id in self.statuses)
        self.statuses |= {status.id: status for status in heard.statuses}
