"""ROBOTIS's dynamixel_easy_sdk on every model of the X series and the MX, in simulated time."""

import pytest
from dynamixel_easy_sdk.connector import Connector
from dynamixel_easy_sdk.data_types import OperatingMode
from dynamixel_easy_sdk.dynamixel_error import DxlError, DxlRuntimeError
from dynamixel_easy_sdk.motor import Motor
from dynamixel_sdk import PacketHandler

from hal.maintenance.sdk_port import SdkPort

from .reference_list import MX, X_SERIES
from .tour_bench import TourBench

AWAY = 0.31  # s, silent after a restart


def connected(bench: TourBench) -> Connector:
    """Its constructor opens a serial port; all else of it is as it is."""
    connector = Connector.__new__(Connector)
    connector._port_handler = SdkPort(bench.port, bench.clock)
    Connector._packet_handler = PacketHandler(Connector.PROTOCOL_VERSION)
    return connector


def refusal(motor: Motor, address: int, value: int) -> DxlError | None:
    with pytest.raises(DxlRuntimeError) as caught:
        motor.connector.write1ByteData(motor.id, address, value)
    return caught.value.dxl_error


@pytest.mark.parametrize("name", X_SERIES + MX)
def test_motors_and_groups(name: str) -> None:
    bench = TourBench(name, 1, 2)
    connector = connected(bench)
    first, second = motors = connector.createAllMotors()
    assert [motor.model_number for motor in motors] == [bench.model.model_number] * 2
    assert [first.getOperatingMode(), first.getMaxPositionLimit(), first.getPresentPosition()] == [
        OperatingMode.POSITION, 4095, 2048]
    first.setOperatingMode(OperatingMode.EXTENDED_POSITION)
    first.setPositionPGain(500)
    first.enableTorque()
    first.setGoalPosition(-100)
    assert bench.servos[0].table["goal_position"] == -100
    assert refusal(first, 9, 0) is DxlError.SDK_ERRNUM_ACCESS
    assert refusal(first, 64, 2) is DxlError.SDK_ERRNUM_DATA_RANGE
    assert refusal(first, 116, 1) is DxlError.SDK_ERRNUM_DATA_LENGTH
    if "current_limit" in bench.model.by_name:
        assert first.getCurrentLimit() == bench.model["current_limit"].default

    group = connector.createGroupExecutor()
    for motor in motors:
        group.addCmd(motor.stageLEDOn())
    group.executeWrite()
    bench.pass_time(0.01)
    assert [motor.isLEDOn() for motor in motors] == [1, 1]
    group.clearStagedWriteCommands()
    group.addCmd(first.stageLEDOff())
    group.addCmd(second.stageEnableTorque())
    group.executeWrite()
    bench.pass_time(0.01)
    for motor in motors:
        group.addCmd(motor.stageGetPresentPosition())
    assert group.executeRead() == [2048, 2048]
    group.clearStagedReadCommands()
    group.addCmd(first.stageIsLEDOn())
    group.addCmd(second.stageIsTorqueOn())
    assert group.executeRead() == [0, 1]

    first.disableTorque()
    first.changeID(7)
    assert first.ping() == bench.model.model_number
    first.reboot()
    bench.pass_time(AWAY)
    first.factoryResetExceptIDAndBaudRate()
    bench.pass_time(AWAY)
    assert bench.servos[0].id == 7
    assert bench.servos[0].table["operating_mode"] == 3
    assert bench.witness.instructions >= {0x01, 0x02, 0x03, 0x06, 0x08, 0x82, 0x83, 0x92, 0x93}
