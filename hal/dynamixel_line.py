"""All Dynamixel servos on one wire: the frames of the cyclic exchange, and single requests."""

from collections.abc import Iterator, Sequence
from struct import Struct
from typing import NamedTuple

from hal import bus_plan
from hal import dynamixel_protocol as protocol
from hal.calibration import Calibration
from hal.dynamixel_protocol import FastSyncReply, Receiver, Status
from hal.encoding import pack
from hal.register_map import Register, ServoModel
from robotwalk.errors import BusError
from robotwalk.ports import BytePort, Clock

_NS = 1_000_000_000
_REQUEST_TIMEOUT = 20_000_000  # ns for the reply to a single request, an adapter's latency included
_REPLY_MARGIN = 2_000_000  # ns past the wire time, for servos and adapter
_FORMATS = {(1, False): "B", (1, True): "b", (2, False): "H", (2, True): "h", (4, False): "I", (4, True): "i"}


class Wired(NamedTuple):
    """A servo and the joint that it moves."""

    joint: str
    slot: int  # in the robot's joint order
    id: int
    model: ServoModel
    calibration: Calibration


class Sample(NamedTuple):
    """What one servo reported."""

    slot: int  # of its joint
    position: float  # rad
    velocity: float  # rad/s
    effort: float  # share of the largest output


class DynamixelLine:
    """One wire, whose servos share one model's register layout.

    Each cycle is `begin`, then `collect` whenever bytes have come, until `complete` or past `deadline`.
    """

    def __init__(self, name: str, port: BytePort, baud: int, servos: Sequence[Wired]) -> None:
        self.name = name
        self.port = port
        self.servos = tuple(servos)
        self.tx_bytes = self.rx_bytes = self.transactions = self.lost_replies = 0
        self.alerts: set[str] = set()  # joints whose last reply carried the alert bit
        self.deadline = 0
        self._baud = baud
        self._corrupt_replies = 0
        model = servos[0].model
        self._goal = model[model.cyclic.goal]
        self._layout = _Feedback(model)
        self._ids = tuple(servo.id for servo in servos)
        self._receiver = Receiver()
        self._statuses: dict[int, Status] = {}
        self._joint_reply: FastSyncReply | None = None
        self.read_fast(False)

    @property
    def bad_frames(self) -> int:
        """How many frames came garbled."""
        return self._receiver.bad_frames + self._corrupt_replies

    def read_fast(self, fast: bool) -> None:
        """Choose the cyclic read: one joint reply of all servos, or one reply each."""
        make = protocol.fast_sync_read if fast else protocol.sync_read
        self._read_request = make(self._layout.address, self._layout.size, self._ids)
        self._joint_reply = FastSyncReply(self._ids, self._layout.size) if fast else None
        plan = bus_plan.dynamixel(len(self._ids), self._goal.size, self._layout.size, fast=fast)
        self._wire_ns = round(bus_plan.wire_seconds(plan, self._baud) * _NS)

    def begin(self, goals: Sequence[float] | None, now: int) -> None:
        """Write the goals (rad, in the robot's joint order), if any, and ask for everybody's state."""
        self._drop_stale()
        self._statuses = {}
        if self._joint_reply is not None:
            self._joint_reply.reset()
        self._send((self._goal_frame(goals) if goals is not None else b"") + self._read_request)
        self.transactions += 1
        self.deadline = now + self._wire_ns + _REPLY_MARGIN

    def collect(self) -> None:
        """Take the bytes that have come."""
        data = self.port.read()
        self.rx_bytes += len(data)
        if self._joint_reply is not None:
            self._joint_reply.feed(data)
        else:
            self._statuses.update((status.id, status) for status in self._receiver.feed(data))

    @property
    def complete(self) -> bool:
        """Whether everybody has answered."""
        if self._joint_reply is not None:
            return self._joint_reply.complete
        return len(self._statuses) >= len(self._ids)

    def samples(self) -> Iterator[Sample]:
        """Return the samples of this cycle; a servo that did not answer well has none."""
        results = self._statuses
        if self._joint_reply is not None:
            self._corrupt_replies += self._joint_reply.corrupt
            results = {i: status for i, status in self._joint_reply.results.items() if status is not None}
        heard = 0
        for servo in self.servos:
            status = results.get(servo.id)
            if status is None or status.error or len(status.data) != self._layout.size:
                continue
            heard += 1
            if status.alert:
                self.alerts.add(servo.joint)
            yield self._layout.sample(servo, status.data)
        self.lost_replies += len(self.servos) - heard

    def request(self, clock: Clock, frame: bytes, servo_id: int) -> Status | None:
        """Send one instruction and wait for its status; None if none comes in time."""
        self._drop_stale()
        self._send(frame)
        deadline = clock.now() + _REQUEST_TIMEOUT
        while clock.now() < deadline:
            clock.wait((self.port,), deadline)
            data = self.port.read()
            self.rx_bytes += len(data)
            for status in self._receiver.feed(data):
                if status.id == servo_id:
                    return status
        return None

    def write_register(self, clock: Clock, servo: Wired, name: str, value: int) -> None:
        """Write one register of one servo.

        Raises:
            BusError: the servo does not answer or refuses.
        """
        register = servo.model[name]
        status = self.request(clock, protocol.write(servo.id, register.address, pack(register, value)), servo.id)
        if status is None:
            raise BusError(f"{servo.joint} (id {servo.id}, bus {self.name}) does not answer a write to {name}")
        if status.error:
            reason = protocol.describe_error(status.error)
            raise BusError(f"{servo.joint} (id {servo.id}, bus {self.name}) refuses {name} = {value}: {reason}")

    def broadcast_torque_off(self) -> None:
        """Switch off the torque of all servos, without waiting for anything."""
        register = self.servos[0].model["torque_enable"]
        self._send(protocol.write(protocol.BROADCAST_ID, register.address, pack(register, 0)))

    def _goal_frame(self, goals: Sequence[float]) -> bytes:
        goal = self._goal
        items = [
            (servo.id, pack(goal, servo.calibration.ticks(goals[servo.slot]))) for servo in self.servos]
        return protocol.sync_write(goal.address, goal.size, items)

    def _drop_stale(self) -> None:
        """Throw away what came too late, so that no reply is taken for the next one's."""
        self.rx_bytes += len(self.port.read())
        self._receiver.reset()

    def _send(self, frame: bytes) -> None:
        self.tx_bytes += len(frame)
        self.port.write(frame)


class _Feedback:
    """The block of registers that is read in every cycle, and what it says."""

    def __init__(self, model: ServoModel) -> None:
        cyclic, in_order = model.cyclic, model.feedback
        self.address = in_order[0].address
        self.size = in_order[-1].end - self.address
        self._struct = Struct("<" + "".join(_padded(in_order)))
        names = [register.name for register in in_order]
        self._effort = names.index(cyclic.effort)
        self._velocity = names.index(cyclic.velocity)
        self._position = names.index(cyclic.position)
        self._effort_scale = 1.0 / cyclic.effort_full_scale
        self._speed_scale = model[cyclic.velocity].si_scale

    def sample(self, servo: Wired, data: bytes) -> Sample:
        """Convert a servo's block to the joint's SI units."""
        values = self._struct.unpack(data)
        calibration = servo.calibration
        return Sample(
            servo.slot,
            calibration.angle(values[self._position]),
            calibration.speed(values[self._velocity], self._speed_scale),
            calibration.direction * values[self._effort] * self._effort_scale,
        )


def _padded(registers: Sequence[Register]) -> Iterator[str]:
    """Return the format of each register, with pad bytes where they do not adjoin."""
    end = registers[0].address
    for register in registers:
        yield "x" * (register.address - end) + _FORMATS[register.size, register.signed]
        end = register.end
