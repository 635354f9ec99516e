"""AX-12A servos on a simulated bus, each of which turns a shaft; what is asked of it is the first one's."""

from typing import Any

from hal.register_map import ServoModel
from robotwalk.assembly import load_servo
from sim_backend.ax_firmware import AxServo
from sim_backend.dynamixel1_device import Dynamixel1Device
from sim_backend.servo_physics import ServoPhysics

from .rig import MS, Hinge, Turning

MODEL = load_servo("ax-12a")
STEP = 300.0 / 1024.0  # deg


def model_with(firmware: dict[str, Any] | None) -> ServoModel:
    return MODEL.model_copy(update={"firmware": MODEL.firmware.model_copy(update=firmware or {})})


class AxBus(Turning):
    """Speaks bytes to servos without return delay; the checksums are the test's own."""

    def __init__(self, *ids: int, firmware: dict[str, Any] | None = None, **eeprom: int) -> None:
        self.physics = ServoPhysics([model_with(firmware)] * len(ids))
        self.servos = [
            AxServo(self.physics, i, id=servo_id, **{"return_delay_time": 0, **eeprom})
            for i, servo_id in enumerate(ids)]
        self.device = Dynamixel1Device(self.servos)
        self.baud = 1_000_000
        self.now = 0
        self.hinge = Hinge(self.physics)
        self.run(0.01)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 1000)):
            self.now += MS
            self.hinge.step(self.now)

    def send(self, servo_id: int, instruction: int, *parameters: int) -> bytes:
        """Send an instruction; return what comes back."""
        body = bytes((servo_id, len(parameters) + 2, instruction, *parameters))
        return self.raw(b"\xff\xff" + body + bytes((255 - sum(body) % 256,)))

    def raw(self, data: bytes) -> bytes:
        self.now += 2 * MS  # longer than the gap that parts two frames
        return b"".join(reply.data for reply in self.device.receive(data, self.now, self.baud))

    def read(self, servo_id: int, address: int, length: int) -> bytes:
        """Return the data of a read, whatever the conditions."""
        answer = self.send(servo_id, 2, address, length)
        assert answer[:4] == bytes((0xFF, 0xFF, servo_id, length + 2))
        return answer[5:-1]

    def word(self, address: int) -> int:
        return int.from_bytes(self.read(1, address, 2), "little")

    def write(self, address: int, *data: int) -> int:
        """Write to servo 1; return the error byte."""
        answer = self.send(1, 3, address, *data)
        assert len(answer) == 6
        return answer[4]

    def write_word(self, address: int, value: int) -> int:
        return self.write(address, value & 0xFF, value >> 8)
