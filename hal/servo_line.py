"""All servos on one wire: single requests to them, and the wire's part in every tick. Any brand."""

from collections.abc import Sequence, Set

from hal.encoding import pack, unpack
from hal.line_cycle import LineCycle
from hal.protocol import ServoProtocol, Status
from hal.watchdog import Watchdogs
from hal.wire import Wire
from hal.wired import Wired
from robotwalk.errors import BusError
from robotwalk.ports import BytePort, Clock

_REQUEST_TIMEOUT = 40_000_000  # ns for the reply to a single request; an FTDI adapter holds it back for 16 ms
_TRIES = 5


class ServoLine:
    """One wire, whose servos understand the same frames.

    Attributes:
        reseeded: slots of those that the last goals sent to where they are.
    """

    def __init__(
        self, name: str, port: BytePort, baud: int, protocol: ServoProtocol, servos: Sequence[Wired]
    ) -> None:
        self.name = name
        self.servos = tuple(servos)
        self.slots = tuple(servo.slot for servo in servos)
        self.protocol = protocol
        self.wire = Wire(port, baud)
        self.cycle = LineCycle(self.wire, protocol, servos)
        self.watchdogs = Watchdogs(protocol, servos)
        self.reseeded: tuple[int, ...] = ()
        self._receiver = protocol.receiver()

    @property
    def port(self) -> BytePort:
        """The port."""
        return self.wire.port

    @property
    def bad_frames(self) -> int:
        """How many frames came garbled."""
        return self._receiver.bad_frames + self.cycle.bad_frames

    def goal_frames(self, goals: Sequence[float] | None, position: Sequence[float]) -> bytes:
        """Return what writes the goals, if any, and arms the watchdogs that are due.

        Whose watchdog has tripped, or may have, is sent to where it is, in this one tick; so is, all the time, who is
        being brought back.

        Args:
            goals: rad, in the robot's joint order.
            position: where the joints were last measured.

        Raises:
            ValueError: a goal is NaN or infinite.
        """
        tripped = self.cycle.watch.rota.tripped
        there = tripped | self.reviving if self.reviving else tripped
        self.reseeded = tuple(there)
        if goals is None or not (there or self.watchdogs.due):
            return self.cycle.goal_frames(goals)
        if there:
            goals = [position[slot] if slot in there else goal for slot, goal in enumerate(goals)]
        frames = self.cycle.goal_frames(goals)
        if tripped:
            self.watchdogs.arm_again(tripped)
            self.cycle.watch.rota.rearm()
        return self.watchdogs.armed(frames)

    @property
    def reviving(self) -> Set[int]:
        """The slots of servos that are being brought back, and should hold where they are."""
        errand = self.cycle.watch.errand
        return frozenset() if errand is None else {errand.slot}

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
        if servos:
            self.wire.send(self.cap_frames(share, servos))

    def cap_frames(self, share: float, servos: Sequence[Wired]) -> bytes:
        """Return what bounds the output of servos to a share of the largest."""
        frames: dict[tuple[int, int], list[tuple[int, bytes]]] = {}
        for servo in servos:
            register = servo.model[servo.model.cyclic.torque_cap]
            assert register.range is not None
            data = pack(register, round(share * register.range[1]))
            frames.setdefault((register.address, register.size), []).append((servo.id, data))
        return b"".join(self.protocol.sync_write(*place, items) for place, items in frames.items())

    def read(self, clock: Clock, servo: Wired, address: int, size: int, what: str) -> bytes:
        """Return bytes of a servo's table; `what` they are is for the message.

        Raises:
            BusError: the servo does not answer or refuses.
        """
        frame = self.protocol.read(servo.id, address, size)
        return self._accepted(servo, self.request(clock, frame, servo.id, size), f"a read of {what}").data

    def write(self, clock: Clock, servo: Wired, address: int, data: bytes, what: str) -> None:
        """Write bytes to a servo's table. That it keeps silent is no error: some are set so.

        Raises:
            BusError: the servo refuses.
        """
        status = self.request(clock, self.protocol.write(servo.id, address, data), servo.id, 0)
        if status is not None:
            self._accepted(servo, status, what)

    def read_register(self, clock: Clock, servo: Wired, name: str) -> int:
        """Return a register's counts.

        Raises:
            BusError: the servo does not answer or refuses.
        """
        register = servo.model[name]
        return unpack(register, self.read(clock, servo, register.address, register.size, name))

    def write_register(self, clock: Clock, servo: Wired, name: str, value: int) -> None:
        """Write one register of one servo, in counts, and read it back.

        Raises:
            BusError: the servo does not answer, refuses, or does not keep the value.
        """
        register = servo.model[name]
        self.write(clock, servo, register.address, pack(register, value), f"{name} = {value}")
        after = self.read_register(clock, servo, name)
        if after != value:
            raise BusError(f"{servo} on bus {self.name} did not take {name} = {value}: it is {after}")

    def write_eeprom(self, clock: Clock, servo: Wired, name: str, value: int) -> None:
        """Write a register that outlives power, its lock opened for that, and read it back.

        Raises:
            BusError: the servo does not answer, refuses, or does not keep the value.
        """
        lock = servo.model.lock
        if lock is not None:
            self.write_register(clock, servo, lock.name, 0)
        try:
            self.write_register(clock, servo, name, value)
        finally:
            if lock is not None:
                self.write_register(clock, servo, lock.name, 1)

    def restart(self, clock: Clock, servo: Wired, patience: int) -> None:
        """Start a servo's firmware anew, torque off, and wait up to `patience` ns until it answers again."""
        self.request(clock, self.protocol.reboot(servo.id), servo.id, 0)
        deadline = clock.now() + patience
        while clock.now() < deadline and self.request(clock, self.protocol.ping(servo.id), servo.id) is None:
            pass

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
