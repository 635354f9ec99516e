"""How torque goes off on a bus of Dynamixel fakes, and what is said where that cannot be confirmed."""

from .bus_rig import COUNT, armed


def test_torque_that_cannot_be_confirmed_off_is_said() -> None:
    built = armed()
    built.device.lose = lambda data: b""
    assert built.bus.disarm() == ["j0", "j1", "j2", "j3", "j4"]
    built.device.lose = lambda data: data
    assert built.bus.disarm() == []
    assert [servo.table["torque_enable"] for servo in built.servos] == [0] * COUNT


def test_torque_goes_off_even_where_every_broadcast_is_lost() -> None:
    built = armed()
    built.device.lose = lambda data: b"" if data[4] == 0xFE else data
    assert built.bus.disarm() == []
    assert [servo.table["torque_enable"] for servo in built.servos] == [0] * COUNT


def test_disarming_reaches_everyone_and_never_raises() -> None:
    built = armed()
    built.bus.disarm()
    assert [servo.table["torque_enable"] for servo in built.servos] == [0] * COUNT

    def broken(data: bytes) -> None:
        raise OSError("the cable is out")

    built.line.port.write = broken  # type: ignore[method-assign]  # as a cable would, which no fault script pulls here
    assert built.bus.disarm() == ["j0", "j1", "j2", "j3", "j4"]
    built.bus.close()
