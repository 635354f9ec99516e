"""Dynamixel servos on one wire, their shafts where the test puts them, and the frames that they speak."""

import numpy as np

from hal.register_map import ServoModel
from robotwalk.config import library
from sim_backend.device import Reply
from sim_backend.dynamixel_device import DynamixelDevice
from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.servo_physics import ServoPhysics

ROWS = library.open_document("servos", "xl430-w250").value(())
MODEL = ServoModel.model_validate(ROWS)
BAUD = 1_000_000
MS = 1_000_000


class Bus:
    """Servos on one wire, their shafts where the test puts them; time passes by hand."""

    def __init__(self, *ids: int, model: ServoModel = MODEL, **factory_settings: int) -> None:
        settings = {"baud_rate": 3, **factory_settings}
        self.physics = ServoPhysics([model] * len(ids))
        self.servos = [DynamixelServo(self.physics, i, id=servo_id, **settings) for i, servo_id in enumerate(ids)]
        self.device = DynamixelDevice(self.servos)
        self.now = 10 * MS
        self.place(*[2048] * len(ids))

    def place(self, *counts: int) -> None:
        angles = (np.array(counts) - 2048) * (2.0 * np.pi / 4096)
        self.physics.step(angles, np.zeros(len(counts)), self.now)

    def pass_time(self, ms: float) -> None:
        self.now += round(ms * MS)
        self.physics.step(np.zeros(len(self.servos)), np.zeros(len(self.servos)), self.now)

    def send(self, data: bytes, baud: int = BAUD) -> list[Reply]:
        self.now += MS
        return self.device.receive(data, self.now, baud)

    def ask(self, instruction: bytes) -> list[bytes]:
        return [reply.data for reply in self.send(instruction)]


def crc(data: bytes) -> int:
    """CRC-16, polynomial 0x8005, bit by bit."""
    value = 0
    for byte in data:
        value ^= byte << 8
        for _ in range(8):
            value = (value << 1 ^ 0x8005 if value & 0x8000 else value << 1) & 0xFFFF
    return value


def frame(servo_id: int, body: bytes) -> bytes:
    """Return a whole frame around an instruction and its parameters, already stuffed."""
    head = b"\xff\xff\xfd\x00" + bytes([servo_id]) + (len(body) + 2).to_bytes(2, "little") + body
    return head + crc(head).to_bytes(2, "little")


def write(servo_id: int, address: int, data: bytes) -> bytes:
    return frame(servo_id, b"\x03" + address.to_bytes(2, "little") + data)


def read(servo_id: int, address: int, length: int) -> bytes:
    return frame(servo_id, b"\x02" + address.to_bytes(2, "little") + length.to_bytes(2, "little"))


def status(servo_id: int, error: int, data: bytes = b"") -> bytes:
    return frame(servo_id, bytes([0x55, error]) + data)
