"""A bench over fake servos of either brand, on a simulated wire that the tests can tamper with."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from hal.maintenance.bench import Bench
from robotwalk.assembly import load_servo
from sim_backend.adapter import Adapter
from sim_backend.brands import make_device, make_servo
from sim_backend.device import Device, Reply
from sim_backend.servo_physics import ServoPhysics
from sim_backend.simulated_clock import SimulatedClock
from sim_backend.wire import SimulatedPort

MODELS = tuple(map(load_servo, ("xl430-w250", "sts3215", "sts3215-12v", "sts3250", "scs15", "scs0009")))
XL430, STS3215, *_ = MODELS
MEGABAUD = {model.name: model.baud_value(1_000_000) for model in MODELS}  # values of baud_rate
BAUD_57600 = {model.name: model.baud_value(57_600) for model in MODELS}
MS = 1_000_000
S = 1_000_000_000

Tamper = Callable[[bytes, list[Reply]], list[Reply]]


class TamperedDevice:
    """The servos of a bus, with someone at the wire who counts what goes there and may change what comes back."""

    def __init__(self, device: Device) -> None:
        self.device = device
        self.tamper: Tamper = lambda sent, replies: replies
        self.heard: list[bytes] = []

    def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
        self.heard.append(data)
        return self.tamper(data, self.device.receive(data, now, baud))


class Rig(NamedTuple):
    bench: Bench
    device: TamperedDevice
    clock: SimulatedClock
    port: SimulatedPort
    servos: list[Any]

    def writes_to(self, address: int) -> list[bytes]:
        """Return the data of all writes to a single servo that begin at an address."""
        found = []
        for frame in self.device.heard:
            if frame.startswith(b"\xff\xff\xfd\x00") and frame[7] == 3 and frame[8] | frame[9] << 8 == address:
                found.append(frame[10:-2])
            elif not frame.startswith(b"\xff\xff\xfd") and frame[4] == 3 and frame[5] == address:
                found.append(frame[6:-1])
        return found


def rig(name: str, *ids: int, adapter: Adapter | None = None, firmware: Any = None, **settings: int) -> Rig:
    """Servos of one model at 1 Mbaud, unless `settings` of their EEPROM say otherwise."""
    return mixed([name] * len(ids), *ids, adapter=adapter, firmware=firmware, **settings)


def mixed(
    names: Sequence[str], *ids: int, adapter: Adapter | None = None, firmware: Any = None, **settings: int
) -> Rig:
    """Servos of several models, by their names."""
    known = {model.name: model for model in MODELS}
    models = [known[name] for name in names]
    if firmware:
        models = [
            model.model_copy(update={"firmware": model.firmware.model_copy(update=firmware)}) for model in models]
    physics = ServoPhysics(models)
    servos = [
        make_servo(physics, i, id=servo_id, **{"baud_rate": MEGABAUD[names[i]], "return_delay_time": 0, **settings})
        for i, servo_id in enumerate(ids)]
    physics.step(np.zeros(len(ids)), np.zeros(len(ids)), 0)
    clock = SimulatedClock()
    device = TamperedDevice(make_device("bench", servos))
    port = SimulatedPort(clock, device, 1_000_000, adapter)
    return Rig(Bench(port, clock, MODELS), device, clock, port, servos)


class TickingClock:
    """A clock that goes on a little at every wait, however much there is to read."""

    def __init__(self) -> None:
        self.time = 0

    def now(self) -> int:
        return self.time

    def wait(self, ports: object, deadline: int) -> None:
        self.time = min(deadline, self.time + 100_000)


class Chatter:
    """A line on which bytes never end."""

    baud = 1_000_000

    def __init__(self, noise: bytes) -> None:
        self.noise = noise

    def fileno(self) -> int:
        return -1

    def write(self, data: bytes) -> None:
        pass

    def waiting(self) -> int:
        return len(self.noise)

    def read(self) -> bytes:
        return self.noise

    def close(self) -> None:
        pass
