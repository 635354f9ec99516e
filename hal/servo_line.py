"""All servos on one wire: the frames of the cyclic exchange, and single requests. Any brand."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from hal import bus_plan
from hal.calibration import Calibration
from hal.encoding import BlockDecoder, pack, unpack
from hal.protocol import GroupReply, ServoProtocol, Status
from hal.register_map import Memory, ServoModel
from robotwalk.errors import BusError
from robotwalk.ports import BytePort, Clock

_NS = 1_000_000_000
_BITS_PER_BYTE = 10
_REQUEST_TIMEOUT = 40_000_000  # ns for the reply to a single request; an FTDI adapter holds it back for 16 ms
_TRIES = 3


class Wired(NamedTuple):
    """A servo and the joint that it moves."""

    joint: str
    limb: str  # whose joints come to power together
    slot: int  # in the robot's joint order
    id: int
    model: ServoModel
    calibration: Calibration
    lower: float  # rad, the joint's limits
    upper: float

    def __str__(self) -> str:
        return f"{self.joint} (id {self.id})"


class Sample(NamedTuple):
    """What one servo reported."""

    slot: int  # of its joint
    position: float  # rad
    velocity: float  # rad/s
    effort: float  # share of the largest output


class ServoLine:
    """One wire, whose servos share one protocol and one register layout.

    Each cycle is `begin`, then `collect` whenever bytes have come, until `complete` or past `deadline`.
    """

    def __init__(
        self, name: str, port: BytePort, baud: int, protocol: ServoProtocol, servos: Sequence[Wired]
    ) -> None:
        self.name = name
        self.port = port
        self.servos = tuple(servos)
        self.protocol = protocol
        self.tx_bytes = self.rx_bytes = self.transactions = self.lost_replies = 0
        self.alerts: list[str] = []  # joints whose servos reported a fault in this cycle
        self.deadline = 0
        self.latency = 0  # ns that a reply takes beyond its time on the wire
        self._baud = baud
        model = servos[0].model
        cyclic = model.cyclic
        self._goal = model[cyclic.goal]
        self._feedback = model.feedback
        self._decoder = BlockDecoder(model.feedback)
        names = [register.name for register in model.feedback.registers]
        self._position, self._velocity = names.index(cyclic.position), names.index(cyclic.velocity)
        self._effort = names.index(cyclic.effort)
        self._speed_scale = model[cyclic.velocity].si_scale
        self._effort_scale = 1.0 / cyclic.effort_full_scale
        self._receiver = protocol.receiver()
        self._bad_before = 0  # frames, counted by replies that are no longer in use
        self._reply: GroupReply | None = None
        self.read_fast(False)

    @property
    def bad_frames(self) -> int:
        """How many frames came garbled."""
        return self._bad_before + self._receiver.bad_frames + self._group.bad_frames

    @property
    def _group(self) -> GroupReply:
        assert self._reply is not None
        return self._reply

    @property
    def wire_ns(self) -> int:
        """How long a cycle's bytes are on the wire, ns."""
        return self._wire_ns

    @property
    def exchange_ns(self) -> int:
        """How long a cycle takes, ns: its bytes, and the adapter's latency."""
        return self._wire_ns + self.latency

    def read_fast(self, fast: bool) -> None:
        """Choose the cyclic read: the protocol's fast form, or one reply each."""
        if self._reply is not None:
            self._bad_before += self._reply.bad_frames
        ids = [servo.id for servo in self.servos]
        self._request, self._reply = self.protocol.group_read(
            self._feedback.address, self._feedback.size, ids, fast=fast)
        plan = bus_plan.cyclic(self.protocol, [servo.model for servo in self.servos], fast=fast)
        self._wire_ns = round(bus_plan.wire_seconds(plan, self._baud) * _NS)

    def frame(self, goals: Sequence[float] | None) -> bytes:
        """Return what writes the goals (rad, in the robot's joint order), if any, and asks for everybody's state.

        Raises:
            ValueError: a goal is NaN or infinite.
        """
        return self._request if goals is None else self._goal_frame(goals) + self._request

    def begin(self, frame: bytes, now: int, margin: int) -> bool:
        """Send a `frame`.

        Answers may come until `margin` ns past the time that the exchange takes. Return whether any may come: a
        dead port costs its own joints their samples, not the other wires theirs.
        """
        self._group.reset()
        self.transactions += 1
        try:
            self._drop_stale()
            self._send(frame)
        except BusError:
            return False
        self.deadline = now + self.exchange_ns + self.latency // 4 + margin
        return True

    def collect(self) -> bool:
        """Take the bytes that have come; return whether more may come."""
        try:
            data = self.port.read()
        except BusError:
            return False
        self.rx_bytes += len(data)
        self._group.feed(data)
        return True

    @property
    def complete(self) -> bool:
        """Whether nothing more will come."""
        return self._group.complete

    def samples(self) -> Iterator[Sample]:
        """Return the samples of this cycle; a servo that did not answer well has none."""
        results, size = self._group.results, self._feedback.size
        self.alerts = []
        for servo in self.servos:
            status = results[servo.id]
            if status is None or status.error or len(status.data) != size:
                self.lost_replies += 1
                continue
            if status.alert:
                self.alerts.append(servo.joint)
            yield self._sample(servo, status.data)

    def request(self, clock: Clock, frame: bytes, servo_id: int, size: int | None = None) -> Status | None:
        """Send one instruction and wait for its status; again if none comes in time, and None if none ever does.

        Where the answer's `size` (bytes of data) is known, a late answer to something else does not pass for it.
        """
        for _ in range(_TRIES):
            self._drop_stale()
            self._send(frame)
            deadline = clock.now() + _REQUEST_TIMEOUT
            while clock.now() < deadline:
                clock.wait((self.port,), deadline)
                data = self.port.read()
                self.rx_bytes += len(data)
                for status in self._receiver.feed(data):
                    if status.id == servo_id and (size is None or status.error or len(status.data) == size):
                        return status
        return None

    def ping(self, clock: Clock, servo: Wired) -> tuple[Status | None, int]:
        """Ping a servo; return its status and how long it took beyond the bytes' time on the wire, ns."""
        frame = self.protocol.ping(servo.id)
        received, began = self.rx_bytes, clock.now()
        status = self.request(clock, frame, servo.id)
        on_wire = (len(frame) + self.rx_bytes - received) * _BITS_PER_BYTE * _NS // self._baud
        return status, max(clock.now() - began - on_wire, 0)

    def cap_torque(self, share: float, servos: Sequence[Wired]) -> None:
        """Bound the output of servos to a share of the largest. Nobody acknowledges it."""
        if not servos:
            return
        register = servos[0].model[servos[0].model.cyclic.torque_cap]
        assert register.range is not None
        data = pack(register, round(share * register.range[1]))
        items = [(servo.id, data) for servo in servos]
        self._send(self.protocol.sync_write(register.address, register.size, items))

    def read_register(self, clock: Clock, servo: Wired, name: str) -> int:
        """Return a register's counts.

        Raises:
            BusError: the servo does not answer or refuses.
        """
        register = servo.model[name]
        frame = self.protocol.read(servo.id, register.address, register.size)
        status = self.request(clock, frame, servo.id, register.size)
        return unpack(register, self._accepted(servo, status, f"a read of {name}").data)

    def write_register(self, clock: Clock, servo: Wired, name: str, value: int) -> None:
        """Write one register of one servo, in counts.

        Raises:
            BusError: the servo does not answer or refuses.
        """
        register = servo.model[name]
        frame = self.protocol.write(servo.id, register.address, pack(register, value))
        self._accepted(servo, self.request(clock, frame, servo.id, 0), f"{name} = {value}")

    def settle(self, clock: Clock, servo: Wired) -> None:
        """See that a servo's settings are those of a position servo without a profile of its own.

        What it forgets without power is written; what it keeps is not ours to change unasked.

        Raises:
            BusError: a setting in its EEPROM is another.
        """
        for name, wanted in servo.model.cyclic.settings.items():
            found = self.read_register(clock, servo, name)
            if found == wanted:
                continue
            if servo.model[name].memory is Memory.EEPROM:
                raise BusError(
                    f"{servo} on bus {self.name} has {name} = {found}; to walk it needs {wanted}: "
                    f"robotwalk servo write {servo.id} {name}={wanted} --raw")
            self.write_register(clock, servo, name, wanted)

    def broadcast_torque_off(self) -> None:
        """Switch off the torque of all servos, without waiting for anything."""
        register = self.servos[0].model["torque_enable"]
        self._send(self.protocol.write(self.protocol.BROADCAST_ID, register.address, pack(register, 0)))

    def _accepted(self, servo: Wired, status: Status | None, what: str) -> Status:
        who = f"{servo.joint} (id {servo.id}, bus {self.name})"
        if status is None:
            raise BusError(f"{who} does not answer to {what}")
        if status.error:
            raise BusError(f"{who} refuses {what}: {self.protocol.describe_error(status.error)}")
        return status

    def _goal_frame(self, goals: Sequence[float]) -> bytes:
        goal = self._goal
        items = [(servo.id, pack(goal, servo.calibration.ticks(goals[servo.slot]))) for servo in self.servos]
        return self.protocol.sync_write(goal.address, goal.size, items)

    def _sample(self, servo: Wired, data: bytes) -> Sample:
        """Convert a servo's feedback to the joint's SI units."""
        values, calibration = self._decoder.unpack(data), servo.calibration
        return Sample(
            servo.slot,
            calibration.angle(values[self._position]),
            calibration.speed(values[self._velocity], self._speed_scale),
            calibration.direction * values[self._effort] * self._effort_scale,
        )

    def _drop_stale(self) -> None:
        """Throw away what came too late, so that no reply is taken for the next one's."""
        self.rx_bytes += len(self.port.read())
        self._receiver.reset()

    def _send(self, frame: bytes) -> None:
        self.tx_bytes += len(frame)
        self.port.write(frame)
