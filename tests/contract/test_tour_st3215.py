"""The PyPI package st3215, as it is but for the port, on every STS model in simulated time."""

import threading
from typing import Any

import pytest

from hal.maintenance.sdk_port import SdkPort

from .reference_list import STS
from .tour_bench import BAUD, TourBench

st3215 = pytest.importorskip("st3215", reason="st3215 is not installed")


def client(bench: TourBench) -> Any:
    """Its constructor opens a serial port; all else of it is as it is."""
    servos = st3215.ST3215.__new__(st3215.ST3215)
    servos.portHandler = SdkPort(bench.port, bench.clock)
    st3215.protocol_packet_handler.protocol_packet_handler.__init__(servos, servos.portHandler)
    servos.lock = threading.Lock()
    return servos


@pytest.mark.parametrize("name", STS)
def test_all_that_it_does(name: str) -> None:
    bench = TourBench(name, 1, 2)
    servos = client(bench)
    assert [servos.PingServo(servo_id) for servo_id in (1, 2, 3)] == [True, True, False]
    assert (servos.ReadPosition(1), servos.ReadTemperature(1), servos.ReadMode(1)) == (2048, 30, 0)
    assert servos.ReadVoltage(1) == pytest.approx(bench.model.specification.rated.voltage_v)
    assert (servos.ReadLoad(1), servos.ReadCurrent(1), servos.ReadSpeed(1)[0]) == (0, 0, 0)
    assert set(servos.ReadStatus(1).values()) == {True}
    assert servos.MoveTo(1, 2500, speed=1000, acc=20)
    goals = ("goal_position", "goal_velocity", "acceleration", "torque_enable", "operating_mode")
    assert servos.StartServo(1)
    assert [bench.servos[0].table[name] for name in goals] == [2500, 1000, 20, 1, 0]
    bench.pass_time(0.05)
    assert servos.IsMoving(1)
    assert servos.StopServo(1)
    bench.turned = 70
    bench.pass_time(0.01)
    assert servos.DefineMiddle(1)
    assert (servos.ReadPosition(1), servos.ReadCorrection(1)) == (2048, 70)
    assert servos.CorrectPosition(1, -5) == (0, 0)
    assert servos.ReadCorrection(1) == -5
    assert servos.ReadPosition(1) == 2048 + 70 + 5, "what is shown is the actual position less the correction"
    servos.SetMode(1, 1)
    assert servos.Rotate(1, -300) == (0, 0)
    assert bench.servos[0].table["goal_velocity"] == -300

    assert servos.ChangeId(1, 7) is None
    bench.pass_time(0.01)
    assert servos.PingServo(7)
    assert servos.ChangeBaudrate(7, 4) is None
    bench.pass_time(0.01)
    assert not servos.PingServo(7)
    bench.port.baud = 115_200
    assert servos.PingServo(7)
    bench.port.baud = BAUD
    bench.physics.temperature_c[1] = 90.0
    bench.pass_time(0.01)
    assert not servos.PingServo(2), "what answers with a fault it takes for absent"
    assert bench.witness.errors == {0x04}
