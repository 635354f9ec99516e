"""The vendors' SDKs over a port of ours: they wait instead of spinning, and their faults do not reach us."""

import pytest
import scservo_sdk
from dynamixel_sdk import COMM_RX_TIMEOUT, COMM_SUCCESS, PacketHandler

from hal.maintenance.dynamixel_vendor import DynamixelSdk
from hal.maintenance.feetech_vendor import FeetechSdk
from hal.maintenance.sdk_port import SdkPort
from robotwalk.errors import BusError

from .rig import MS, Chatter, Rig, TickingClock, rig


def sdk(built: Rig, name: str) -> DynamixelSdk | FeetechSdk:
    port = SdkPort(built.port, built.clock)
    return DynamixelSdk(port) if name == "xl430-w250" else FeetechSdk(port)


def test_the_dynamixel_sdk_itself_runs_on_simulated_time() -> None:
    built = rig("xl430-w250", 3)
    assert PacketHandler(2.0).read4ByteTxRx(SdkPort(built.port, built.clock), 3, 132) == (2048, COMM_SUCCESS, 0)
    # 14 bytes there, 15 back, at 10 us each; nothing is waited for.
    assert built.clock.now() == 290_000


def test_the_feetech_sdk_itself_runs_on_simulated_time() -> None:
    built = rig("sts3215", 3)
    handler = scservo_sdk.PacketHandler(0)
    assert handler.read2ByteTxRx(SdkPort(built.port, built.clock), 3, 56) == (2048, scservo_sdk.COMM_SUCCESS, 0)
    assert built.clock.now() == 160_000


def test_the_slots_of_a_broadcast_ping_pass_in_simulated_time() -> None:
    built = rig("xl430-w250", 3, 200)
    found, result = PacketHandler(2.0).broadcastPing(SdkPort(built.port, built.clock))
    assert (found, result) == ({3: [1060, 45], 200: [1060, 45]}, COMM_SUCCESS)


def test_whoever_is_silent_costs_a_bounded_time() -> None:
    built = rig("xl430-w250", 3)
    _, result, _ = PacketHandler(2.0).read4ByteTxRx(SdkPort(built.port, built.clock), 4, 132)
    assert result == COMM_RX_TIMEOUT
    assert built.clock.now() < 160 * MS


@pytest.mark.parametrize("handler", [PacketHandler(2.0), scservo_sdk.protocol_packet_handler()])
@pytest.mark.parametrize("noise", [b"\x55", b"\xff", b"\xff\xff\xfd\x00\x03"])
def test_noise_without_end_comes_to_an_end(handler: object, noise: bytes) -> None:
    clock = TickingClock()
    _, result, _ = handler.readTxRx(SdkPort(Chatter(noise), clock), 3, 56, 2)
    assert result != COMM_SUCCESS
    assert clock.now() < 1000 * MS


def test_a_line_that_breaks_does_not_stay_busy() -> None:
    built = rig("xl430-w250", 3)
    port = SdkPort(built.port, built.clock)
    write = built.port.write

    def broken(data: bytes) -> None:
        raise BusError("the cable is out")

    built.port.write = broken
    with pytest.raises(BusError):
        PacketHandler(2.0).ping(port, 3)
    built.port.write = write
    assert PacketHandler(2.0).ping(port, 3) == (1060, COMM_SUCCESS, 0)


def test_stale_bytes_are_no_answer() -> None:
    built = rig("sts3215", 3)
    port = SdkPort(built.port, built.clock)
    built.port.write(bytes.fromhex("FF FF 03 04 02 05 01 F0"))  # read the id
    built.clock.wait((), 5 * MS)
    assert scservo_sdk.PacketHandler(0).read2ByteTxRx(port, 3, 56) == (2048, scservo_sdk.COMM_SUCCESS, 0)


@pytest.mark.parametrize("value", [
    b"\xff\xff\xfd\xff",  # -131073: would be a header's beginning
    b"\xff\xfd\xff\xff",
    b"\x01\xff\xff\xfd",
])
def test_a_value_that_needs_stuffing_goes_there_and_back(value: bytes) -> None:
    built = rig("xl430-w250", 3)
    vendor = sdk(built, "xl430-w250")
    vendor.write(3, 112, b"\x00\x00\x00\x00")
    built.servos[0].table.check = lambda address, data: []  # take anything
    built.servos[0].table.data[112:116] = value
    assert vendor.read(3, 112, 4) == value
    built.device.heard.clear()
    vendor.write(3, 112, value)
    assert value.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd") in built.device.heard[0][7:]
    assert b"\xff\xff\xfd\x00" not in built.device.heard[0][4:]


def test_stuffing_is_taken_out_as_it_was_put_in() -> None:
    built = rig("xl430-w250", 3)
    value = b"\xff\xff\xfd\xff\xfd\xfd\x01\x02"  # of this the SDK alone makes one byte less
    built.servos[0].table.data[112:120] = value
    assert sdk(built, "xl430-w250").read(3, 112, 8) == value


def test_another_handler_s_byte_order_is_none_of_our_business() -> None:
    built = rig("sts3215", 3)
    vendor = sdk(built, "sts3215")
    scservo_sdk.PacketHandler(1)
    try:
        assert vendor.read(3, 56, 2) == b"\x00\x08"
    finally:
        scservo_sdk.PacketHandler(0)


@pytest.mark.parametrize("name", ["xl430-w250", "sts3215"])
def test_silence_and_garbage_are_told(name: str) -> None:
    built = rig(name, 3)
    vendor = sdk(built, name)
    with pytest.raises(BusError, match="id 4: there is no status packet"):
        vendor.read(4, 0, 2)
    built.device.tamper = lambda sent, replies: [reply._replace(data=reply.data[:-1] + b"\x00") for reply in replies]
    with pytest.raises(BusError, match="id 3: incorrect status packet"):
        vendor.read(3, 40, 1)
