"""The clients of the tours: the vendors' SDKs, as they are but for the port, and our own protocol modules.

The SDKs' packet handlers and group readers are unchanged: what their methods do not reach goes through their own
`txRxPacket`. Only the port is ours, so that their waits pass in simulated time.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import dynamixel_sdk
import scservo_sdk

from hal import checksum_frames, dynamixel_frames
from hal.maintenance.sdk_port import SdkPort
from hal.protocols import protocol_of

from .tour_bench import MS, TourBench

_BROADCAST = 0xFE
_CONDITIONS = 0x25  # of Protocol 1.0: voltage, heat, overload
_FAULTS = 0x2F  # of Feetech, whose bit 0x10 may mean that torque is on

Ranges = Mapping[int, tuple[int, int]]  # by id: address, length


class Answer(NamedTuple):
    """A status."""

    error: int = 0  # why the servo refuses; 0 if it does not
    alert: bool = False
    data: bytes = b""


DONE = Answer()


class Client(ABC):
    """Speaks to one servo at a time."""

    def __init__(self, bench: TourBench) -> None:
        self.bench = bench

    @abstractmethod
    def instruct(self, servo_id: int, instruction: int, parameters: bytes = b"") -> Answer | None:
        """Send any instruction; return the answer, None if none came or could be understood."""

    @abstractmethod
    def ping(self, servo_id: int) -> bool: ...

    @abstractmethod
    def read(self, servo_id: int, address: int, length: int) -> Answer | None: ...

    @abstractmethod
    def write(self, servo_id: int, address: int, data: bytes) -> Answer | None: ...

    @abstractmethod
    def reg_write(self, servo_id: int, address: int, data: bytes) -> Answer | None: ...

    @abstractmethod
    def sync_write(self, address: int, data: Mapping[int, bytes]) -> None: ...

    @abstractmethod
    def sync_read(self, address: int, length: int, ids: Sequence[int]) -> list[int | None]: ...

    def action(self, servo_id: int) -> Answer | None:
        return self.instruct(servo_id, 0x05)


class DynamixelClient(Client):
    """What only Protocol 2.0 has."""

    @abstractmethod
    def broadcast_ping(self) -> set[int]: ...

    @abstractmethod
    def fast_sync_read(self, address: int, length: int, ids: Sequence[int]) -> list[int | None]: ...

    @abstractmethod
    def bulk_read(self, ranges: Ranges, *, fast: bool) -> list[int | None]: ...

    @abstractmethod
    def bulk_write(self, items: Mapping[int, tuple[int, bytes]]) -> None: ...


class Sdk(Client):
    """What both vendors' handlers have in common."""

    handler: Any
    groups: Any  # the module of the group readers and writers
    head: int  # bytes before the instruction

    def __init__(self, bench: TourBench) -> None:
        super().__init__(bench)
        self.port = SdkPort(bench.port, bench.clock)

    @abstractmethod
    def judged(self, error: int, data: Sequence[int] = ()) -> Answer: ...

    def ping(self, servo_id: int) -> bool:
        return bool(self.handler.ping(self.port, servo_id)[1] == 0)

    def read(self, servo_id: int, address: int, length: int) -> Answer | None:
        data, result, error = self.handler.readTxRx(self.port, servo_id, address, length)
        return None if result else self.judged(error, data)

    def write(self, servo_id: int, address: int, data: bytes) -> Answer | None:
        result, error = self.handler.writeTxRx(self.port, servo_id, address, len(data), list(data))
        return None if result else self.judged(error)

    def reg_write(self, servo_id: int, address: int, data: bytes) -> Answer | None:
        result, error = self.handler.regWriteTxRx(self.port, servo_id, address, len(data), list(data))
        return None if result else self.judged(error)

    def action(self, servo_id: int) -> Answer | None:
        assert self.handler.action(self.port, servo_id) == 0
        self.bench.pass_time(0.005)  # the SDKs wait for no answer; the next call would take it for its own
        return None

    def raw(self, servo_id: int, instruction: int, parameters: bytes, packet: list[int]) -> Answer | None:
        packet[self.head + 1:self.head + 1 + len(parameters)] = parameters
        packet[self.head] = instruction
        received, result, error = self.handler.txRxPacket(self.port, packet)
        return None if result or received is None else self.judged(error)

    def sync_write(self, address: int, data: Mapping[int, bytes]) -> None:
        group = self.groups.GroupSyncWrite(self.port, self.handler, address, len(next(iter(data.values()))))
        for servo_id, each in data.items():
            assert group.addParam(servo_id, list(each))
        assert group.txPacket() == 0
        self.bench.pass_time(0.005)

    def sync_read(self, address: int, length: int, ids: Sequence[int]) -> list[int | None]:
        group = self.groups.GroupSyncRead(self.port, self.handler, address, length)
        for servo_id in ids:
            assert group.addParam(servo_id)
        group.txRxPacket()
        return [
            group.getData(servo_id, address, length) if group.isAvailable(servo_id, address, length) else None
            for servo_id in ids]


class DynamixelSdk2(Sdk, DynamixelClient):
    """dynamixel-sdk, Protocol 2.0."""

    groups, head = dynamixel_sdk, 7

    def __init__(self, bench: TourBench) -> None:
        super().__init__(bench)
        self.handler = dynamixel_sdk.PacketHandler(2.0)

    def judged(self, error: int, data: Sequence[int] = ()) -> Answer:
        # With a refusal, 4.1.0 returns bytes of the CRC as data.
        return Answer(error & 0x7F, bool(error & 0x80), b"" if error & 0x7F else bytes(data))

    def instruct(self, servo_id: int, instruction: int, parameters: bytes = b"") -> Answer | None:
        handler, port = self.handler, self.port
        match instruction, parameters:
            case 0x06, _:
                result, error = handler.factoryReset(port, servo_id, parameters[0])
            case 0x08, _:
                result, error = handler.reboot(port, servo_id)
            case 0x10, b"\x01DXL\x22":
                result, error = handler.clearMultiTurn(port, servo_id)
            case _:
                size = len(parameters) + 3
                return self.raw(servo_id, instruction, parameters, [
                    0, 0, 0, 0, servo_id, size & 0xFF, size >> 8, *[0] * size])
        return None if result or servo_id == _BROADCAST else self.judged(error)

    def broadcast_ping(self) -> set[int]:
        found, result = self.handler.broadcastPing(self.port)
        assert result == 0
        return set(found)

    def fast_sync_read(self, address: int, length: int, ids: Sequence[int]) -> list[int | None]:
        group = dynamixel_sdk.GroupSyncRead(self.port, self.handler, address, length)
        for servo_id in ids:
            assert group.addParam(servo_id)
        group.fastSyncRead()
        return [
            group.getData(servo_id, address, length) if group.isAvailable(servo_id, address, length) else None
            for servo_id in ids]

    def bulk_read(self, ranges: Ranges, *, fast: bool) -> list[int | None]:
        group = dynamixel_sdk.GroupBulkRead(self.port, self.handler)
        for servo_id, each in ranges.items():
            assert group.addParam(servo_id, *each)
        if fast:
            group.fastBulkRead()
        else:
            group.txRxPacket()
        return [
            group.getData(servo_id, *each) if group.isAvailable(servo_id, *each) else None
            for servo_id, each in ranges.items()]

    def bulk_write(self, items: Mapping[int, tuple[int, bytes]]) -> None:
        group = dynamixel_sdk.GroupBulkWrite(self.port, self.handler)
        for servo_id, (address, data) in items.items():
            assert group.addParam(servo_id, address, len(data), list(data))
        assert group.txPacket() == 0
        self.bench.pass_time(0.005)


class ChecksumSdk(Sdk):
    """A handler whose frames end with a checksum."""

    head = 4

    def ping(self, servo_id: int) -> bool:
        return self.instruct(servo_id, 0x01) is not None  # the handlers' own read the model number too

    def instruct(self, servo_id: int, instruction: int, parameters: bytes = b"") -> Answer | None:
        size = len(parameters) + 2
        return self.raw(servo_id, instruction, parameters, [0, 0, servo_id, size, *[0] * size])


class DynamixelSdk1(ChecksumSdk):
    """dynamixel-sdk, Protocol 1.0."""

    groups = dynamixel_sdk

    def __init__(self, bench: TourBench) -> None:
        super().__init__(bench)
        self.handler = dynamixel_sdk.PacketHandler(1.0)

    def judged(self, error: int, data: Sequence[int] = ()) -> Answer:
        return Answer(error & ~_CONDITIONS, bool(error & _CONDITIONS), bytes(data))

    def instruct(self, servo_id: int, instruction: int, parameters: bytes = b"") -> Answer | None:
        if instruction != 0x06:
            return super().instruct(servo_id, instruction, parameters)
        result, error = self.handler.factoryReset(self.port, servo_id)
        return None if result else self.judged(error)


class FeetechSdk(ChecksumSdk):
    """feetech-servo-sdk 1.0.0. Its byte order is the process's: only bytes are dealt in here."""

    groups = scservo_sdk

    def __init__(self, bench: TourBench) -> None:
        super().__init__(bench)
        self.handler = scservo_sdk.protocol_packet_handler()

    def judged(self, error: int, data: Sequence[int] = ()) -> Answer:
        return Answer(0, bool(error & _FAULTS), bytes(data))


class Ours(DynamixelClient):
    """Our protocol modules, of whichever protocol the model speaks."""

    def __init__(self, bench: TourBench) -> None:
        super().__init__(bench)
        self.protocol: Any = protocol_of(bench.model)
        self._frame: Any = (dynamixel_frames if bench.model.frames == "dynamixel-2.0" else checksum_frames).frame
        self._named = {0x05: "action", 0x08: "reboot", 0x0A: "reset_turns", 0x0B: "calibrate"}

    def ask(self, frame: bytes, servo_id: int) -> Answer | None:
        bench, receiver = self.bench, self.protocol.receiver()
        bench.port.read()
        bench.port.write(frame)
        deadline = bench.clock.now() + 40 * MS
        while bench.clock.now() < deadline:
            bench.clock.wait((bench.port,), deadline)
            for status in receiver.feed(bench.port.read()):
                if status.id == servo_id:
                    return Answer(status.error, status.alert, status.data)
        return None

    def instruct(self, servo_id: int, instruction: int, parameters: bytes = b"") -> Answer | None:
        return self.ask(self._built(servo_id, instruction, parameters), servo_id)

    def _built(self, servo_id: int, instruction: int, parameters: bytes) -> bytes:
        """Build the frame, by the function for it if there is one."""
        protocol = self.protocol
        raw: bytes = self._frame(servo_id, instruction, parameters)
        match instruction, parameters:
            case (0x05 | 0x08 | 0x0A | 0x0B), b"" if hasattr(protocol, self._named[instruction]):
                assert getattr(protocol, self._named[instruction])(servo_id) == raw
            case 0x06, b"" if hasattr(protocol, "factory_reset"):
                assert protocol.factory_reset(servo_id) == raw
            case 0x06, b"\x01" | b"\x02" | b"\xff":
                assert protocol.factory_reset(servo_id, protocol.Keep(parameters[0])) == raw
            case 0x10, b"\x01DXL\x22":
                assert protocol.clear(servo_id) == raw
            case 0x20, b"\x01CTRL":
                assert protocol.store_backup(servo_id) == raw
            case 0x20, b"\x02CTRL":
                assert protocol.restore_backup(servo_id) == raw
        return raw

    def ping(self, servo_id: int) -> bool:
        return self.ask(self.protocol.ping(servo_id), servo_id) is not None

    def read(self, servo_id: int, address: int, length: int) -> Answer | None:
        return self.ask(self.protocol.read(servo_id, address, length), servo_id)

    def write(self, servo_id: int, address: int, data: bytes) -> Answer | None:
        return self.ask(self.protocol.write(servo_id, address, data), servo_id)

    def reg_write(self, servo_id: int, address: int, data: bytes) -> Answer | None:
        return self.ask(self.protocol.reg_write(servo_id, address, data), servo_id)

    def sync_write(self, address: int, data: Mapping[int, bytes]) -> None:
        length = len(next(iter(data.values())))
        assert self.ask(self.protocol.sync_write(address, length, data.items()), -1) is None

    def bulk_write(self, items: Mapping[int, tuple[int, bytes]]) -> None:
        assert self.ask(self.protocol.bulk_write([(servo_id, *each) for servo_id, each in items.items()]), -1) is None

    def sync_read(self, address: int, length: int, ids: Sequence[int]) -> list[int | None]:
        return self._group(self.protocol.group_read(address, length, ids, fast=False))

    def fast_sync_read(self, address: int, length: int, ids: Sequence[int]) -> list[int | None]:
        return self._group(self.protocol.group_read(address, length, ids, fast=True))

    def bulk_read(self, ranges: Ranges, *, fast: bool) -> list[int | None]:
        return self._group(self.protocol.bulk_read([(key, *each) for key, each in ranges.items()], fast=fast))

    def broadcast_ping(self) -> set[int]:
        bench, receiver = self.bench, self.protocol.receiver()
        bench.port.write(self.protocol.ping(_BROADCAST))
        deadline, found = bench.clock.now() + 800 * MS, set()
        while bench.clock.now() < deadline:
            bench.clock.wait((bench.port,), deadline)
            found |= {status.id for status in receiver.feed(bench.port.read())}
        return found

    def _group(self, exchange: tuple[bytes, Any]) -> list[int | None]:
        bench, (request, reply) = self.bench, exchange
        bench.port.read()
        bench.port.write(request)
        deadline = bench.clock.now() + 10 * MS
        while bench.clock.now() < deadline and not reply.complete:
            bench.clock.wait((bench.port,), deadline)
            reply.feed(bench.port.read())
        return [
            None if status is None else int.from_bytes(status.data, bench.model["model_number"].byte_order)
            for status in reply.results.values()]
