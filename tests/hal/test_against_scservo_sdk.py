"""Our frames against the bytes that Feetech's feetech-servo-sdk 1.0.0 sends, and two of its faults."""

from collections.abc import Iterator

import pytest
from scservo_sdk import COMM_SUCCESS, GroupSyncRead, GroupSyncWrite, PacketHandler

from hal import feetech_protocol as protocol
from hal.encoding import pack
from hal.protocol import Status
from hal.protocols import protocol_of
from hal.register_map import ServoModel
from robotwalk.assembly import load_servo


class Port:
    """What the SDK needs of a port: keeps what is written; answers `answer`, then falls silent."""

    def __init__(self) -> None:
        self.is_using = False
        self.written = b""
        self.answer = b""

    def clearPort(self) -> None:
        pass

    def writePort(self, packet: list[int]) -> int:
        self.written += bytes(packet)
        return len(packet)

    def readPort(self, length: int) -> bytes:
        data, self.answer = self.answer[:length], self.answer[length:]
        return data

    def setPacketTimeout(self, packet_length: int) -> None:
        pass

    def isPacketTimeout(self) -> bool:
        return not self.answer


@pytest.fixture
def port() -> Port:
    return Port()


@pytest.fixture
def handler() -> Iterator[object]:
    """A handler for STS. Its byte order is the whole process's, so it is put right again afterwards."""
    yield PacketHandler(0)
    PacketHandler(0)


@pytest.mark.parametrize("servo_id", [0, 1, 253])
class TestUnicast:
    def test_ping(self, port: Port, handler: PacketHandler, servo_id: int) -> None:
        handler.ping(port, servo_id)
        assert protocol.ping(servo_id) == port.written

    @pytest.mark.parametrize(("address", "length"), [(3, 2), (56, 8), (56, 15), (0, 87)])
    def test_read(self, port: Port, handler: PacketHandler, servo_id: int, address: int, length: int) -> None:
        handler.readTx(port, servo_id, address, length)
        assert protocol.read(servo_id, address, length) == port.written

    @pytest.mark.parametrize(("address", "data"), [(40, b"\x01"), (42, b"\xff\xff"), (41, bytes(range(7)))])
    def test_write(self, port: Port, handler: PacketHandler, servo_id: int, address: int, data: bytes) -> None:
        handler.writeTxOnly(port, servo_id, address, len(data), list(data))
        assert protocol.write(servo_id, address, data) == port.written

    def test_reg_write(self, port: Port, handler: PacketHandler, servo_id: int) -> None:
        handler.regWriteTxOnly(port, servo_id, 42, 6, [0, 8, 0, 0, 0xE8, 3])
        assert protocol.reg_write(servo_id, 42, b"\x00\x08\x00\x00\xe8\x03") == port.written

    def test_action(self, port: Port, handler: PacketHandler, servo_id: int) -> None:
        handler.action(port, servo_id)
        assert protocol.action(servo_id) == port.written


@pytest.mark.parametrize("ids", [(5,), (3, 1, 2), tuple(range(1, 19))])
class TestGroups:
    @pytest.mark.parametrize("length", [6, 8, 15])
    def test_sync_read(self, port: Port, handler: PacketHandler, ids: tuple[int, ...], length: int) -> None:
        group = GroupSyncRead(port, handler, 56, length)
        for servo_id in ids:
            assert group.addParam(servo_id)
        group.txPacket()
        assert protocol.sync_read(56, length, ids) == port.written

    def test_sync_write(self, port: Port, handler: PacketHandler, ids: tuple[int, ...]) -> None:
        group = GroupSyncWrite(port, handler, 42, 2)
        items = [(servo_id, bytes((servo_id, 8))) for servo_id in ids]
        for servo_id, data in items:
            assert group.addParam(servo_id, list(data))
        group.txPacket()
        assert protocol.sync_write(42, 2, items) == port.written


@pytest.mark.parametrize(("fits", "servos"), [(True, 30), (False, 31)])
def test_the_sdk_sends_no_more_servos_in_a_frame_than_we_do(
    port: Port, handler: PacketHandler, fits: bool, servos: int
) -> None:
    group = GroupSyncWrite(port, handler, 41, 7)
    items = [(servo_id, bytes(range(1, 8))) for servo_id in range(servos)]
    for servo_id, data in items:
        group.addParam(servo_id, list(data))
    group.txPacket()
    if fits:
        assert protocol.sync_write(41, 7, items) == port.written
    else:
        assert port.written == b""
        with pytest.raises(ValueError, match="30 servos fit"):
            protocol.sync_write(41, 7, items)


@pytest.mark.parametrize(("name", "value"), [("goal_position", 700), ("goal_velocity", 1500), ("max_torque_limit", 1)])
@pytest.mark.parametrize(("end", "model"), [(0, load_servo("sts3215")), (1, load_servo("scs15"))], ids=["sts", "scs"])
def test_a_word_goes_out_as_the_sdk_sends_it(
    port: Port, handler: PacketHandler, end: int, model: ServoModel, name: str, value: int
) -> None:
    """Low byte first to STS servos, high byte first to SCS servos."""
    PacketHandler(end)
    handler.write2ByteTxOnly(port, 3, model[name].address, value)
    assert protocol_of(model).write(3, model[name].address, pack(model[name], value)) == port.written


def test_a_second_handler_turns_the_byte_order_of_the_first_and_ours_has_none(
    port: Port, handler: PacketHandler
) -> None:
    """The SDK keeps the byte order in a module global: one SCS servo makes every STS reading wrong."""
    answer = bytes.fromhex("FF FF 01 04 00 00 08 F2")  # position 2048
    port.answer = answer
    assert handler.read2ByteTxRx(port, 1, 56) == (2048, COMM_SUCCESS, 0)
    PacketHandler(1)
    port.answer = answer
    assert handler.read2ByteTxRx(port, 1, 56) == (8, COMM_SUCCESS, 0)

    [status] = protocol.Receiver().feed(answer)
    assert status.data == b"\x00\x08"


def test_the_sdk_passes_off_old_data_behind_a_silent_servo_and_we_do_not(
    port: Port, handler: PacketHandler
) -> None:
    """It never clears what the last read brought, and its check of the result is commented out."""
    first = bytes.fromhex("FF FF 01 04 00 64 00 96  FF FF 02 04 00 65 00 94  FF FF 03 04 00 66 00 92")
    second = bytes.fromhex("FF FF 01 04 00 C8 00 32")  # servos 2 and 3 are silent
    theirs = GroupSyncRead(port, handler, 56, 2)
    for servo_id in (1, 2, 3):
        theirs.addParam(servo_id)
    for port.answer in (first, second):
        theirs.txRxPacket()
    assert [theirs.isAvailable(servo_id, 56, 2) for servo_id in (1, 2, 3)] == [True, False, True]
    assert theirs.getData(3, 56, 2) == 0x66  # of the first read

    _, ours = protocol.group_read(56, 2, (1, 2, 3), fast=False)
    for answer in (first, second):
        ours.reset()
        ours.feed(answer)
    assert ours.results == {1: Status(1, 0, False, b"\xc8\x00"), 2: None, 3: None}
