"""Servos of one model on a wire in simulated time, and a witness of all that is said there."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from robotwalk.assembly import load_servo
from sim_backend.brands import make_device, make_servo
from sim_backend.device import Device, Reply
from sim_backend.servo_physics import ServoPhysics
from sim_backend.simulated_clock import SimulatedClock
from sim_backend.wire import SimulatedPort

MS = 1_000_000
S = 1_000_000_000
BAUD = 1_000_000


_REFUSALS = {"dynamixel-2.0": 0x7F, "dynamixel-1.0": 0x5A, "feetech": 0}  # bits of the error byte
_BROADCAST = 0xFE
_QUESTIONS = {0x01, 0x82, 0x8A, 0x92, 0x9A}  # of the instructions to all, those that are answered


class Witness:
    """Stands at the servos' end of the wire.

    Attributes:
        instructions: those that were obeyed: answered without a refusal, or sent to all where nobody answers.
        errors: that were answered. Of Protocol 2.0, the numbers and the alert bit; of the others, the bits.
        garble: whether the next instruction gets a bit turned on its way.
    """

    def __init__(self, device: Device, frames: str) -> None:
        self._device, self._frames = device, frames
        self.instructions: set[int] = set()
        self.errors: set[int] = set()
        self.garble = False

    def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
        if self.garble:
            self.garble, data = False, data[:-1] + bytes((data[-1] ^ 1,))
        replies = self._device.receive(data, now, baud)
        at_id, at_instruction, at_error = (4, 7, 8) if self._frames == "dynamixel-2.0" else (2, 4, 4)
        errors = [reply.data[at_error] for reply in replies if len(reply.data) > at_error]
        frames = list(self._split(data))
        for frame in frames:  # a client may send on behind what nobody answers
            self._note(frame[at_id], frame[at_instruction], errors if frame is frames[-1] else [])
        return replies

    def _split(self, data: bytes) -> Iterator[bytes]:
        while len(data) > 7 if self._frames == "dynamixel-2.0" else len(data) > 4:
            end = 7 + data[5] + 256 * data[6] if self._frames == "dynamixel-2.0" else 4 + data[3]
            yield data[:end]
            data = data[end:]

    def _note(self, servo_id: int, instruction: int, errors: list[int]) -> None:
        answered = bool(errors) or (servo_id == _BROADCAST and instruction not in _QUESTIONS)
        if answered and not any(error & _REFUSALS[self._frames] for error in errors):
            self.instructions.add(instruction)
        for error in errors:
            if self._frames == "dynamixel-2.0":
                self.errors |= {error & 0x7F, error & 0x80} - {0}
            else:
                self.errors |= {1 << bit for bit in range(8) if error >> bit & 1}


class TourBench:
    """Servos of one model, their shafts held where the test puts them."""

    def __init__(
        self, name: str, *ids: int, switches: Mapping[str, object] = {}, clock: SimulatedClock | None = None,
        step_ns: int = MS, frames: str | None = None, **settings: int,
    ) -> None:
        model = load_servo(name)
        self.model = model.model_copy(update={"firmware": model.firmware.model_copy(update=switches)})
        self.physics = ServoPhysics([self.model] * len(ids))
        megabaud = self.model.baud_value(BAUD)
        self.servos: list[Any] = [
            make_servo(
                self.physics, index, id=servo_id, **{"baud_rate": megabaud, "return_delay_time": 0, **settings})
            for index, servo_id in enumerate(ids)]
        self.clock = clock or SimulatedClock()
        self._step_ns = step_ns
        self.witness = Witness(make_device("tour", self.servos), frames or self.model.frames)
        self.port = SimulatedPort(self.clock, self.witness, BAUD)
        self.turned = 0.0  # of all shafts, counts
        self._step()

    def pass_time(self, seconds: float) -> None:
        self.clock.wait((), self.clock.now() + round(seconds * S))
        self.port.read()

    def _step(self) -> None:
        angle = self.turned * self.model.encoder.radians_per_tick
        count = len(self.servos)
        self.physics.step(np.full(count, angle), np.zeros(count), self.clock.now())
        self.clock.schedule(self.clock.now() + self._step_ns, self._step)
