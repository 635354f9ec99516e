"""All servos on one wire: single requests to them, and the wire's part in every tick. Any brand."""

from collections.abc import Sequence

from hal.encoding import pack, unpack
from hal.line_cycle import LineCycle
from hal.protocol import ServoProtocol, Status
from hal.register_map import Memory
from hal.wire import Wire
from hal.wired import Wired
from robotwalk.errors import BusError
from robotwalk.ports import BytePort, Clock

_REQUEST_TIMEOUT = 40_000_000  # ns for the reply to a single request; an FTDI adapter holds it back for 16 ms
_TRIES = 3


class ServoLine:
    """One wire, whose servos understand the same frames."""

    def __init__(
        self, name: str, port: BytePort, baud: int, protocol: ServoProtocol, servos: Sequence[Wired]
    ) -> None:
        self.name = name
        self.servos = tuple(servos)
        self.protocol = protocol
        self.wire = Wire(port, baud)
        self.cycle = LineCycle(self.wire, protocol, servos)
        self._receiver = protocol.receiver()

    @property
    def port(self) -> BytePort:
        """The port."""
        return self.wire.port

    @property
    def bad_frames(self) -> int:
        """How many frames came garbled."""
        return self._receiver.bad_frames + self.cycle.bad_frames

    def request(self, clock: Clock, frame: bytes, servo_id: int, size: int | None = None) -> Status | None:
        """Send one instruction and wait for its status; again if none comes in time, and None if none ever does.

        Where the answer's `size` (bytes of data) is known, a late answer to something else does not pass for it.
        """
        for _ in range(_TRIES):
            self.wire.receive()
            self._receiver.reset()
            self.wire.send(frame)
            deadline = clock.now() + _REQUEST_TIMEOUT
            while clock.now() < deadline:
                clock.wait((self.port,), deadline)
                for status in self._receiver.feed(self.wire.receive()):
                    if status.id == servo_id and (size is None or status.error or len(status.data) == size):
                        return status
        return None

    def ping(self, clock: Clock, servo: Wired) -> tuple[Status | None, int]:
        """Ping a servo; return its status and how long it took beyond the bytes' time on the wire, ns."""
        frame = self.protocol.ping(servo.id)
        received, began = self.wire.rx_bytes, clock.now()
        status = self.request(clock, frame, servo.id)
        on_wire = self.wire.duration(len(frame) + self.wire.rx_bytes - received)
        return status, max(clock.now() - began - on_wire, 0)

    def cap_torque(self, share: float, servos: Sequence[Wired]) -> None:
        """Bound the output of servos to a share of the largest. Nobody acknowledges it."""
        frames: dict[tuple[int, int], list[tuple[int, bytes]]] = {}
        for servo in servos:
            register = servo.model[servo.model.cyclic.torque_cap]
            assert register.range is not None
            data = pack(register, round(share * register.range[1]))
            frames.setdefault((register.address, register.size), []).append((servo.id, data))
        for (address, size), items in frames.items():
            self.wire.send(self.protocol.sync_write(address, size, items))

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
        for register in {servo.model["torque_enable"] for servo in self.servos}:
            self.wire.send(self.protocol.write(self.protocol.BROADCAST_ID, register.address, pack(register, 0)))

    def _accepted(self, servo: Wired, status: Status | None, what: str) -> Status:
        who = f"{servo.joint} (id {servo.id}, bus {self.name})"
        if status is None:
            raise BusError(f"{who} does not answer to {what}")
        if status.error:
            raise BusError(f"{who} refuses {what}: {self.protocol.describe_error(status.error)}")
        return status
