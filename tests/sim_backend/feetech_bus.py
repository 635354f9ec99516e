"""Feetech servos on one wire, their shafts where the test puts them, and a port for Feetech's SDK to reach them."""

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from hal.register_map import ServoModel
from robotwalk.assembly import load_servo
from sim_backend.brands import make_device, make_servo
from sim_backend.device import Reply
from sim_backend.servo_physics import ServoPhysics

BAUD = 1_000_000
MS = 1_000_000


class Bus:
    """Servos on one wire; time passes by hand."""

    def __init__(
        self, *ids: int, models: Sequence[str] = ("sts3215",), firmware: Mapping[str, object] = {},
        **factory_settings: int,
    ) -> None:
        """Put a servo of each of `models` there; if it is one, all ids have it. `firmware` holds other switches."""
        names = models if len(models) > 1 else [*models] * len(ids)
        self.models = [_model(name, **firmware) for name in names]
        self.physics = ServoPhysics(self.models)
        self.servos = [
            make_servo(self.physics, i, id=servo_id, **factory_settings) for i, servo_id in enumerate(ids)]
        self.device = make_device("test", self.servos)
        self.now = 10 * MS
        self.place(*[model.encoder.centre for model in self.models])

    def place(self, *counts: int) -> None:
        encoders = [model.encoder for model in self.models]
        angles = [(at - row.centre) * row.radians_per_tick for at, row in zip(counts, encoders, strict=True)]
        self.physics.step(np.array(angles), np.zeros(len(counts)), self.now)

    def send(self, data: bytes, baud: int = BAUD) -> list[Reply]:
        self.now += MS
        return self.device.receive(data, self.now, baud)

    def ask(self, instruction: bytes) -> list[bytes]:
        return [reply.data for reply in self.send(instruction)]

    def table(self, name: str) -> list[int]:
        return [servo.table[name] for servo in self.servos]


@cache
def _model(name: str, **firmware: object) -> ServoModel:
    model = load_servo(name)
    return model.model_copy(update={"firmware": model.firmware.model_copy(update=firmware)})


def frame(servo_id: int, body: bytes) -> bytes:
    """Return a whole frame around an instruction, or an error byte, and what follows it."""
    inner = bytes([servo_id, len(body) + 1]) + body
    return b"\xff\xff" + inner + bytes([255 - sum(inner) % 256])


class Port:
    """What Feetech's SDK needs of a port, with the fake bus behind it."""

    def __init__(self, bus: Bus) -> None:
        self.bus = bus
        self.is_using = False
        self._received = b""

    def clearPort(self) -> None:
        self._received = b""

    def writePort(self, packet: list[int]) -> int:
        self._received += b"".join(self.bus.ask(bytes(packet)))
        return len(packet)

    def readPort(self, length: int) -> list[int]:
        data, self._received = self._received[:length], self._received[length:]
        return list(data)

    def setPacketTimeout(self, packet_length: int) -> None:
        pass

    def isPacketTimeout(self) -> bool:
        return not self._received
