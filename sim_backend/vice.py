"""Fake servos on the bench, their shafts held in a vice: the wire and what is on it, without a body in motion.

For measuring a bus alone: nothing else competes for the processor.
"""

import gc
import time
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hal.register_map import ServoModel
from robotwalk.realtime import raise_priority, sharpen_timers
from sim_backend.adapter import ADAPTERS, AdapterName
from sim_backend.brands import make_device, make_servo
from sim_backend.endpoint import Endpoint
from sim_backend.pty_endpoint import open_ptys
from sim_backend.real_time import RealTime
from sim_backend.server import Server
from sim_backend.servo_physics import ServoPhysics
from sim_backend.simulated_clock import SimulatedClock
from sim_backend.wire import SimulatedPort

_QUESTION = 0.2  # s between looks whether the parent is still there
_HEARTBEAT = 20_000_000  # ns between looks at the shafts


class BenchServo(NamedTuple):
    """One servo to be made, and the angle at which its shaft is held."""

    bus: str
    id: int
    model: ServoModel
    angle: float  # rad from the encoder's centre


class Bench:
    """The servos, one simulated port per bus, one clock. Return delay 0."""

    def __init__(
        self, servos: Sequence[BenchServo], bauds: Mapping[str, int], adapter: AdapterName = "none"
    ) -> None:
        self.clock = SimulatedClock()
        self._physics = ServoPhysics([servo.model for servo in servos])
        self._angles = np.array([servo.angle for servo in servos])
        self._hold()
        made = [
            make_servo(
                self._physics, index, id=servo.id, baud_rate=servo.model.baud_value(bauds[servo.bus]),
                return_delay_time=0)
            for index, servo in enumerate(servos)]
        self.servos = made
        self.ports = {
            bus: SimulatedPort(
                self.clock,
                make_device(bus, [fake for fake, servo in zip(made, servos, strict=True) if servo.bus == bus]), baud,
                ADAPTERS[adapter]())
            for bus, baud in bauds.items()}

    def turn(self, servo: int, angle: float) -> None:
        """Turn a servo's shaft, and hold it there (rad)."""
        self._angles[servo] = angle

    def _hold(self) -> None:
        self._physics.step(self._angles, np.zeros(len(self._angles)), self.clock.now())
        self.clock.schedule(self.clock.now() + _HEARTBEAT, self._hold)


def serve_bench(servos: Sequence[BenchServo], bauds: Mapping[str, int], folder: Path, parent: Connection) -> None:
    """Serve the servos as terminals in a folder, until the parent hangs up: the body of a process of its own.

    The parent is sent the URLs by bus.
    """
    bench = Bench(servos, bauds)
    doors: AbstractContextManager[Mapping[str, Endpoint]] = open_ptys(folder, bauds)
    gc.collect()
    gc.freeze()
    sharpen_timers()
    raise_priority()
    with doors as endpoints:
        server = Server(bench, endpoints, RealTime(bench.clock.now()), lambda text: None)
        parent.send({bus: endpoint.url for bus, endpoint in endpoints.items()})

        asked = time.monotonic()

        def check() -> None:
            nonlocal asked
            if time.monotonic() - asked > _QUESTION:
                asked = time.monotonic()
                if parent.poll():
                    raise EOFError

        try:
            server.run(check, seconds=None)
        except EOFError:
            return
