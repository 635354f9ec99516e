"""Which firmware and which device simulate a servo."""

from collections.abc import Callable, Sequence

from sim_backend.ax_firmware import AxServo
from sim_backend.device import Device
from sim_backend.dynamixel1_device import Dynamixel1Device
from sim_backend.dynamixel_device import DynamixelDevice
from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.fake_servo import FakeServo
from sim_backend.feetech_device import FeetechDevice
from sim_backend.scs_firmware import ScsServo
from sim_backend.servo_physics import ServoPhysics
from sim_backend.sts_firmware import StsServo

_FIRMWARE: dict[str, Callable[..., FakeServo]] = {  # by the kind in a servo's file
    "dynamixel-x": DynamixelServo,
    "dynamixel-ax": AxServo,
    "feetech-sts": StsServo,
    "feetech-scs": ScsServo,
}
_DEVICES: dict[str, Callable[..., Device]] = {  # by what is spoken on the wire
    "dynamixel-2.0": DynamixelDevice,
    "dynamixel-1.0": Dynamixel1Device,
    "feetech": FeetechDevice,
}


def make_servo(physics: ServoPhysics, index: int, **factory_settings: int) -> FakeServo:
    """Return the servo of one entry of `physics`, new but for some registers of the EEPROM."""
    return _FIRMWARE[physics.models[index].firmware.kind](physics, index, **factory_settings)


def make_device(name: str, servos: Sequence[FakeServo]) -> Device:
    """Return the far end of the bus `name`.

    Raises:
        ValueError: its servos do not share their frames.
    """
    frames = sorted({servo.model.frames for servo in servos})
    if len(frames) != 1:
        raise ValueError(f"bus {name}: one wire carries one protocol, not {' and '.join(frames) or 'none'}")
    return _DEVICES[frames[0]](servos)
