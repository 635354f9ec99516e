"""Requests to single servos, one at a time: who answers, and in what way nobody does."""

from collections.abc import Collection
from typing import NamedTuple

from hal.protocol import ServoProtocol, Status
from hal.tunable_port import TunablePort
from robotwalk.errors import BusError, ServoError
from robotwalk.ports import Clock

_NS = 1_000_000_000
_BITS_PER_BYTE = 10  # 8N1
_FRAME = 16  # bytes around the data of a status, stuffing among it included
_PATIENCE = 40_000_000  # ns beyond the wire time; an FTDI adapter holds a reply back for 16 ms
_WRITE_PATIENCE = 150_000_000  # ns; Feetech's EEPROM is reported to take more than 21 ms
_SECOND_ANSWER = 5_000_000  # ns after a ping's answer: two servos with one id do not always collide
_ATTEMPTS = 3  # at reading
_FILLER = bytes(2048)  # longer than any frame, and no part of one


class NoAnswerError(BusError):
    """The line is there; a servo is silent, or what it says is garbled."""


class Heard(NamedTuple):
    """What came back."""

    statuses: tuple[Status, ...] = ()
    garbled: bool = False  # whether bytes came that are no status
    took: int = 0  # ns

    @property
    def silent(self) -> bool:
        """Whether nothing came."""
        return not self.statuses and not self.garbled

    def alone(self, servo_id: int) -> bool:
        """Tell whether this id answered once and nothing else came."""
        return not self.garbled and [status.id for status in self.statuses] == [servo_id]

    def of(self, servo_id: int) -> Status | None:
        """Return the first status of an id."""
        return next((status for status in self.statuses if status.id == servo_id), None)


class Dialogue:
    """Speaks one protocol on a line that nobody else uses meanwhile."""

    def __init__(self, port: TunablePort, clock: Clock, protocol: ServoProtocol) -> None:
        self.port = port
        self.clock = clock
        self.protocol = protocol
        self._receiver = protocol.receiver()

    def exchange(self, frame: bytes, patience: int, size: int = 0, until: Collection[int] = ()) -> Heard:
        """Send a frame and hear what comes, for the time that `size` bytes of data take and `patience` ns.

        A status of one of the ids `until` ends it at once.
        """
        self.send(frame)
        return self.listen(self.wire_ns(len(frame) + _FRAME + size) + patience, until)

    def send(self, frame: bytes) -> None:
        """Send a frame; what came before is thrown away, so that no reply is taken for the next one's."""
        self.port.read()
        self._receiver.reset()
        self.port.write(frame)

    def listen(self, duration: int, until: Collection[int] = ()) -> Heard:
        """Hear what comes within so many ns. If nothing does, a frame that had begun before counts as broken off."""
        began = self.clock.now()
        deadline = began + duration
        statuses: list[Status] = []
        received, bad = 0, self._receiver.bad_frames
        while self.clock.now() < deadline:
            self.clock.wait((self.port,), deadline)
            data = self.port.read()
            received += len(data)
            new = self._receiver.feed(data)
            statuses += new
            if any(status.id in until for status in new):
                break
        if not received:
            # What lies behind a garbled length would wait for ever.
            statuses += self._receiver.feed(_FILLER)
        garbled = self._receiver.bad_frames > bad or (received > 0 and not statuses)
        return Heard(tuple(statuses), garbled, self.clock.now() - began)

    def wire_ns(self, size: int) -> int:
        """Return how long so many bytes take on the wire, ns."""
        return size * _BITS_PER_BYTE * _NS // self.port.baud

    def ping(self, servo_id: int, patience: int = _PATIENCE) -> Heard:
        """Ping one servo, and hear it out."""
        return self.ask(self.protocol.ping(servo_id), servo_id, patience=patience)

    def ask(self, frame: bytes, servo_id: int, size: int = 0, patience: int = _PATIENCE) -> Heard:
        """Ask one servo, once. Whatever follows its answer is heard too, for it may be another's."""
        heard = self.exchange(frame, patience, size, until=(servo_id,))
        if not heard.of(servo_id):
            return heard
        more = self.listen(self.wire_ns(_FRAME + size) + _SECOND_ANSWER)
        return Heard(heard.statuses + more.statuses, heard.garbled or more.garbled, heard.took)

    def read(self, servo_id: int, address: int, size: int) -> bytes:
        """Return `size` bytes of a servo's table. Asks again if it must.

        Raises:
            NoAnswerError: the servo is silent, or its answers are garbled.
            ServoError: it refuses.
        """
        heard = Heard()
        for _ in range(_ATTEMPTS):
            heard = self.exchange(self.protocol.read(servo_id, address, size), _PATIENCE, size, (servo_id,))
            status = heard.of(servo_id)
            if status and status.error:
                raise self._refusal(servo_id, status)
            if status and len(status.data) == size:
                return status.data
        raise self.nobody(servo_id, heard)

    def write(self, servo_id: int, address: int, data: bytes) -> None:
        """Write to a servo's table. That it is silent is no error: some are set so. Read back to be sure.

        Raises:
            ServoError: it refuses.
        """
        frame = self.protocol.write(servo_id, address, data)
        status = self.exchange(frame, _WRITE_PATIENCE, until=(servo_id,)).of(servo_id)
        if status and status.error:
            raise self._refusal(servo_id, status)

    def nobody(self, servo_id: int, heard: Heard) -> NoAnswerError:
        """Return the error that says why there is no answer."""
        if heard.garbled or heard.of(servo_id):
            return NoAnswerError(
                f"what comes back from id {servo_id} at {self.port.baud} baud is garbled: two servos with one id, "
                "a loose cable, or a wrong baud rate")
        return NoAnswerError(
            f"no servo answers as id {servo_id} at {self.port.baud} baud; `robotwalk servo scan` tries all baud rates")

    def _refusal(self, servo_id: int, status: Status) -> ServoError:
        return ServoError(f"id {servo_id} refuses: {self.protocol.describe_error(status.error)}")
