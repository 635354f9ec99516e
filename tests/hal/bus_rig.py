"""Five servos on one simulated wire, and someone who listens to it and may tamper with it."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hal import dynamixel_protocol
from hal.calibration import Calibration
from hal.servo_bus import SerialServoBus
from hal.servo_line import ServoLine
from hal.wired import Wired
from robotwalk.assembly import load_servo
from sim_backend.device import Reply
from sim_backend.dynamixel_device import DynamixelDevice
from sim_backend.dynamixel_firmware import DynamixelServo
from sim_backend.servo_physics import ServoPhysics
from sim_backend.simulated_clock import SimulatedClock
from sim_backend.wire import SimulatedPort

MODEL = load_servo("xl430-w250")
TICK = 2.0 * math.pi / 4096  # rad
PERIOD = 10_000_000  # ns
COUNT = 5
FAST, PLAIN = 45, 44  # firmware with and without fast sync read

Tamper = Callable[[list[Reply]], list[Reply]]


class Device:
    """The servos of a bus, with someone at the wire on its way back, who also counts what goes there."""

    def __init__(self, device: DynamixelDevice) -> None:
        self.device = device
        self.tamper: Tamper = lambda replies: replies
        self.lose: Callable[[bytes], bytes] = lambda data: data
        self.heard: list[bytes] = []

    def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
        self.heard.append(data)
        return self.tamper(self.device.receive(self.lose(data), now, baud))


class Rig(NamedTuple):
    """Joints j0, j1 ... on one bus, their shafts held by a vice at `shafts` (rad)."""

    bus: SerialServoBus
    device: Device
    clock: SimulatedClock
    servos: list[DynamixelServo]
    physics: ServoPhysics
    line: ServoLine

    def hold(self, shafts: list[float], speeds: list[float] | None = None) -> None:
        """Turn the shafts there, and keep them."""
        self.physics.step(np.array(shafts), np.array(speeds or [0.0] * COUNT), self.clock.now())


def rig(firmware: int = FAST) -> Rig:
    clock = SimulatedClock()
    physics = ServoPhysics([MODEL] * COUNT)
    servos = [
        DynamixelServo(physics, i, id=i + 1, baud_rate=3, return_delay_time=0, firmware_version=firmware)
        for i in range(COUNT)]
    device = Device(DynamixelDevice(servos))
    port = SimulatedPort(clock, device, 1_000_000)
    wired = [
        Wired(
            f"j{i}", f"limb{i // 2}", i, i + 1, MODEL,
            Calibration(-1 if i == 1 else 1, 0.5 if i == 2 else 0.0, 2048, TICK), -1.0, 1.0)
        for i in range(COUNT)]
    line = ServoLine("legs", port, 1_000_000, dynamixel_protocol, wired)
    built = Rig(SerialServoBus([f"j{i}" for i in range(COUNT)], [line], clock), device, clock, servos, physics, line)
    built.hold([0.0] * COUNT)
    return built


def armed(firmware: int = FAST) -> Rig:
    built = rig(firmware)
    built.bus.arm(PERIOD)
    built.device.heard.clear()
    return built


def next_tick(built: Rig) -> None:
    built.clock.wait((), built.clock.now() + PERIOD // 2)
    built.bus.exchange([0.0] * COUNT, PERIOD)
