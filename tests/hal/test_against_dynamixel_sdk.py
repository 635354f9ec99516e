"""Our frames against the bytes that ROBOTIS's dynamixel-sdk 4.1.0 sends, and two of its faults."""

import pytest
from dynamixel_sdk import GroupBulkRead, GroupBulkWrite, GroupSyncRead, GroupSyncWrite, PacketHandler

from hal import dynamixel_protocol as protocol

handler = PacketHandler(2.0)


class Port:
    """What the SDK needs of a port: keeps what is written; nobody ever answers."""

    def __init__(self) -> None:
        self.is_using = False
        self.written = b""

    def clearPort(self) -> None:
        pass

    def writePort(self, packet: list[int]) -> int:
        self.written += bytes(packet)
        return len(packet)

    def readPort(self, length: int) -> list[int]:
        return []

    def setPacketTimeout(self, packet_length: int) -> None:
        pass

    def isPacketTimeout(self) -> bool:
        return True


@pytest.fixture
def port() -> Port:
    return Port()


@pytest.mark.parametrize("servo_id", [0, 1, 252])
class TestUnicast:
    def test_ping(self, port: Port, servo_id: int) -> None:
        handler.ping(port, servo_id)
        assert protocol.ping(servo_id) == port.written

    @pytest.mark.parametrize(("address", "length"), [(0, 2), (132, 4), (126, 10), (634, 28), (132, 300)])
    def test_read(self, port: Port, servo_id: int, address: int, length: int) -> None:
        handler.readTx(port, servo_id, address, length)
        assert protocol.read(servo_id, address, length) == port.written

    @pytest.mark.parametrize(
        ("address", "data"), [(64, b"\x01"), (116, b"\xff\xff\xff\xff"), (578, bytes(range(56)))]
    )
    def test_write(self, port: Port, servo_id: int, address: int, data: bytes) -> None:
        handler.writeTxOnly(port, servo_id, address, len(data), list(data))
        assert protocol.write(servo_id, address, data) == port.written

    def test_reg_write(self, port: Port, servo_id: int) -> None:
        handler.regWriteTxOnly(port, servo_id, 104, 4, [0xC8, 0, 0, 0])
        assert protocol.reg_write(servo_id, 104, b"\xc8\x00\x00\x00") == port.written

    def test_action(self, port: Port, servo_id: int) -> None:
        handler.action(port, servo_id)
        assert protocol.action(servo_id) == port.written

    def test_reboot(self, port: Port, servo_id: int) -> None:
        handler.reboot(port, servo_id)
        assert protocol.reboot(servo_id) == port.written

    @pytest.mark.parametrize("keep", protocol.Keep)
    def test_factory_reset(self, port: Port, servo_id: int, keep: protocol.Keep) -> None:
        handler.factoryReset(port, servo_id, int(keep))
        assert protocol.factory_reset(servo_id, keep) == port.written

    def test_clear(self, port: Port, servo_id: int) -> None:
        handler.clearMultiTurn(port, servo_id)
        assert protocol.clear(servo_id) == port.written


@pytest.mark.parametrize("ids", [(5,), (3, 1, 2), tuple(range(1, 19))])
class TestGroups:
    def group(self, port: Port, ids: tuple[int, ...]) -> GroupSyncRead:
        group = GroupSyncRead(port, handler, 126, 10)
        for servo_id in ids:
            assert group.addParam(servo_id)
        return group

    def test_sync_read(self, port: Port, ids: tuple[int, ...]) -> None:
        self.group(port, ids).txPacket()
        assert protocol.sync_read(126, 10, ids) == port.written

    def test_fast_sync_read(self, port: Port, ids: tuple[int, ...]) -> None:
        self.group(port, ids).fastSyncReadTxPacket()
        assert protocol.fast_sync_read(126, 10, ids) == port.written

    def test_sync_write(self, port: Port, ids: tuple[int, ...]) -> None:
        group = GroupSyncWrite(port, handler, 116, 4)
        items = [(servo_id, bytes((servo_id, 8, 0, 0))) for servo_id in ids]
        for servo_id, data in items:
            assert group.addParam(servo_id, list(data))
        group.txPacket()
        assert protocol.sync_write(116, 4, items) == port.written


class TestBulk:
    RANGES = ((3, 132, 4), (7, 124, 2), (4, 146, 1), (252, 634, 28))

    @pytest.mark.parametrize("fast", [False, True])
    def test_bulk_read(self, port: Port, fast: bool) -> None:
        group = GroupBulkRead(port, handler)
        for each in self.RANGES:
            assert group.addParam(*each)
        if fast:
            group.fastBulkReadTxPacket()
        else:
            group.txPacket()
        assert protocol.bulk_read(self.RANGES, fast=fast)[0] == port.written

    def test_bulk_write(self, port: Port) -> None:
        group = GroupBulkWrite(port, handler)
        items = [(servo_id, address, bytes(range(length))) for servo_id, address, length in self.RANGES]
        for servo_id, address, data in items:
            assert group.addParam(servo_id, address, len(data), list(data))
        group.txPacket()
        assert protocol.bulk_write(items) == port.written


def test_the_sdk_never_sends_its_stuffing_and_we_do(port: Port) -> None:
    """Its addStuffing returns a new list, which txPacket drops: the servo sees the header of a frame."""
    handler.write4ByteTxOnly(port, 1, 116, 0x00FDFFFF)
    assert port.written[:-2] == bytes.fromhex("FF FF FD 00 01 09 00 03 74 00 FF FF FD 00")

    ours = protocol.write(1, 116, b"\xff\xff\xfd\x00")
    assert ours[:-2] == bytes.fromhex("FF FF FD 00 01 0A 00 03 74 00 FF FF FD FD 00")
    assert ours[-2:] == handler.updateCRC(0, ours, len(ours) - 2).to_bytes(2, "little")


def test_the_sdk_unstuffs_a_byte_too_many_and_we_do_not() -> None:
    """A servo sends FF FF FD FF FD FD with one FD stuffed. The SDK looks back at bytes that it has moved."""
    head = bytes.fromhex("FF FF FD 00 01 0B 00 55 00 FF FF FD FD FF FD FD")
    frame = head + handler.updateCRC(0, head, len(head)).to_bytes(2, "little")

    theirs = bytes(handler.removeStuffing(list(frame)))
    assert theirs[5:14] == bytes.fromhex("09 00 55 00 FF FF FD FF FD")  # five bytes of data, not six

    [status] = protocol.Receiver().feed(frame)
    assert status.data == bytes.fromhex("FF FF FD FF FD FD")
