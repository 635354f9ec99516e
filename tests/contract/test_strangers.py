"""Clients that nobody here wrote, unchanged, on the simulated robot's pseudo-terminal."""

import math
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import dynamixel_sdk
import pytest
import scservo_sdk

from ..device import last_truth, served

pytestmark = pytest.mark.xdist_group("strangers")

rustypot = pytest.importorskip("rustypot", reason="rustypot is not installed")
TICK = math.tau / 4096


class Device:
    """The URL of the one bus `legs`, and the truth behind it."""

    def __init__(self, url: str, truth: Path) -> None:
        self.url, self._truth = url, truth

    def joint(self, name: str) -> float:
        """Return where a joint really is, rad."""
        return float(last_truth(self._truth)["joints"][name])


@pytest.fixture(scope="module")
def hexapod(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Device]:
    folder = tmp_path_factory.mktemp("hexapod")
    with served("hexapod", "--pty", str(folder), "--truth", str(folder / "truth")) as urls:
        yield Device(urls["legs"], folder / "truth")


@pytest.fixture(scope="module")
def quadruped(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Device]:
    folder = tmp_path_factory.mktemp("quadruped")
    with served("quadruped", "--pty", str(folder), "--truth", str(folder / "truth")) as urls:
        yield Device(urls["legs"], folder / "truth")


@pytest.fixture
def dynamixel(hexapod: Device) -> Iterator[dynamixel_sdk.PortHandler]:
    port = dynamixel_sdk.PortHandler(hexapod.url)
    assert port.openPort()
    assert port.setBaudRate(1_000_000)
    yield port
    port.closePort()


@pytest.fixture
def feetech(quadruped: Device) -> Iterator[scservo_sdk.PortHandler]:
    port = scservo_sdk.PortHandler(quadruped.url)
    assert port.openPort()
    assert port.setBaudRate(1_000_000)
    yield port
    port.closePort()


class TestDynamixelSdk:
    handler = dynamixel_sdk.PacketHandler(2.0)

    def test_ping_and_broadcast_ping(self, dynamixel: dynamixel_sdk.PortHandler) -> None:
        assert self.handler.ping(dynamixel, 7) == (1060, 0, 0)
        found, result = self.handler.broadcastPing(dynamixel)
        assert result == 0
        assert found == {servo: [1060, 45] for servo in range(1, 19)}

    def test_wrong_requests_get_the_manuals_errors(self, dynamixel: dynamixel_sdk.PortHandler) -> None:
        write = self.handler
        assert write.write1ByteTxRx(dynamixel, 1, 146, 1) == (0, 7), "read-only: access error"
        assert write.write1ByteTxRx(dynamixel, 1, 11, 2) == (0, 4), "no such mode: data range error"
        assert write.write2ByteTxRx(dynamixel, 1, 116, 2048) == (0, 5), "half a register: data length error"
        assert write.write4ByteTxRx(dynamixel, 1, 116, 5000) == (0, 6), "past the limits: data limit error"
        assert write.action(dynamixel, 1) == 0
        time.sleep(0.05)  # the SDK does not wait for the answer, error 2: nothing was registered
        assert write.write1ByteTxRx(dynamixel, 1, 64, 1) == (0, 0)
        assert write.write1ByteTxRx(dynamixel, 1, 9, 0) == (0, 7), "EEPROM while torque is on: access error"
        assert write.write1ByteTxRx(dynamixel, 1, 64, 0) == (0, 0)

    @pytest.mark.parametrize("fast", [False, True])
    def test_a_joint_commanded_moves_in_the_physics_and_reads_back_moved(
        self, hexapod: Device, dynamixel: dynamixel_sdk.PortHandler, fast: bool
    ) -> None:
        position, result, error = self.handler.read4ByteTxRx(dynamixel, 4, 132)
        assert (result, error) == (0, 0)
        before = hexapod.joint("lm_coxa")
        goal = position + 150
        writer = dynamixel_sdk.GroupSyncWrite(dynamixel, self.handler, 116, 4)
        writer.addParam(4, list(goal.to_bytes(4, "little")))
        assert writer.txPacket() == 0
        assert self.handler.write1ByteTxRx(dynamixel, 4, 64, 1) == (0, 0)
        assert writer.txPacket() == 0
        time.sleep(1.0)
        reader = dynamixel_sdk.GroupSyncRead(dynamixel, self.handler, 132, 4)
        for servo in range(1, 19):
            reader.addParam(servo)
        assert (reader.fastSyncRead() if fast else reader.txRxPacket()) == 0
        assert reader.getData(4, 132, 4) == pytest.approx(goal, abs=25)
        assert hexapod.joint("lm_coxa") - before == pytest.approx(150 * TICK, abs=0.05)
        assert self.handler.write1ByteTxRx(dynamixel, 4, 64, 0) == (0, 0)

    def test_reboot(self, dynamixel: dynamixel_sdk.PortHandler) -> None:
        assert self.handler.write1ByteTxRx(dynamixel, 9, 65, 1) == (0, 0)
        assert self.handler.reboot(dynamixel, 9) == (0, 0)
        assert self.handler.ping(dynamixel, 9)[1] != 0, "it is away"
        time.sleep(0.5)
        assert self.handler.ping(dynamixel, 9) == (1060, 0, 0)
        assert self.handler.read1ByteTxRx(dynamixel, 9, 65) == (0, 0, 0), "RAM is at its defaults"


class TestFeetechSdk:
    def test_ping_read_and_write(self, feetech: scservo_sdk.PortHandler) -> None:
        handler = scservo_sdk.PacketHandler(0)
        assert handler.ping(feetech, 5) == (777, 0, 0)
        assert handler.ping(feetech, 50)[1] != 0
        assert handler.read2ByteTxRx(feetech, 5, 3) == (777, 0, 0)
        assert handler.write1ByteTxRx(feetech, 5, 41, 50) == (0, 0)
        assert handler.read1ByteTxRx(feetech, 5, 41) == (50, 0, 0)
        assert handler.write1ByteTxRx(feetech, 5, 41, 0) == (0, 0)

    def test_a_joint_commanded_moves_and_reads_back_moved(
        self, quadruped: Device, feetech: scservo_sdk.PortHandler
    ) -> None:
        handler = scservo_sdk.PacketHandler(0)
        position, result, _ = handler.read2ByteTxRx(feetech, 1, 56)
        assert result == 0
        goal, before = position + 80, quadruped.joint("lf_hip")
        writer = scservo_sdk.GroupSyncWrite(feetech, handler, 42, 2)
        writer.addParam(1, list(goal.to_bytes(2, "little")))
        assert writer.txPacket() == 0
        assert handler.write1ByteTxRx(feetech, 1, 40, 1) == (0, 0)
        time.sleep(1.0)
        reader = scservo_sdk.GroupSyncRead(feetech, handler, 56, 8)
        for servo in range(1, 13):
            reader.addParam(servo)
        assert reader.txRxPacket() == 0
        assert reader.getData(1, 56, 2) == pytest.approx(goal, abs=20)
        assert abs(quadruped.joint("lf_hip") - before) == pytest.approx(80 * TICK, abs=0.04)
        assert handler.write1ByteTxRx(feetech, 1, 40, 0) == (0, 0)


class TestRustypot:
    def test_dynamixel(self, hexapod: Device) -> None:
        with closing(rustypot.Xl430PyController(hexapod.url, 1_000_000, 0.1)) as robot:
            assert robot.ping(3)
            assert robot.scan(list(range(1, 21))) == dict.fromkeys(range(1, 19), 1060)
            ids = list(range(1, 19))
            robot.set_fast_sync_read(False)
            plain = robot.sync_read_present_position(ids)
            robot.set_fast_sync_read(True)
            assert robot.sync_read_present_position(ids) == pytest.approx(plain, abs=3)
            goal = int(plain[6]) - 120
            before = hexapod.joint("lr_coxa")
            robot.sync_write_goal_position([7], [goal])
            robot.write_torque_enable(7, 1)
            time.sleep(1.0)
            assert robot.read_present_position(7) == pytest.approx([goal], abs=25)
            assert hexapod.joint("lr_coxa") - before == pytest.approx(-120 * TICK, abs=0.05)
            robot.write_torque_enable(7, 0)

    def test_feetech(self, quadruped: Device) -> None:
        with closing(rustypot.Sts3215PyController(quadruped.url, 1_000_000, 0.1)) as robot:
            assert robot.ping(3)
            assert robot.scan(list(range(1, 15))) == dict.fromkeys(range(1, 13), 777)
            ids = list(range(1, 13))
            before = robot.sync_read_raw_present_position(ids)
            joint = quadruped.joint("rf_hip")
            servo = 7  # rf_hip
            robot.sync_write_raw_goal_position([servo], [before[servo - 1] - 60])
            robot.write_torque_enable(servo, True)
            time.sleep(1.0)
            assert robot.read_raw_present_position(servo) == pytest.approx([before[servo - 1] - 60], abs=20)
            assert abs(quadruped.joint("rf_hip") - joint) == pytest.approx(60 * TICK, abs=0.04)
            robot.write_torque_enable(servo, False)


def test_the_crash_of_one_client_leaves_the_device_to_the_next(hexapod: Device) -> None:
    client = textwrap.dedent(f"""
        import serial, time
        port = serial.Serial({hexapod.url!r}, 1_000_000, exclusive=True)
        port.write(bytes.fromhex("fffffd00010300"))  # half a ping
        print("ready", flush=True)
        time.sleep(60)
    """)
    crashing = subprocess.Popen([sys.executable, "-c", client], stdout=subprocess.PIPE, text=True)
    assert crashing.stdout is not None
    assert crashing.stdout.readline() == "ready\n"
    crashing.send_signal(signal.SIGKILL)
    crashing.wait(10)
    time.sleep(0.2)
    port = dynamixel_sdk.PortHandler(hexapod.url)
    assert port.openPort()
    assert dynamixel_sdk.PacketHandler(2.0).ping(port, 1) == (1060, 0, 0)
    port.closePort()
